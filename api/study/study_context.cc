#include "api/study/study_context.h"

#include <algorithm>
#include <boost/random/uniform_int_distribution.hpp>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>

#include "datasets/error_reason.h"
#include "datasets/errors.h"
#include "datasets/floor_leveling.h"
#include "datasets/parallel_for.h"
#include "datasets/retarget.h"

namespace morphograph {
namespace {

constexpr std::uint64_t kHalvingStream = 0x9e3779b97f4a7c15ull;  // far apart, so that neighbouring seeds share no halving

// Positions in random order, then cut in the middle. An odd one goes to either half in turn, so that neither is the larger by as many
// clips as there are styles.
void SplitStyle(std::vector<int> positions, bool odd_to_first, std::mt19937_64& rng, StudyContext::Halves* halves) {
  for (size_t i = positions.size(); i > 1; --i) {
    std::swap(positions[i - 1], positions[boost::random::uniform_int_distribution<size_t>(0, i - 1)(rng)]);
  }
  const size_t middle = (positions.size() + (odd_to_first ? 1 : 0)) / 2;
  auto& [first, second] = *halves;
  first.insert(first.end(), positions.begin(), positions.begin() + static_cast<std::ptrdiff_t>(middle));
  second.insert(second.end(), positions.begin() + static_cast<std::ptrdiff_t>(middle), positions.end());
}

}  // namespace

StudyContext::StudyContext(std::vector<LoadedClip> clips, LabelledClips labels, StudyOptions options)
    : options_(std::move(options)), labels_(std::move(labels)), loaded_(std::move(clips)) {
  if (loaded_.empty()) throw DatasetError("study", "no clips to study");
  std::vector<int> all(loaded_.size());
  std::iota(all.begin(), all.end(), 0);
  std::set<std::string> styles;
  for (const LoadedClip& loaded : loaded_) {
    if (loaded.clip.frame_count() < 2) throw DatasetError(loaded.clip.name, "has fewer than 2 frames");
    const std::vector<std::string> missing = loaded.clip.skeleton().roles().Missing(LocomotionRoles());
    if (!missing.empty())
      throw DatasetError(loaded.clip.name, "the skeleton has no joint for " + missing.front() + "; name it in a manifest's \"roles\"");
    styles.insert(loaded.clip.style);
  }
  styles_.assign(styles.begin(), styles.end());
  for (const StudyData data : {StudyData::kClean, StudyData::kNoisy}) {
    std::vector<MotionClip>& level = clips_[static_cast<int>(data)];
    level = Captured(data, all);
    ParallelFor(options_.jobs, static_cast<int>(level.size()), [&](int i) {
      try {
        level[i] = LevelFloor(level[i]);
      } catch (const std::invalid_argument& unfit) {
        throw DatasetError(level[i].name, ReasonOf(unfit));
      }
    });
  }

  halves_ = Halving(0);
}

StudyContext::Halves StudyContext::Halving(int number) const {
  std::mt19937_64 rng(options_.seed + kHalvingStream * static_cast<std::uint64_t>(number));
  Halves halves;
  bool odd_to_first = true;
  for (const std::string& style : styles_) {
    std::vector<int> of_style;
    for (size_t i = 0; i < loaded_.size(); ++i)
      if (loaded_[i].clip.style == style) of_style.push_back(static_cast<int>(i));
    SplitStyle(of_style, odd_to_first, rng, &halves);
    if (of_style.size() % 2 == 1) odd_to_first = !odd_to_first;
  }
  for (std::vector<int>& half : halves) std::sort(half.begin(), half.end());
  return halves;
}

std::vector<MotionClip> StudyContext::Captured(StudyData data, const std::vector<int>& which) const {
  std::vector<MotionClip> captured(which.size());
  ParallelFor(options_.jobs, static_cast<int>(which.size()), [&](int i) {
    const MotionClip& clip = loaded_.at(static_cast<size_t>(which[i])).clip;
    captured[i] = data == StudyData::kNoisy ? AddNoise(clip, options_.noise, options_.seed) : clip;
  });
  return captured;
}

const std::vector<MotionClip>& StudyContext::clips(StudyData data) const { return clips_[static_cast<int>(data)]; }

std::shared_ptr<const MotionGraph> StudyContext::Model(StudyData data) {
  std::shared_ptr<const MotionGraph>& model = models_[static_cast<int>(data)];
  if (!model) {
    std::vector<int> all(loaded_.size());
    std::iota(all.begin(), all.end(), 0);
    model = Learn(data, all);
  }
  return model;
}

TrainingOptions StudyContext::Training(TrainingOptions options) const {
  options.action = options_.action;
  options.jobs = options_.jobs;
  if (!options.find_keyframes) options.find_keyframes = options_.find_keyframes;
  return options;
}

std::shared_ptr<const MotionGraph> StudyContext::Learn(StudyData data, const std::vector<int>& which, const TrainingOptions& options) {
  // From the floor of the capture on, as training does it, so that the study's model is the one that `train` makes of these clips.
  std::vector<TrainingClip> training;
  int source = -1;
  for (AugmentedClip& copy : Augment(Captured(data, which), options_.augmentation, options_.jobs)) {
    if (!copy.made) ++source;  // its copies follow
    try {
      training.push_back({Retarget(copy.clip, body()), copy.made, source});
    } catch (const std::invalid_argument& unfit) {
      throw DatasetError(copy.clip.name, "cannot be put on the skeleton of " + loaded_.front().clip.name + ": " + ReasonOf(unfit));
    }
  }
  return BuildGraph(training, Training(options));
}

}  // namespace morphograph
