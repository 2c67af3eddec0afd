// Key frames against the labelled recordings: precision, extraction rate and distortion (Du Eq. 4.1-4.3) as counters.
#include <benchmark/benchmark.h>

#include <map>
#include <string>
#include <vector>

#include "primitives/keyframe_detector.h"
#include "primitives/learned_keyframes.h"
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

KeyframeScore Score(const LabelledClip& clip, const std::vector<Keyframe>& found) {
  const double rate = clip.clip.frame_rate_hz();
  return EvaluateKeyframes(found, clip.reference, testing::StanceLabels(), rate, testing::StrikeToleranceS(rate));
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
      score += Score(clip, DetectKeyframes(clip.clip));
      frames += clip.clip.frame_count();
    }
  }
  Report(state, score, frames);
}
BENCHMARK_CAPTURE(BM_FeatureKeyframes, cmu, "cmu")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_FeatureKeyframes, bnr, "bnr")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_FeatureKeyframes, neura_s02, "neura_s02")->Unit(benchmark::kMillisecond);

// Learned from every other clip, judged on the rest; both ways.
void BM_LearnedKeyframes(benchmark::State& state, const char* set) {
  const std::vector<LabelledClip>& clips = Clips(set);
  if (clips.empty()) return state.SkipWithError("the recordings are not here: set MORPHOGRAPH_DATA");
  KeyframeScore score;
  int frames = 0;
  for (auto _ : state) {
    score = {};
    frames = 0;
    for (size_t half = 0; half < 2; ++half) {
      std::vector<KeyframeExamples> examples;
      for (size_t i = half; i < clips.size(); i += 2) {
        std::vector<LabelledFrame> labels = clips[i].labels;
        std::erase_if(labels, [](const LabelledFrame& label) { return !label.label.ends_with("_strike"); });
        for (LabelledFrame& label : labels) label.frame -= clips[i].dropped_frames;
        examples.push_back({&clips[i].clip, std::move(labels)});
      }
      const LearnedKeyframeDetector detector(examples);
      for (size_t i = 1 - half; i < clips.size(); i += 2) {
        score += Score(clips[i], WalkingKeyframes(detector.Detect(clips[i].clip)));
        frames += clips[i].clip.frame_count();
      }
    }
  }
  Report(state, score, frames);
}
BENCHMARK_CAPTURE(BM_LearnedKeyframes, cmu, "cmu")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_LearnedKeyframes, bnr, "bnr")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace morphograph
