// Key frames against the labelled recordings: precision, extraction rate and distortion (Du Eq. 4.1-4.3) as counters.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "primitives/keyframe_detector.h"
#include "primitives/learned_keyframes.h"
#include "tests/support/keyframe_splits.h"
#include "tests/support/labelled_clips.h"
#include "tests/support/shared_data.h"

namespace morphograph {
namespace {

using testing::LabelledClip;

const std::vector<LabelledClip>& Clips(const std::string& set) {
  static std::map<std::string, std::vector<LabelledClip>> sets;
  auto it = sets.find(set);
  if (it == sets.end()) {
    const auto data = testing::SharedData();
    it = sets.emplace(set, data.empty() ? std::vector<LabelledClip>() : testing::ReadLabelledClips(data, set)).first;
  }
  return it->second;
}

void Report(benchmark::State& state, const KeyframeScore& score, int frames) {
  state.counters["precision"] = score.precision();
  state.counters["extraction_rate"] = score.extraction_rate();
  state.counters["distortion_ms"] = 1000 * score.distortion_s();
  state.counters["frames_per_s"] = benchmark::Counter(frames, benchmark::Counter::kIsIterationInvariantRate);
}

void BM_FeatureKeyframes(benchmark::State& state, const char* set) {
  const std::vector<LabelledClip>& clips = Clips(set);
  if (clips.empty()) return state.SkipWithError("the recordings are not here: set MORPHOGRAPH_DATA");
  KeyframeScore score;
  int frames = 0;
  for (auto _ : state) {
    score = {};
    frames = 0;
    for (const LabelledClip& clip : clips) {
      score += testing::JudgeKeyframes(DetectKeyframes(clip.clip), clip);
      frames += clip.clip.frame_count();
    }
  }
  Report(state, score, frames);
}
BENCHMARK_CAPTURE(BM_FeatureKeyframes, cmu, "cmu")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_FeatureKeyframes, bnr, "bnr")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_FeatureKeyframes, neura_s02, "neura_s02")->Unit(benchmark::kMillisecond);

// Learned from every other clip, judged on the rest; both ways. Time is that of learning and detecting together.
void BM_LearnedKeyframes(benchmark::State& state, const char* set) {
  const std::vector<LabelledClip>& clips = Clips(set);
  if (clips.empty()) return state.SkipWithError("the recordings are not here: set MORPHOGRAPH_DATA");
  KeyframeScore score;
  int frames = 0;
  for (const LabelledClip& clip : clips) frames += clip.clip.frame_count();
  for (auto _ : state) score = testing::JudgeLearned(clips, testing::AlternateHalves(clips.size()));
  Report(state, score, frames);
}
BENCHMARK_CAPTURE(BM_LearnedKeyframes, cmu, "cmu")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_LearnedKeyframes, bnr, "bnr")->Unit(benchmark::kMillisecond);

// Detection alone, by all the labels: the published hours are of this.
void BM_LearnedDetection(benchmark::State& state, const char* set) {
  const std::vector<LabelledClip>& clips = Clips(set);
  if (clips.empty()) return state.SkipWithError("the recordings are not here: set MORPHOGRAPH_DATA");
  std::vector<KeyframeExamples> examples;
  for (const LabelledClip& clip : clips) examples.push_back(testing::StrikeExamples(clip));
  const LearnedKeyframeDetector detector(examples);
  int frames = 0;
  for (const LabelledClip& clip : clips) frames += clip.clip.frame_count();
  for (auto _ : state) {
    for (const LabelledClip& clip : clips) benchmark::DoNotOptimize(detector.Detect(clip.clip).data());
  }
  state.counters["frames_per_s"] = benchmark::Counter(frames, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK_CAPTURE(BM_LearnedDetection, cmu, "cmu")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_LearnedDetection, bnr, "bnr")->Unit(benchmark::kMillisecond);

// How much the figure hangs on the split: mean and worst over halves drawn at random, by clip, each judged both ways.
void BM_LearnedOverRandomHalves(benchmark::State& state, const char* set, int splits) {
  const std::vector<LabelledClip>& clips = Clips(set);
  if (clips.empty()) return state.SkipWithError("the recordings are not here: set MORPHOGRAPH_DATA");
  for (auto _ : state) {
    double precision = 0, rate = 0, worst_precision = 1, worst_rate = 1;
    for (int seed = 1; seed <= splits; ++seed) {
      const KeyframeScore score =
          testing::JudgeLearned(clips, testing::RandomHalves(clips.size(), static_cast<std::uint64_t>(seed)));
      precision += score.precision() / splits;
      rate += score.extraction_rate() / splits;
      worst_precision = std::min(worst_precision, score.precision());
      worst_rate = std::min(worst_rate, score.extraction_rate());
    }
    state.counters["precision_mean"] = precision;
    state.counters["precision_worst"] = worst_precision;
    state.counters["extraction_rate_mean"] = rate;
    state.counters["extraction_rate_worst"] = worst_rate;
  }
}
BENCHMARK_CAPTURE(BM_LearnedOverRandomHalves, cmu, "cmu", 40)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(BM_LearnedOverRandomHalves, bnr, "bnr", 5)->Unit(benchmark::kMillisecond)->Iterations(1);

// Each subject (cmu) or style (bnr) by what all the others teach.
void BM_LearnedFromTheOthers(benchmark::State& state, const char* set) {
  const std::vector<LabelledClip>& clips = Clips(set);
  if (clips.empty()) return state.SkipWithError("the recordings are not here: set MORPHOGRAPH_DATA");
  for (auto _ : state) {
    KeyframeScore sum;
    double worst_precision = 1, worst_rate = 1;
    for (const testing::KeyframeFold& fold : testing::LeaveGroupsOut(clips)) {
      const KeyframeScore score = testing::JudgeLearned(clips, {fold});
      worst_precision = std::min(worst_precision, score.precision());
      worst_rate = std::min(worst_rate, score.extraction_rate());
      sum += score;
    }
    state.counters["precision"] = sum.precision();
    state.counters["precision_worst"] = worst_precision;
    state.counters["extraction_rate"] = sum.extraction_rate();
    state.counters["extraction_rate_worst"] = worst_rate;
  }
}
BENCHMARK_CAPTURE(BM_LearnedFromTheOthers, cmu, "cmu")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(BM_LearnedFromTheOthers, bnr, "bnr")->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace morphograph
