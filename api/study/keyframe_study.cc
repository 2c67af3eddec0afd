#include "api/study/keyframe_study.h"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "api/keyframe_examples.h"
#include "datasets/errors.h"
#include "datasets/parallel_for.h"
#include "primitives/keyframe_detector.h"
#include "primitives/keyframe_evaluation.h"
#include "primitives/learned_keyframes.h"

namespace morphograph {
namespace {

using nlohmann::ordered_json;

constexpr int kPublishedFrames = 23467;  // Du 4.2.4
constexpr size_t kMostUnlabelled = 48, kQuickClips = 10;
const std::vector<KeyframeLabel> kJudged = {KeyframeLabel::kLeftStance, KeyframeLabel::kRightStance};

// A clip whose key frames are known.
struct KnownClip {
  int position = 0;                   // among the study's clips
  std::vector<LabelledFrame> labels;  // landings, in frames of the clip
  std::vector<ReferenceKeyframe> reference;
};

double ThreadSeconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Labels were read off to two frames at the rates of cameras, and to a twenty-fourth of a second above.
double ToleranceS(double rate_hz) { return std::max(2 / rate_hz, 1.0 / 24); }

KnownClip Known(int position, const std::vector<LabelledFrame>& labels) {
  KnownClip known{position, {}, {}};
  for (const LabelledFrame& label : labels) {
    const std::optional<KeyframeLabel> kind = WalkingLabel(label.label);
    if (!kind || std::find(kJudged.begin(), kJudged.end(), *kind) == kJudged.end()) continue;
    known.labels.push_back(label);
    const double frame = label.frame;
    known.reference.push_back({frame, frame, frame, *kind, label.doubtful});
  }
  return known;
}

KeyframeOptions UsualOptions(const std::string& action) {
  return HasKeyframeFeatures(action) ? KeyframeOptionsFor(action) : KeyframeOptions();
}

std::vector<LabelledFrame> FoundByFeature(const MotionClip& clip, const KeyframeOptions& options) {
  std::vector<LabelledFrame> labels;
  for (const Keyframe& found : DetectKeyframes(clip, options))
    labels.push_back({static_cast<int>(std::lround(found.frame)), std::string(KeyframeLabelName(found.label)), false});
  return labels;
}

struct Outcome {
  KeyframeScore score;
  double seconds = 0, frames = 0;
  Outcome& operator+=(const Outcome& other) {
    score += other.score, seconds += other.seconds, frames += other.frames;
    return *this;
  }
};

// `find(clip)` on every clip, judged; the sum in order.
template <typename Find>
Outcome Judge(const std::vector<KnownClip>& known, const std::vector<MotionClip>& clips, int jobs, const Find& find) {
  std::vector<Outcome> outcomes(known.size());
  ParallelFor(jobs, static_cast<int>(known.size()), [&](int i) {
    const MotionClip& clip = clips[known[i].position];
    const double begin = ThreadSeconds();
    const std::vector<Keyframe> found = find(clip);
    outcomes[i].seconds = ThreadSeconds() - begin;
    outcomes[i].frames = clip.frame_count();
    outcomes[i].score =
        EvaluateKeyframes(found, known[i].reference, kJudged, clip.frame_rate_hz(), ToleranceS(clip.frame_rate_hz()));
  });
  Outcome sum;
  for (const Outcome& outcome : outcomes) sum += outcome;
  return sum;
}

struct Learned {
  Outcome detection;
  double teaching_s = 0;
};

// Each half of the clips taught, the other judged.
Learned JudgeLearned(const std::vector<KnownClip> (&halves)[2], const std::vector<MotionClip>& clips, int jobs) {
  Learned learned;
  for (int taught = 0; taught < 2; ++taught) {
    std::vector<KeyframeExamples> examples;
    for (const KnownClip& known : halves[taught]) examples.push_back({&clips[known.position], known.labels});
    const double begin = ThreadSeconds();
    const LearnedKeyframeDetector detector(examples);
    learned.teaching_s += ThreadSeconds() - begin;
    learned.detection +=
        Judge(halves[1 - taught], clips, jobs, [&](const MotionClip& clip) { return WalkingKeyframes(detector.Detect(clip)); });
  }
  return learned;
}

ordered_json OutcomeJson(const Outcome& outcome) {
  return {{"precision", outcome.score.precision()},
          {"extraction_rate", outcome.score.extraction_rate()},
          {"distortion_ms", 1000 * outcome.score.distortion_s()},
          {"found", outcome.score.true_positives},
          {"wrong", outcome.score.false_positives},
          {"missed", outcome.score.false_negatives}};
}

std::string Text(const Outcome& outcome) {
  char text[120];
  std::snprintf(text, sizeof text, "precision %.3f, extraction rate %.3f, distortion %.0f ms", outcome.score.precision(),
                outcome.score.extraction_rate(), 1000 * outcome.score.distortion_s());
  return text;
}

void AddFigures(const std::string& which, const Outcome& outcome, const std::string& note, StudySection* section) {
  section->figures.push_back({.what = "key frames " + which + ": precision", .value = outcome.score.precision(), .source = "Du Eq. 4.1", .note = note});
  section->figures.push_back({.what = "key frames " + which + ": extraction rate", .value = outcome.score.extraction_rate(), .source = "Du Eq. 4.2"});
  section->figures.push_back(
      {.what = "key frames " + which + ": distortion", .value = 1000 * outcome.score.distortion_s(), .unit = "ms", .source = "Du Eq. 4.3"});
}

}  // namespace

StudySection StudyKeyframes(StudyContext& context) {
  StudySection section;
  section.id = "keyframes";
  section.title = "Key frames: where steps are cut";
  const StudyOptions& options = context.options();
  const std::vector<MotionClip>& clean = context.clips(StudyData::kClean);
  const bool labelled = !context.labels().empty();

  std::vector<KnownClip> known;
  if (labelled) {
    const MatchedLabels matched = MatchLabels(context.labels(), context.loaded(), "labels");
    for (size_t i = 0; i < matched.frames.size(); ++i) known.push_back(Known(static_cast<int>(i), matched.frames[i]));
  } else {
    std::vector<std::vector<LabelledFrame>> found(clean.size());
    ParallelFor(options.jobs, static_cast<int>(clean.size()), [&](int i) { found[i] = FoundByFeature(clean[i], UsualOptions(options.action)); });
    for (size_t i = 0; i < found.size(); ++i) known.push_back(Known(static_cast<int>(i), found[i]));
  }
  std::erase_if(known, [](const KnownClip& clip) { return clip.reference.empty(); });
  if (options.quick) {
    known = SpreadOver(known, kQuickClips);
  } else if (!labelled) {
    known = SpreadOver(known, kMostUnlabelled);
  }
  if (known.empty()) throw DatasetError("key frames", "no clip has a landing that is labelled or can be found by feature");
  std::vector<KnownClip> halves[2];
  for (size_t i = 0; i < known.size(); ++i) halves[i % 2].push_back(known[i]);
  const bool can_learn = !halves[1].empty();

  std::vector<double> steps_s = {0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.6, 0.7, 0.8, 1.0};
  if (options.quick) steps_s = {0.1, 0.25, 0.5, 0.8};
  const KeyframeOptions usual = UsualOptions(options.action);
  Chart charts[3];
  const char* const titles[] = {"Precision", "Extraction rate", "Distortion"};
  const char* const labels[] = {"precision", "extraction rate", "distortion, ms"};
  const char* const captions[] = {
      "Share of the key frames found that are right (Du Eq. 4.1, Fig. 4.7): two peaks of one step count when the least step time is short.",
      "Share of the key frames that are found (Du Eq. 4.2, Fig. 4.7): real steps are lost when the least step time is longer than they are.",
      "Mean distance in time of the right ones from the labels (Du Eq. 4.3, Fig. 4.7; here over those found, as a missed one has no distance)."};
  for (int m = 0; m < 3; ++m) {
    charts[m].title = titles[m], charts[m].y_label = labels[m], charts[m].caption = captions[m];
    charts[m].x_label = "least step time, s", charts[m].better = m == 2 ? "lower" : "higher";
    charts[m].y_from_zero = m == 2;
  }
  Outcome by_feature[2];
  Learned learned[2];
  int frames = 0;
  for (const KnownClip& clip : known) frames += clean[clip.position].frame_count();
  for (const StudyData data : {StudyData::kClean, StudyData::kNoisy}) {
    const int d = static_cast<int>(data);
    const std::string name = data == StudyData::kClean ? "clean" : "noisy";
    const std::vector<MotionClip>& clips = context.clips(data);
    if (options.progress) options.progress("key frames, " + name, 0.5 * d);
    ordered_json& out = section.data[name];
    ChartSeries curves[3];
    for (const double step_s : steps_s) {
      KeyframeOptions detector = usual;
      detector.min_step_s = step_s;
      const Outcome outcome = Judge(known, clips, options.jobs, [&](const MotionClip& clip) { return DetectKeyframes(clip, detector); });
      const double values[] = {outcome.score.precision(), outcome.score.extraction_rate(), 1000 * outcome.score.distortion_s()};
      for (int m = 0; m < 3; ++m) curves[m].x.push_back(step_s), curves[m].y.push_back(values[m]);
      ordered_json at = OutcomeJson(outcome);
      at["least_step_s"] = step_s;
      out["by_feature"].push_back(at);
    }
    by_feature[d] = Judge(known, clips, options.jobs, [&](const MotionClip& clip) { return DetectKeyframes(clip, usual); });
    out["by_feature_as_used"] = OutcomeJson(by_feature[d]);
    for (int m = 0; m < 3; ++m) {
      curves[m].name = "by feature, " + name;
      charts[m].series.push_back(curves[m]);
    }
    if (!can_learn) continue;
    learned[d] = JudgeLearned(halves, clips, options.jobs);
    out["learned"] = OutcomeJson(learned[d].detection);
    const KeyframeScore& score = learned[d].detection.score;
    const double values[] = {score.precision(), score.extraction_rate(), 1000 * score.distortion_s()};
    for (int m = 0; m < 3; ++m) {
      ChartSeries level{.name = "learned, " + name, .x = {steps_s.front(), steps_s.back()}, .y = {values[m], values[m]}};
      level.dashed = true;
      charts[m].series.push_back(level);
    }
  }
  for (Chart& chart : charts) {
    chart.marks.push_back({.name = "as used", .value = usual.min_step_s, .vertical = true});
    section.drawings.push_back(chart);
  }

  const std::string against = labelled ? "against labels" : "against what is found in the clean clips: robustness, not truth";
  const char* const names[] = {"clean", "noisy"};
  for (int d = 0; d < 2; ++d) {
    AddFigures(std::string("by feature, ") + names[d], by_feature[d], against, &section);
    if (can_learn) AddFigures(std::string("learned, ") + names[d], learned[d].detection, against + "; each half by what the other teaches", &section);
  }
  const auto seconds_for_published = [&](const Outcome& outcome) { return outcome.seconds / std::max(1.0, outcome.frames) * kPublishedFrames; };
  section.figures.push_back({.what = "time for the key frames of 23,467 frames, by feature",
                             .value = seconds_for_published(by_feature[0]),
                             .unit = "s",
                             .published = 600,
                             .source = "Du 4.2.4",
                             .note = "one thread, scaled from the frames at hand; another machine",
                             .is_time = true});
  if (can_learn) {
    section.figures.push_back({.what = "time for the key frames of 23,467 frames, learned",
                               .value = seconds_for_published(learned[0].detection),
                               .unit = "s",
                               .published = 2 * 3600,
                               .source = "Du 4.2.4",
                               .note = "published as \"several hours\", two are taken; one thread, after teaching",
                             .is_time = true});
  }
  section.data["clips"] = known.size();
  section.data["frames"] = frames;
  section.data["labelled"] = labelled;

  section.text =
      "Landings of the left and the right foot are searched by feature (peaks of the distance between the ankles, Du 4.2.1) and by likeness "
      "to labelled examples (Du 4.2.2; each half of the clips is judged by a detector that the other half taught), in " +
      std::to_string(known.size()) + " clips, clean and noisy. A key frame is right when a label of its kind lies within two frames, or a "
      "twenty-fourth of a second at higher frame rates. The least step time is what Du calls step size: of two peaks closer than this the "
      "higher stays.\n\n" +
      (labelled ? std::string("The labels are strikes of the feet, found by other measures than the features here; double stances are too rare in them to "
                              "be judged.")
                : std::string("No clip of these data is labelled. The key frames found by feature in the clean clips, as training uses them, stand in "
                              "for labels. So the figures by feature on clean clips are perfect by construction at the usual step time; all others say how "
                              "much noise, step time or the other method change what is found, and nothing about truth.")) +
      "\n\nBy feature as used (0.25 s): clean " + Text(by_feature[0]) + "; noisy " + Text(by_feature[1]) + ".";
  if (can_learn) {
    section.text += " Learned: clean " + Text(learned[0].detection) + "; noisy " + Text(learned[1].detection) + ".";
    char times[200];
    std::snprintf(times, sizeof times, " A frame takes %.0f µs by feature and %.0f µs by likeness, on one thread.",
                  1e6 * by_feature[0].seconds / std::max(1.0, by_feature[0].frames),
                  1e6 * learned[0].detection.seconds / std::max(1.0, learned[0].detection.frames));
    section.text += times;
  } else {
    section.text += " One clip alone cannot be both taught and judged, so nothing is said of learned key frames.";
  }
  return section;
}

}  // namespace morphograph
