// What each part of the method is worth: the samples without it.

#include <algorithm>
#include <cmath>

#include "api/study/sample_sets.h"
#include "api/study/sample_study.h"
#include "datasets/error_reason.h"
#include "datasets/parallel_for.h"
#include "synthesis/evaluation.h"
#include "synthesis/set_quality.h"
#include "synthesis/window_classifier.h"

namespace morphograph {
namespace {

using Json = nlohmann::ordered_json;

struct Ablation {
  std::string name, id;
  TrainingVariant training;
  SynthesisVariant synthesis;
  bool quick = false;  // part of a quick study
  bool learns = true;  // needs a model of its own
};

std::vector<Ablation> Ablations() {
  using Transition = TrainingVariant::Transition;
  return {
      {"nothing left out", "nothing", {}, {}, true, false},
      {"no timing model", "no_timing", {.timing = false}, {}},
      {"no transitions", "no_transition", {.transition = Transition::kNone}, {}, true},
      {"no stationary part", "process_only", {.transition = Transition::kProcessOnly}, {}},
      {"pooled styles", "pooled_styles", {.styles = false}, {}},
      {"no margins, hard cuts", "no_margins", {.margins = false}, {.cross_fade = false}},
      {"no foot lock", "no_foot_lock", {}, {.foot_lock = false}, true, false},
      {"plain PCA", "plain_pca", {.weighted = false}, {}},
      {"Euler angles", "euler", {.euler = true}, {}},
  };
}

struct Measured {
  std::optional<double> frechet, auc_above_floor, contact, naturalness, skate, acceleration, jerk;
};

// Some of the clips, spread over the styles in their proportion.
std::vector<MotionClip> SpreadOverStyles(const StyledClips& clips, size_t most) {
  size_t all = 0;
  for (const auto& [style, of_style] : clips) all += of_style.size();
  std::vector<MotionClip> chosen;
  for (const auto& [style, of_style] : clips) {
    const size_t count = all <= most ? of_style.size() : std::max<size_t>(2, of_style.size() * most / all);
    for (size_t i = 0; i < std::min(count, of_style.size()); ++i) chosen.push_back(of_style[i * of_style.size() / std::min(count, of_style.size())]);
  }
  return chosen;
}

struct Reference {
  std::vector<MotionClip> clips;  // on the model's body
  SetQuality quality;
  int piece_frames = 90;
  std::optional<HalvedCapture> halved;  // some of them, for the classifier; none where they are too few
};

Measured Measure(const std::vector<MotionClip>& drawn, const Reference& reference, const StudyOptions& options) {
  Measured measured;
  const SetQuality quality = MeasureSet(drawn, {.piece_frames = reference.piece_frames});
  measured.contact = RatioTo(quality.contact_distance_m, reference.quality.contact_distance_m);
  measured.naturalness = RatioTo(quality.naturalness, reference.quality.naturalness);
  measured.skate = RatioTo(quality.foot_skate_cm_s, reference.quality.foot_skate_cm_s);
  measured.acceleration = RatioTo(quality.acceleration_p999_m_s2, reference.quality.acceleration_p999_m_s2);
  measured.jerk = RatioTo(quality.mean_jerk_m_s3, reference.quality.mean_jerk_m_s3);
  try {
    measured.frechet = CompareSets(drawn, reference.clips, options.seed).frechet_ratio;
  } catch (const std::invalid_argument&) {  // too few windows to tell
  }
  if (reference.halved) measured.auc_above_floor = reference.halved->Tell(drawn).difference;
  return measured;
}

using Member = std::optional<double> Measured::*;
struct MeasureColumn {
  const char *title, *y_label;
  Member member;
  double aim = 1;  // as captured
};

}  // namespace

StudySection StudyAblations(StudyContext& context) {
  const StudyOptions& options = context.options();
  StudySection section{.id = "ablations", .title = "What each part is worth"};
  section.text =
      "The same clips, learned and synthesised with one part of the method left out. No timing model: every step of a kind lasts equally long. No "
      "transitions: each step is drawn from its mixture, whatever came before. No stationary part: the transition is the RBF process of Du 3.5 "
      "alone, drawn with its own residuals. Pooled styles: one model for all. No margins, hard cuts: nothing is learned of the quarter step before "
      "and after, and steps are cut together at the key frame. No foot lock: feet stay where the steps put them. Plain PCA: every channel counts "
      "alike. Euler angles: the recording's own channels in place of log maps (Du Eq. 3.8).\n\nAll styles together, against the captured clips as "
      "they are; the classifier on some of the clips, fewer seeds than in the parts above, so that a difference of 0.05 may be chance.";
  if (context.styles().size() < 2) section.text += " These clips have one style: there is nothing to pool.";
  const std::vector<MotionClip>& recorded = context.clips(StudyData::kClean);
  const std::vector<MotionClip> captured = AtEvaluationRate(recorded, options.jobs), on_body = AtEvaluationRate(OnBody(recorded, context.body(), options.jobs), options.jobs);
  Reference reference;
  reference.piece_frames = PieceFrames(captured);
  for (const MotionClip& clip : on_body) {
    if (clip.frame_count() >= 15) reference.clips.push_back(clip);
  }
  const StyledClips by_style = ByStyle(reference.clips);
  if (const std::vector<MotionClip> some = SpreadOverStyles(by_style, 90); some.size() >= 4) {
    reference.halved.emplace(some, WindowClassifierOptions{.trees = options.quick ? 40 : 200,
                                                           .folds = static_cast<int>(std::min<size_t>(5, some.size() / 2)),
                                                           .halvings = options.quick ? 1 : 2,
                                                           .seed = options.seed,
                                                           .jobs = options.jobs});
  }
  reference.quality = MeasureSet(captured, {.piece_frames = reference.piece_frames});

  std::vector<int> all(captured.size());
  for (size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  const int each = options.quick ? 6 : std::max(20, 150 / static_cast<int>(by_style.size()));
  std::vector<std::pair<std::string, Measured>> rows;
  const std::vector<Ablation> ablations = Ablations();
  for (size_t a = 0; a < ablations.size(); ++a) {
    const Ablation& ablation = ablations[a];
    if (options.quick && !ablation.quick) continue;
    if (!ablation.training.styles && context.styles().size() < 2) continue;  // there is nothing to pool
    if (options.progress) options.progress(ablation.name, static_cast<double>(a) / static_cast<double>(ablations.size()));
    try {
      TrainingOptions training;
      training.variant = ablation.training;
      const std::shared_ptr<const MotionGraph> graph =
          ablation.learns ? context.Learn(StudyData::kClean, all, training) : context.Model(StudyData::kClean);
      const int clips = ablation.training.styles ? each : each * static_cast<int>(by_style.size());
      const StyledClips drawn = DrawStyles(*graph, {.clips = clips, .seed = options.seed, .jobs = options.jobs, .variant = ablation.synthesis});
      rows.emplace_back(ablation.name, Measure(InProportion(drawn, by_style), reference, options));
    } catch (const std::runtime_error& unfit) {
      section.text += "\n\nNot possible here: " + ablation.name + ": " + unfit.what();
      continue;
    }
    const Measured& m = rows.back().second;
    const auto json = [](const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); };
    section.data[ablation.id] = {{"name", ablation.name},
                                 {"frechet_ratio", json(m.frechet)},
                                 {"auc_above_floor", json(m.auc_above_floor)},
                                 {"contact_distance_ratio", json(m.contact)},
                                 {"naturalness_ratio", json(m.naturalness)},
                                 {"foot_skate_ratio", json(m.skate)},
                                 {"acceleration_ratio", json(m.acceleration)},
                                 {"jerk_ratio", json(m.jerk)}};
  }

  const std::vector<MeasureColumn> measures = {
      {"Fréchet distance", "ratio to captured halves", &Measured::frechet, 1.0},
      {"Classifier above its floor", "area under the curve - floor", &Measured::auc_above_floor, 0.0},
      {"Contact distance", "synthesised / captured", &Measured::contact, 1.0},
      {"Naturalness", "synthesised / captured", &Measured::naturalness, 1.0},
      {"Foot skate", "synthesised / captured", &Measured::skate, 1.0},
      {"99.9th percentile of acceleration", "synthesised / captured", &Measured::acceleration, 1.0},
  };
  for (const MeasureColumn& measure : measures) {
    Chart chart{.title = measure.title, .x_label = "left out", .y_label = measure.y_label, .better = "lower"};
    if (measure.member == &Measured::naturalness || measure.member == &Measured::acceleration) chart.better.clear();
    ChartSeries bars{.name = "all styles", .x = {}, .y = {}, .form = ChartSeries::Form::kBars};
    double greatest = 0, least = 1e9;
    for (const auto& [name, measured] : rows) {
      if (const std::optional<double>& value = measured.*measure.member) {
        bars.x.push_back(static_cast<double>(chart.x_names.size())), bars.y.push_back(*value);
        greatest = std::max(greatest, *value), least = std::min(least, *value);
      }
      chart.x_names.push_back(name);
    }
    if (bars.y.empty()) continue;
    // One part that everything hangs on would press the others flat.
    chart.log_y = least > 0 && greatest > 20 * least;
    chart.series = {std::move(bars)};
    chart.marks = {{measure.member == &Measured::auc_above_floor ? "not told" : "as captured", measure.aim}};
    section.drawings.push_back(std::move(chart));
  }
  return section;
}

}  // namespace morphograph
