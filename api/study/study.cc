#include "api/study/study.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>

#include "api/keyframe_examples.h"
#include "api/study/alignment_study.h"
#include "api/study/keyframe_study.h"
#include "api/study/mixture_study.h"
#include "api/study/reduction_study.h"
#include "api/study/sample_study.h"
#include "api/study/sensor_study.h"
#include "api/study/transition_study.h"
#include "api/training.h"
#include "datasets/error_reason.h"
#include "datasets/errors.h"
#include "datasets/manifest.h"
#include "datasets/text_encoding.h"

namespace morphograph {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// A part of the study, in the order of the pipeline.
struct Part {
  std::string id, title;
  double share;  // of the time of all parts, about
  StudySection (*run)(StudyContext&);
};

const std::vector<Part>& Parts() {
  static const std::vector<Part> parts = {
      {"keyframes", "key frames", 60, StudyKeyframes},
      {"alignment", "alignment", 10, StudyAlignment},
      {"reduction", "reduction", 20, StudyReduction},
      {"mixture", "mixture", 40, StudyMixture},
      {"transitions", "transitions", 30, StudyTransitions},
      {"feet_and_flow", "feet and flow of the samples", 20, StudyFeetAndFlow},
      {"likeness", "likeness of synthesised and captured clips", 100, StudyLikeness},
      {"long_walks", "walks of 200 steps", 10, StudyLongWalks},
      {"ablations", "ablations", 150, StudyAblations},
      {"sensors", "motion from four accelerometers", 30, StudySensors},
  };
  return parts;
}

// Times the parts and tells how far the whole study is.
class Course {
 public:
  Course(const StudyOptions& options, double all_shares) : tell_(options.progress), all_shares_(all_shares) {}

  void Begin(const std::string& part, double share) {
    part_ = part, share_ = share, started_ = Clock::now();
    Tell(part, 0);
  }
  void Tell(const std::string& stage, double fraction) const {
    if (tell_) tell_(stage, (done_ + share_ * std::clamp(fraction, 0.0, 1.0)) / all_shares_);
  }
  void End(StudyReport* report) {
    done_ += share_;
    report->times_s.emplace_back(part_, std::chrono::duration<double>(Clock::now() - started_).count());
  }

 private:
  std::function<void(const std::string&, double)> tell_;
  double all_shares_;
  std::string part_;
  double share_ = 0, done_ = 0;
  Clock::time_point started_;
};

std::vector<fs::path> LabelFilesBelow(const std::vector<fs::path>& data) {
  std::set<fs::path> found;
  for (const fs::path& folder : data) {
    std::error_code error;
    if (!fs::is_directory(folder, error)) continue;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied)) {
      const std::string name = entry.path().filename().string();
      if (name.ends_with(".json") && name.find("keyframes") != std::string::npos && entry.is_regular_file(error)) found.insert(entry.path());
    }
  }
  return {found.begin(), found.end()};
}

LabelledClips ReadAllLabels(const std::vector<fs::path>& files) {
  LabelledClips all;
  for (const fs::path& file : files) {
    for (auto& [clip, frames] : ReadKeyframeLabels(file)) {
      if (!all.emplace(clip, frames).second)
        throw DatasetError(file.string(), "labels clip '" + clip + "', which another file of labels has labelled already");
    }
  }
  return all;
}

// A few clips of every style, up to half of them labelled ones, so that a quick study has something to say of everything. Positions, ascending.
std::vector<int> FewClips(const std::vector<LoadedClip>& clips, const std::vector<std::vector<LabelledFrame>>& labels) {
  constexpr size_t kClips = 24, kOfStyle = 6;
  std::map<std::string, std::vector<int>> labelled, others;
  std::set<std::string> styles;
  for (size_t i = 0; i < clips.size(); ++i) {
    (labels[i].empty() ? others : labelled)[clips[i].clip.style].push_back(static_cast<int>(i));
    styles.insert(clips[i].clip.style);
  }
  const size_t each = std::max(kOfStyle, kClips / styles.size());
  std::set<int> chosen;
  for (const std::string& style : styles) {
    const size_t of_others = std::min(others[style].size(), each - std::min(labelled[style].size(), each / 2));
    const size_t of_labelled = std::min(labelled[style].size(), each - of_others);
    for (const int i : SpreadOver(labelled[style], of_labelled)) chosen.insert(i);
    for (const int i : SpreadOver(others[style], of_others)) chosen.insert(i);
  }
  return {chosen.begin(), chosen.end()};
}

std::string LastPart(const fs::path& path) {
  return Utf8FromUnknown((path.has_filename() ? path.filename() : path.parent_path().filename()).string());
}

StudyContext LoadClips(const StudyRequest& request, StudyReport* report, Course* course) {
  DatasetManifest manifest;
  if (request.manifest) manifest = ReadManifest(*request.manifest);
  const bool learned_keyframes = !manifest.keyframe_examples.empty();
  StudyOptions options = request.options;
  options.action = CheckTraining("", std::nullopt, manifest, learned_keyframes).action;
  options.augmentation = AugmentationOf(manifest);
  options.progress = [course](const std::string& stage, double fraction) { course->Tell(stage, fraction); };

  Dataset dataset = LoadDataset(request.data, manifest, request.options.jobs);
  report->clips_read = static_cast<int>(dataset.clips.size());
  report->notes = dataset.notes;
  for (const SkippedClip& skipped : dataset.skipped)
    report->notes.push_back(LastPart(skipped.file) + " left out: " + skipped.reason);
  for (const LoadedClip& loaded : dataset.clips)
    if (!loaded.note.empty()) report->notes.push_back(loaded.clip.name + ": " + loaded.note);
  if (learned_keyframes) {
    const std::string file = manifest.keyframe_examples.string();
    const MatchedLabels matched = MatchLabels(ReadKeyframeLabels(manifest.keyframe_examples), dataset.clips, file);
    std::vector<MotionClip> clips;
    for (const LoadedClip& loaded : dataset.clips) clips.push_back(loaded.clip);
    options.find_keyframes = LearnKeyframes(clips, matched.frames, file);
  }

  const bool given = !request.labels.empty();
  LabelledClips labels = ReadAllLabels(given ? request.labels : LabelFilesBelow(request.data));
  MatchedLabels matched;
  if (!labels.empty()) {
    try {
      matched = MatchLabels(labels, dataset.clips, given ? request.labels.front().string() : "labels below the data");
      report->notes.insert(report->notes.end(), matched.notes.begin(), matched.notes.end());
    } catch (const DatasetError& unfit) {
      if (given) throw;
      report->notes.push_back(std::string(unfit.what()) + "; not used");
      labels.clear();
    }
  }
  matched.frames.resize(dataset.clips.size());
  std::vector<int> used(dataset.clips.size());
  std::iota(used.begin(), used.end(), 0);
  if (request.options.quick) used = FewClips(dataset.clips, matched.frames);
  std::vector<LoadedClip> clips;
  for (const int i : used) {
    clips.push_back(std::move(dataset.clips[i]));
    if (!matched.frames[i].empty()) ++report->labelled_clips;
  }
  return StudyContext(std::move(clips), std::move(labels), std::move(options));
}

std::vector<StudiedStyle> CountStyles(const StudyContext& context) {
  std::vector<StudiedStyle> styles;
  for (const std::string& name : context.styles()) {
    StudiedStyle style{name};
    for (const MotionClip& clip : context.clips(StudyData::kClean)) {
      if (clip.style != name) continue;
      ++style.clips;
      style.frames += clip.frame_count();
      style.duration_s += clip.duration_s();
    }
    styles.push_back(style);
  }
  return styles;
}

}  // namespace

StudyReport RunStudy(const StudyRequest& request) {
  constexpr double kReading = 3, kModel = 15;  // shares of the whole
  StudyReport report;
  report.quick = request.options.quick;
  report.seed = request.options.seed;
  report.noise = request.options.noise;
  report.jobs = request.options.jobs;
  for (const fs::path& path : request.data) report.data.push_back(LastPart(path));

  double all = kReading + 2 * kModel;
  for (const Part& part : Parts()) all += part.share;
  Course course(request.options, all);
  course.Begin("reading clips", kReading);
  StudyContext context = LoadClips(request, &report, &course);
  report.styles = CountStyles(context);
  course.End(&report);

  course.Begin("model of the clean clips", kModel);
  context.Model(StudyData::kClean);  // without it there is nothing to study
  course.End(&report);
  const auto note = [&](const std::string& part, const std::string& why) { report.notes.push_back(part + " left out: " + why); };
  course.Begin("model of the noisy clips", kModel);
  try {
    context.Model(StudyData::kNoisy);
  } catch (const DatasetError& unfit) {
    note("model of the noisy clips", unfit.what());
  }
  course.End(&report);

  for (const Part& part : Parts()) {
    course.Begin(part.title, part.share);
    // Few or unusual clips are no reason to lose the other parts.
    const auto leave_out = [&](const std::string& why) {
      note(part.title, why);
      report.sections.push_back({part.id, part.title, "Left out on these data: " + why, {}, {}, nullptr});
    };
    try {
      report.sections.push_back(part.run(context));
    } catch (const std::runtime_error& unfit) {
      leave_out(unfit.what());
    } catch (const std::invalid_argument& unfit) {
      leave_out(ReasonOf(unfit));
    }
    course.End(&report);
  }
  return report;
}

}  // namespace morphograph
