#include "api/study/likeness.h"

#include <algorithm>
#include <boost/random/uniform_int_distribution.hpp>
#include <numeric>
#include <random>
#include <stdexcept>

#include "datasets/error_reason.h"
#include "datasets/parallel_for.h"
#include "synthesis/clip_ends.h"
#include "synthesis/evaluation.h"
#include "synthesis/evaluation_motion.h"
#include "synthesis/frechet_distance.h"
#include "synthesis/pose_windows.h"
#include "synthesis/window_space.h"

namespace morphograph {
namespace {

constexpr std::uint64_t kTellingStream = 0x9e3779b97f4a7c15ull;  // seeds of halvings lie so far apart
constexpr Eigen::Index kFewestWindows = 64;  // two a direction of the WindowSpace

// Windows of each clip.
std::vector<Eigen::MatrixXd> WindowsOf(const std::vector<MotionClip>& clips, int jobs) {
  std::vector<Eigen::MatrixXd> windows(clips.size());
  ParallelFor(jobs, static_cast<int>(clips.size()),
              [&](int i) { windows[static_cast<size_t>(i)] = PoseWindows(PrepareEvaluation(clips[static_cast<size_t>(i)])); });
  return windows;
}

// Folds of the classifier: five, fewer where halves hold fewer clips; 0 where even two cannot be filled.
int FoldsFor(size_t clips_of_half) { return clips_of_half < 2 ? 0 : static_cast<int>(std::min<size_t>(5, clips_of_half)); }

WindowClassifierOptions ClassifierOptions(const StudyOptions& options, int halvings, int folds) {
  return {.trees = options.quick ? 40 : 200, .folds = folds, .halvings = options.quick ? 1 : halvings, .seed = options.seed, .jobs = options.jobs};
}

// Fréchet distance of what a model of one half synthesises to the other half, mean of both ways, in the space of all captured windows.
std::optional<double> HalfFrechet(const JudgedHalves& halves, int jobs) {
  std::vector<Eigen::MatrixXd> captured[2];
  for (int h = 0; h < 2; ++h) captured[h] = WindowsOf(halves.captured[h], jobs);
  if (captured[0].empty() || captured[1].empty() || !halves.drawn()) return std::nullopt;
  const Eigen::MatrixXd joined[2] = {JoinColumns(captured[0]), JoinColumns(captured[1])};
  if (joined[0].cols() < kFewestWindows || joined[1].cols() < kFewestWindows) return std::nullopt;
  const WindowSpace space(JoinColumns({joined[0], joined[1]}));
  const GaussianFit fits[2] = {FitGaussian(space.Project(joined[0])), FitGaussian(space.Project(joined[1]))};
  double sum = 0;
  for (int h = 0; h < 2; ++h) {
    const Eigen::MatrixXd drawn = JoinColumns(WindowsOf(halves.synthesised[h], jobs));
    sum += FrechetDistance(FitGaussian(space.Project(drawn)), fits[1 - h]) / 2;
  }
  return sum;
}

// As many of the clips as are synthesised, each drawn from all of them: what a model that knew its half by heart would make.
std::vector<MotionClip> Copies(const std::vector<MotionClip>& clips, size_t count, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  boost::random::uniform_int_distribution<size_t> any(0, clips.size() - 1);
  std::vector<MotionClip> copies;
  for (size_t i = 0; i < count; ++i) copies.push_back(clips[any(rng)]);
  return copies;
}

// How well what models of halves synthesise, and copies of these halves' own clips, are told from the other halves; both ways. The floor is that of
// the random halves of the model of all clips: these few alone say little, and with few clips what sets one half apart in a fold is what it lacks in the others.
void TellHalves(const std::vector<JudgedHalves>& halvings, int style, const StudyOptions& options, Likeness* likeness) {
  struct Task {
    const std::vector<MotionClip>* all;
    std::vector<MotionClip> drawn;
    ClipHalves halving;
    WindowClassifierOptions classifier;
  };
  std::vector<std::vector<MotionClip>> captured(halvings.size());
  std::vector<Task> tasks;  // a halving: model and copies of the first half, model and copies of the second
  for (size_t n = 0; n < halvings.size(); ++n) {
    const JudgedHalves& halves = halvings[n];
    const int folds = FoldsFor(std::min(halves.captured[0].size(), halves.captured[1].size()));
    if (folds == 0 || !halves.drawn()) continue;
    captured[n] = halves.captured[0];
    captured[n].insert(captured[n].end(), halves.captured[1].begin(), halves.captured[1].end());
    std::vector<int> sides[2];
    for (size_t i = 0; i < captured[n].size(); ++i) sides[i < halves.captured[0].size() ? 0 : 1].push_back(static_cast<int>(i));
    WindowClassifierOptions classifier = ClassifierOptions(options, 1, folds);
    classifier.seed += kTellingStream * (2 * n + 1);
    classifier.jobs = 1;
    for (int h = 0; h < 2; ++h) {
      const ClipHalves halving{sides[h], sides[1 - h]};
      tasks.push_back({&captured[n], halves.synthesised[h], halving, classifier});
      tasks.push_back({&captured[n], Copies(halves.captured[h], halves.synthesised[h].size(), classifier.seed + static_cast<std::uint64_t>(2 * style + h)), halving, classifier});
    }
  }
  if (tasks.empty()) return;
  std::vector<double> areas(tasks.size());
  ParallelFor(options.jobs, static_cast<int>(tasks.size()), [&](int i) {
    const Task& task = tasks[static_cast<size_t>(i)];
    areas[static_cast<size_t>(i)] = AreaAgainstHalf(task.drawn, *task.all, task.halving, task.classifier);
  });
  likeness->half_told = likeness->copies_told = HalfDistinction{{}, likeness->told->floor};
  for (size_t i = 0; i < areas.size(); i += 4) {
    likeness->half_told->areas.push_back((areas[i] + areas[i + 2]) / 2);
    likeness->copies_told->areas.push_back((areas[i + 1] + areas[i + 3]) / 2);
  }
}

}  // namespace

double HalfDistinction::auc() const { return std::accumulate(areas.begin(), areas.end(), 0.0) / static_cast<double>(areas.size()); }

std::vector<MotionClip> CutClips(const std::vector<MotionClip>& clips, const LikenessCut& cut) {
  if (cut.trimmed) return WithoutEnds(clips);
  std::vector<MotionClip> long_enough;  // to hold a window
  for (const MotionClip& clip : clips) {
    if (clip.frame_count() >= PoseWindowOptions().frames) long_enough.push_back(clip);
  }
  return long_enough;
}

std::optional<WindowDistinction> Tell(const std::vector<MotionClip>& synthesised, const std::vector<MotionClip>& captured, const LikenessCut& cut,
                                      const StudyOptions& options) {
  const int folds = FoldsFor(captured.size() / 2);
  if (folds == 0) return std::nullopt;
  return TellApart(synthesised, captured, ClassifierOptions(options, cut.halvings, folds));
}

void JudgeWhole(const std::vector<MotionClip>& synthesised, const std::vector<MotionClip>& captured, const StudyOptions& options, Likeness* likeness) {
  try {
    const SetComparison compared =
        CompareWindowSets(WindowsOf(synthesised, options.jobs), WindowsOf(captured, options.jobs), options.seed);
    likeness->frechet_ratio = compared.frechet_ratio;
    likeness->halves_distance = compared.frechet_halves;
    likeness->diversity_ratio = compared.diversity / compared.diversity_reference;
  } catch (const std::invalid_argument& unfit) {
    likeness->note = ReasonOf(unfit);
  }
}

void JudgeHalves(const std::vector<JudgedHalves>& halvings, std::optional<int> style, const StudyOptions& options, Likeness* likeness) {
  double sum = 0;
  int measured = 0;
  for (const JudgedHalves& halves : halvings) {
    if (const std::optional<double> distance = HalfFrechet(halves, options.jobs)) sum += *distance, ++measured;
  }
  if (measured > 0 && likeness->halves_distance) likeness->half_frechet_ratio = sum / measured / *likeness->halves_distance;
  if (style && likeness->told) TellHalves(halvings, *style, options, likeness);
}

}  // namespace morphograph
