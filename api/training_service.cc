#include "api/training_service.h"

#include <algorithm>
#include <cstdio>
#include <cstdint>
#include <ctime>
#include <iostream>
#include <optional>
#include <random>
#include <system_error>

#include "api/error_mapping.h"
#include "api/training.h"
#include "datasets/atomic_file.h"
#include "datasets/errors.h"
#include "datasets/manifest.h"
#include "graph/graph_builder.h"
#include "graph/model_io.h"
#include "primitives/keyframe_labels.h"

namespace morphograph {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxWaiting = 16;
constexpr std::uintmax_t kMaxWaitingBytes = std::uintmax_t{1} << 30;  // of uploads on disk, before another is taken
constexpr int kKeptJobs = 1000;
constexpr std::size_t kMaxDetail = 2000;

std::string Now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  return {text, std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc)};
}

// File stems say the style, so they are kept where they are harmless; a number in front keeps them apart.
std::string SafeStem(const std::string& sent) {
  std::string stem = fs::path(sent.substr(sent.find_last_of("/\\") + 1)).stem().string();
  if (stem.size() > 100) stem.resize(100);
  for (char& c : stem) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    if (!plain) c = '_';
  }
  return stem.empty() ? "clip" : stem;
}

// Not to be guessed: whoever has a job's id may cancel it.
std::string NewId() {
  std::random_device entropy;
  std::string id;
  for (int i = 0; i < 4; ++i) {
    char part[9];
    std::snprintf(part, sizeof part, "%08x", entropy());
    id += part;
  }
  return id;
}

// What an upload may take in memory: copies are made of its clips (mirrored, bent), so a set of 640 MB becomes some 2 GB.
DatasetLimits UploadLimits() {
  DatasetLimits limits;
  limits.file.max_values = 40'000'000;
  limits.file.max_joint_frames = 10'000'000;
  limits.max_joint_frames = 20'000'000;
  return limits;
}

void MakeFolder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw std::runtime_error("cannot use " + path.string() + ": " + error.message());
}

// What of an upload can be judged at once, so that the client hears of it now. Files are what the upload itself holds: a manifest may
// name no others.
void CheckUpload(const TrainingUpload& upload) {
  if (upload.clips.empty()) throw ProblemError(400, "there is no BVH file among the parts; send each with a file name");
  if (!upload.name.empty() && !IsModelName(upload.name)) {
    Problem problem{400, "the settings are malformed", {}, {}, {}};
    problem.errors = {{"/name", "must be 1 to 64 letters, digits, '.', '_' or '-', the first a letter or digit"}};
    throw ProblemError(std::move(problem));
  }
  DatasetManifest manifest;
  if (!upload.manifest.empty()) manifest = ParseManifest(upload.manifest, "manifest");
  if (!upload.keyframes.empty()) ParseKeyframeLabels(upload.keyframes, "keyframes");
  if (!manifest.keyframe_examples.empty()) {
    const std::string file = manifest.keyframe_examples.string();
    if (file.find_first_of("/\\") != std::string::npos || file.find("..") != std::string::npos)
      throw DatasetError("manifest", "/keyframes: a path leads out of the upload; name a file, and send it as part 'keyframes'");
    if (upload.keyframes.empty())
      throw DatasetError("manifest", "/keyframes: names a file that is not there; send it as part 'keyframes'");
  }
  CheckTraining(upload.name, upload.action.empty() ? std::nullopt : std::optional(upload.action), manifest,
                !upload.keyframes.empty());
}

std::uintmax_t BytesIn(const fs::path& folder) {
  std::uintmax_t bytes = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code ignored;  // it may go while we look
    const std::uintmax_t size = entry->is_regular_file(ignored) ? entry->file_size(ignored) : 0;
    if (!ignored) bytes += size;
  }
  return bytes;
}

void WriteUpload(const TrainingUpload& upload, const fs::path& folder) {
  int number = 0;
  for (const auto& [name, text] : upload.clips) {
    // A folder each: the stem is what styles, manifests and labels go by, and two files may have the same.
    char place[16];
    std::snprintf(place, sizeof place, "%05d", number++);
    MakeFolder(folder / "clips" / place);
    WriteFileAtomically(folder / "clips" / place / (SafeStem(name) + ".bvh"), text);
  }
  if (!upload.manifest.empty()) WriteFileAtomically(folder / "manifest.json", upload.manifest);
  if (!upload.keyframes.empty()) WriteFileAtomically(folder / "keyframes.json", upload.keyframes);
}

// Folders are the server's own; the client sees the name of the file.
std::string WithoutFolders(std::string text, const fs::path& uploads) {
  const std::string clips = (uploads / "clips").string() + "/", others = uploads.string() + "/";
  for (std::size_t at; (at = text.find(clips)) != std::string::npos;) {
    std::size_t end = at + clips.size();
    const std::size_t number = text.find_first_not_of("0123456789", end);
    if (number != std::string::npos && number > end && text[number] == '/') end = number + 1;
    text.erase(at, end - at);
  }
  for (std::size_t at; (at = text.find(others)) != std::string::npos;) text.erase(at, others.size());
  return text;
}

}  // namespace

TrainingService::TrainingService(Service* service, fs::path folder, const std::string& database_url, int threads)
    : service_(service),
      folder_((MakeFolder(folder / "models"), MakeFolder(folder / "uploads"), std::move(folder))),
      store_(database_url.empty() ? (folder_ / "jobs.db").string() : database_url),
      threads_(threads) {
  LoadModels();
  CountJobs();
  RemoveLeftOvers();
  worker_ = std::thread([this] { Work(); });
}

TrainingService::~TrainingService() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    cancelled_ = true;
  }
  wake_.notify_all();
  worker_.join();
}

void TrainingService::LoadModels() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder_ / "models"))
    if (entry.path().extension() == ".mgm") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    if (!IsModelName(file.stem().string())) {
      std::cerr << "morphograph: " << file.string() << ": not served, its name cannot name a model\n";
      continue;
    }
    try {
      if (!service_->models.Add(file.stem().string(), LoadModel(file)))
        std::cerr << "morphograph: " << file.string() << ": not served, another model has its name\n";
    } catch (const DatasetError& damaged) {
      std::cerr << "morphograph: not served: " << damaged.what() << "\n";  // one bad file does not stop a server
    }
  }
  service_->metrics.models = static_cast<int>(service_->models.List().size());
}

void TrainingService::RemoveLeftOvers() {
  for (const auto& entry : fs::directory_iterator(folder_ / "uploads")) {
    const auto job = store_.Find(entry.path().filename().string());
    if (job && !job->IsFinished()) continue;
    std::error_code ignored;
    fs::remove_all(entry.path(), ignored);
  }
}

void TrainingService::CountJobs() {
  service_->metrics.jobs_waiting = store_.Count(JobState::kQueued);
  service_->metrics.jobs_running = store_.Count(JobState::kRunning);
}

Job TrainingService::Submit(const TrainingUpload& upload) {
  CheckUpload(upload);
  Job job;
  job.id = NewId();
  job.model = upload.name.empty() ? "model-" + job.id.substr(0, 8) : upload.name;
  job.action = upload.action;
  job.files = static_cast<int>(upload.clips.size());
  job.created = Now();

  {
    const std::lock_guard lock(mutex_);  // two uploads cannot take one name
    if (store_.Count(JobState::kQueued) + static_cast<int>(arriving_.size()) >= kMaxWaiting ||
        BytesIn(folder_ / "uploads") > kMaxWaitingBytes)
      throw ProblemError(Problem{429, "too many training jobs are waiting", {}, 60, {}});
    if (service_->models.Find(job.model) || store_.IsModelAwaited(job.model) || !arriving_.insert(job.model).second)
      throw ProblemError(409, "a model named " + job.model + " is served or being trained");
  }
  // Hundreds of megabytes may have to be written: nobody waits for that.
  const fs::path uploads = folder_ / "uploads" / job.id;
  try {
    WriteUpload(upload, uploads);
    const std::lock_guard lock(mutex_);
    store_.Insert(job);
    arriving_.erase(job.model);
    CountJobs();
    changed_ = true;
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(uploads, ignored);
    const std::lock_guard lock(mutex_);
    arriving_.erase(job.model);
    throw;
  }
  wake_.notify_all();
  return job;
}

Job TrainingService::Get(const std::string& id) const {
  const auto job = store_.Find(id);
  if (!job) throw ProblemError(404, "there is no job " + Excerpt(id));
  return *job;
}

Job TrainingService::Cancel(const std::string& id) {
  const std::lock_guard lock(mutex_);
  Job job = Get(id);
  if (job.state == JobState::kCancelled) return job;
  if (job.IsFinished()) throw ProblemError(409, "the job has " + std::string(JobStateName(job.state)) + " already");
  if (running_ == id) {
    cancelled_ = true;  // the worker ends the job at its next stop
    job.stage = "being cancelled";
    return job;
  }
  job.state = JobState::kCancelled;
  store_.Update(job);
  std::error_code ignored;
  fs::remove_all(folder_ / "uploads" / id, ignored);
  CountJobs();
  return job;
}

void TrainingService::Work() {
  while (true) {
    Job job;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return stopping_ || changed_; });
      if (stopping_) return;
      try {
        const auto next = store_.NextQueued();
        if (!next) {
          changed_ = false;
          continue;
        }
        job = *next;
        cancelled_ = false;
        running_ = job.id;
        job.state = JobState::kRunning;
        store_.Update(job);
        CountJobs();
      } catch (const std::exception& error) {
        std::cerr << "morphograph: training jobs: " << error.what() << "\n";
        running_.clear();
        changed_ = false;
        continue;
      }
    }
    Run(std::move(job));
  }
}

void TrainingService::Run(Job job) {
  const fs::path uploads = folder_ / "uploads" / job.id;
  TrainingRequest request;
  request.data = {uploads / "clips"};
  if (fs::exists(uploads / "manifest.json")) request.manifest = uploads / "manifest.json";
  if (fs::exists(uploads / "keyframes.json")) request.keyframe_labels = uploads / "keyframes.json";
  request.name = job.model;
  if (!job.action.empty()) request.action = job.action;
  request.limits = UploadLimits();
  request.jobs = threads_;
  request.command = "POST /v1/models";
  request.cancelled = &cancelled_;
  double told = -1;
  request.progress = [&](const std::string& stage, double fraction) {
    if (stage == job.stage && fraction < told + 0.01) return;
    job.stage = stage;
    job.progress = told = fraction;
    store_.Update(job);
  };

  std::shared_ptr<const MotionGraph> graph;
  try {
    const TrainingOutcome outcome = Train(request);
    graph = outcome.graph;
    SaveModel(*graph, folder_ / "models" / (job.model + ".mgm"));
    job.state = JobState::kSucceeded;
    job.progress = 1;
    job.stage = "done";
    for (const std::string& note : outcome.notes) job.detail += note + "\n";
    for (const std::string& note : graph->provenance().notes) job.detail += note + "\n";
    job.detail = Excerpt(job.detail, kMaxDetail);
  } catch (const TrainingCancelled&) {
    job.state = JobState::kCancelled;
  } catch (...) {
    job.state = JobState::kFailed;
    job.detail = WithoutFolders(ProblemLine(ProblemFrom(std::current_exception())), uploads);
    job.detail = Excerpt(job.detail, kMaxDetail);
  }

  const std::lock_guard lock(mutex_);
  running_.clear();
  if (stopping_ && job.state == JobState::kCancelled) {
    // Interrupted by the server's end, not by a client: the next process begins it anew.
    job.state = JobState::kQueued;
    job.stage.clear();
    job.progress = 0;
  }
  try {
    if (job.state == JobState::kSucceeded && !service_->models.Add(job.model, graph)) {
      job.state = JobState::kFailed;
      job.detail = "another model has taken the name";
    }
    store_.Update(job);
    store_.Prune(kKeptJobs);
    CountJobs();
  } catch (const std::exception& error) {
    std::cerr << "morphograph: training jobs: " << error.what() << "\n";
  }
  service_->metrics.models = static_cast<int>(service_->models.List().size());
  if (job.IsFinished()) {
    std::error_code ignored;
    fs::remove_all(uploads, ignored);
  }
}

}  // namespace morphograph
