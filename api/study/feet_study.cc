// Contact distance and naturalness, captured and synthesised: Du 4.5.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>


#include "api/study/markup.h"
#include "api/study/sample_sets.h"
#include "api/study/sample_study.h"
#include "datasets/parallel_for.h"
#include "primitives/decomposition.h"
#include "primitives/keyframe_detector.h"
#include "synthesis/contact_quality.h"
#include "synthesis/evaluation_motion.h"
#include "synthesis/naturalness.h"
#include "synthesis/set_quality.h"

namespace morphograph {
namespace {

using Json = nlohmann::ordered_json;
using Form = ChartSeries::Form;

constexpr int kCurves = 20;  // drawn of each set and primitive, as many as Du has

// A step's curves at 30 fps, a value a frame.
struct StepCurves {
  std::vector<double> contact_m;      // of frames with a planted foot, elsewhere not a number
  std::vector<double> difference_m2;  // D(F_i, F_i+1)
};
using CurvesByPrimitive = std::map<std::string, std::vector<StepCurves>>;

// Steady steps of a clip at 30 fps, cut at its key frames. Captured and synthesised clips are cut alike, and measured on pieces of one
// length, as a plane fits few stances better than many.
void AddStepCurves(const MotionClip& clip, int piece_frames, const StudyOptions& options, CurvesByPrimitive* curves) {
  const std::vector<Keyframe> keyframes =
      options.find_keyframes ? options.find_keyframes(clip) : DetectKeyframes(clip, KeyframeOptionsFor(options.action));
  const std::vector<Segment> segments = Decompose(clip, 0, keyframes, {.action = options.action});
  for (int first = 0; first + piece_frames <= clip.frame_count(); first += piece_frames) {
    const EvaluationMotion motion = PrepareEvaluation(clip.Slice(first, piece_frames));
    const ContactQuality contact = MeasureContacts(motion.contacts, motion.ground, kEvaluationRateHz);
    const std::vector<double> differences = FrameDifferences(*motion.skeleton, motion.joint_positions);
    std::vector<bool> planted(static_cast<size_t>(piece_frames), false);
    for (const ContactInterval& interval : motion.contacts.intervals) {
      for (int f = interval.first; f <= interval.last; ++f) planted[static_cast<size_t>(f)] = true;
    }
    for (const Segment& segment : segments) {
      const int from = static_cast<int>(std::lround(segment.start_frame)) - first, to = static_cast<int>(std::lround(segment.end_frame)) - first;
      if (!segment.steady || from < 0 || to >= piece_frames || to - from < 3) continue;
      StepCurves step;
      for (int f = from; f <= to; ++f) {
        step.contact_m.push_back(planted[static_cast<size_t>(f)] ? contact.distance_m[f] : std::nan(""));
        if (f < to) step.difference_m2.push_back(differences[static_cast<size_t>(f)]);
      }
      (*curves)[segment.primitive].push_back(std::move(step));
    }
  }
}

CurvesByPrimitive CurvesOf(const std::vector<MotionClip>& clips, int piece_frames, const StudyOptions& options) {
  std::vector<CurvesByPrimitive> parts(clips.size());
  ParallelFor(options.jobs, static_cast<int>(clips.size()),
              [&](int i) { AddStepCurves(clips[static_cast<size_t>(i)], piece_frames, options, &parts[static_cast<size_t>(i)]); });
  CurvesByPrimitive all;
  for (CurvesByPrimitive& part : parts) {
    for (auto& [primitive, curves] : part) {
      for (StepCurves& step : curves) all[primitive].push_back(std::move(step));
    }
  }
  return all;
}

double MeanContact(const std::vector<StepCurves>& steps) {
  double sum = 0;
  int count = 0;
  for (const StepCurves& step : steps) {
    for (const double value : step.contact_m) {
      if (std::isfinite(value)) sum += value, ++count;
    }
  }
  return count > 0 ? sum / count : 0;
}

double MeanNaturalness(const std::vector<StepCurves>& steps) {
  double sum = 0;
  for (const StepCurves& step : steps) sum += NaturalnessVariance(step.difference_m2);
  return steps.empty() ? 0 : sum / static_cast<double>(steps.size());
}

// `kCurves` steps of the set as faint curves, and their frame by frame mean over all steps.
void AddCurves(const std::vector<StepCurves>& steps, const std::string& name, double scale, std::vector<double> StepCurves::*values,
               Chart* chart) {
  const size_t drawn = std::min<size_t>(kCurves, steps.size());
  for (size_t k = 0; k < drawn; ++k) {
    ChartSeries series{name};
    series.faint = true;
    const std::vector<double>& curve = steps[k * steps.size() / drawn].*values;
    for (size_t f = 0; f < curve.size(); ++f) series.x.push_back(static_cast<double>(f)), series.y.push_back(scale * curve[f]);
    chart->series.push_back(std::move(series));
  }
  ChartSeries mean{name};  // bold, in the colour of the faint ones
  for (size_t f = 0;; ++f) {
    double sum = 0;
    size_t count = 0;
    for (const StepCurves& step : steps) {
      const std::vector<double>& curve = step.*values;
      if (f < curve.size() && std::isfinite(curve[f])) sum += curve[f], ++count;
    }
    if (2 * count < steps.size() || count == 0) break;  // the mean of the few longest steps would be another mean
    mean.x.push_back(static_cast<double>(f)), mean.y.push_back(scale * sum / static_cast<double>(count));
  }
  chart->series.push_back(std::move(mean));
}

double Ratio(double synthesised, double captured) { return captured > 0 ? synthesised / captured : std::nan(""); }

Json QualityJson(const SetQuality& quality) {
  return {{"clips", quality.clips},
          {"pieces", quality.pieces},
          {"contact_distance_m", quality.contact_distance_m},
          {"naturalness_m4", quality.naturalness},
          {"foot_skate_cm_s", quality.foot_skate_cm_s},
          {"planted_skate_cm_s", quality.planted_skate_cm_s},
          {"acceleration_p999_m_s2", quality.acceleration_p999_m_s2},
          {"mean_jerk_m_s3", quality.mean_jerk_m_s3},
          {"penetration_m", quality.penetration_m}};
}

std::string Percent(double part, double whole) { return whole > 0 ? ShortNumber(100 * part / whole, 2) + " %" : "no part"; }

std::optional<double> Finite(double value) { return std::isfinite(value) ? std::optional(value) : std::nullopt; }

// What is compared: a model's clips with the ones that it was learned from.
struct Compared {
  std::string name;  // "clean"
  StyledClips synthesised = {}, captured = {};
  SetQuality synthesised_quality = {}, captured_quality = {};  // of all styles, in the proportion of the capture
  CurvesByPrimitive synthesised_curves = {}, captured_curves = {};
};

Compared Compare(StudyContext& context, StudyData data, int piece_frames) {
  const StudyOptions& options = context.options();
  Compared compared{data == StudyData::kClean ? "clean" : "noisy"};
  const std::vector<MotionClip> captured = AtEvaluationRate(context.clips(data), options.jobs);
  compared.captured = ByStyle(captured);
  compared.synthesised = DrawStyles(*context.Model(data), {.clips = options.quick ? 8 : 100, .seed = options.seed, .jobs = options.jobs});
  const std::vector<MotionClip> synthesised = InProportion(compared.synthesised, compared.captured);
  compared.captured_quality = MeasureSet(captured, {.piece_frames = piece_frames});
  compared.synthesised_quality = MeasureSet(synthesised, {.piece_frames = piece_frames});
  compared.captured_curves = CurvesOf(captured, piece_frames, options);
  compared.synthesised_curves = CurvesOf(synthesised, piece_frames, options);
  return compared;
}

// The steady kinds of steps that both sets hold, those with most captured steps first, two at most: Du's M(s2) and M(s3).
std::vector<std::string> TwoPrimitives(const Compared& compared) {
  std::vector<std::pair<size_t, std::string>> found;
  for (const auto& [primitive, steps] : compared.captured_curves) {
    const auto other = compared.synthesised_curves.find(primitive);
    if (other != compared.synthesised_curves.end() && steps.size() >= 2 && other->second.size() >= 2) found.emplace_back(steps.size(), primitive);
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> names;
  for (size_t i = 0; i < std::min<size_t>(2, found.size()); ++i) names.push_back(found[i].second);
  std::sort(names.rbegin(), names.rend());  // right before left, as in the tables
  return names;
}

void DrawCurves(const Compared& compared, const std::string& primitive, StudySection* section) {
  const std::vector<StepCurves>&captured = compared.captured_curves.at(primitive), &synthesised = compared.synthesised_curves.at(primitive);
  Chart contact{.title = primitive + ", " + compared.name + ": contact distance",
                .x_label = "frame of the step, 30 a second",
                .y_label = "contact distance, mm",
                .better = "lower",
                .caption = std::to_string(std::min<size_t>(kCurves, captured.size())) + " captured and " + std::to_string(std::min<size_t>(kCurves, synthesised.size())) +
                           " synthesised steps (Du Fig. 4.19, 4.20), bold: mean of all. Height of the planted foot over the plane on which the feet stand."};
  Chart difference{.title = primitive + ", " + compared.name + ": forward difference",
                   .x_label = "frame of the step, 30 a second",
                   .y_label = "frame distance to the next frame, cm²",
                   .caption = "The same steps (Du Fig. 4.18, 4.21), bold: mean of all. How far the body moves from frame to frame. Synthesised curves should lie "
                              "among the captured ones."};
  for (const auto& [steps, name] : {std::pair{&captured, "captured"}, std::pair{&synthesised, "synthesised"}}) {
    AddCurves(*steps, name, 1000, &StepCurves::contact_m, &contact);
    AddCurves(*steps, name, 1e4, &StepCurves::difference_m2, &difference);
  }
  section->drawings.push_back(std::move(contact));
  section->drawings.push_back(std::move(difference));
}

// Du's figures for a set of data, of right and left first steps.
struct Published {
  double contact[2], naturalness[2];

  double least_contact() const { return std::min(contact[0], contact[1]); }
  double least_naturalness() const { return std::min(naturalness[0], naturalness[1]); }
  static int Side(const std::string& primitive) { return primitive.rfind("right", 0) == 0 ? 0 : 1; }
};
constexpr Published kPublishedClean{{1.43, 1.11}, {1.12, 1.69}}, kPublishedNoisy{{5.7, 4.1}, {5.1, 1.8}};

void AddFigures(const Compared& compared, const Published& published, bool noisy, StudySection* section) {
  const SetQuality &a = compared.synthesised_quality, &b = compared.captured_quality;
  const std::string trained = noisy ? ", trained on noisy clips" : ", clean";
  const std::string setting = "all steps of the clips, in pieces of one length; Du's are for 20 steps of two kinds, of other recordings";
  const double least_contact = published.least_contact(), least_naturalness = published.least_naturalness();
  section->figures.push_back({"contact distance, synthesised / captured" + trained, Finite(Ratio(a.contact_distance_m, b.contact_distance_m)), "",
                              least_contact, "Du Table 4.4", std::nullopt, noisy ? 1.2 : 1.0,
                              "synthesised " + ShortNumber(1000 * a.contact_distance_m, 3) + ", captured " + ShortNumber(1000 * b.contact_distance_m, 3) + " mm; " + setting});
  section->figures.push_back({"naturalness, synthesised / captured" + trained, Finite(Ratio(a.naturalness, b.naturalness)), "",
                              least_naturalness, "Du Table 4.5", noisy ? std::nullopt : std::optional(0.9), noisy ? 1.3 : 1.1,
                              "synthesised " + ShortNumber(1e8 * a.naturalness, 3) + ", captured " + ShortNumber(1e8 * b.naturalness, 3) + " cm⁴; " + setting});
  for (const std::string& primitive : TwoPrimitives(compared)) {
    const std::vector<StepCurves>&captured = compared.captured_curves.at(primitive), &drawn = compared.synthesised_curves.at(primitive);
    const std::string note = std::to_string(captured.size()) + " captured, " + std::to_string(drawn.size()) + " synthesised steps";
    const auto means = [&](double synthesised, double of_captured, const char* unit) {
      return "synthesised " + ShortNumber(synthesised, 3) + ", captured " + ShortNumber(of_captured, 3) + unit + note;
    };
    section->figures.push_back({"contact distance of " + primitive + trained, Finite(Ratio(MeanContact(drawn), MeanContact(captured))), "",
                                published.contact[Published::Side(primitive)], "Du Table 4.4", std::nullopt, std::nullopt,
                                means(1000 * MeanContact(drawn), 1000 * MeanContact(captured), " mm; ")});
    section->figures.push_back({"naturalness of " + primitive + trained, Finite(Ratio(MeanNaturalness(drawn), MeanNaturalness(captured))), "",
                                published.naturalness[Published::Side(primitive)], "Du Table 4.5", std::nullopt, std::nullopt,
                                means(1e8 * MeanNaturalness(drawn), 1e8 * MeanNaturalness(captured), " cm⁴; ")});
    section->data[compared.name]["primitives"][primitive] = {{"captured_steps", captured.size()},
                                                             {"synthesised_steps", drawn.size()},
                                                             {"contact_distance_captured_m", MeanContact(captured)},
                                                             {"contact_distance_synthesised_m", MeanContact(drawn)},
                                                             {"naturalness_captured_m4", MeanNaturalness(captured)},
                                                             {"naturalness_synthesised_m4", MeanNaturalness(drawn)}};
  }
  section->figures.push_back({"foot skate, synthesised / captured" + trained, Finite(Ratio(a.foot_skate_cm_s, b.foot_skate_cm_s)), "", std::nullopt,
                              "", std::nullopt, noisy ? std::nullopt : std::optional(0.8), ""});
  section->figures.push_back({"the part of it from planted balls" + trained, Finite(Ratio(a.planted_skate_cm_s, b.planted_skate_cm_s)), "", std::nullopt, "",
                              std::nullopt, std::nullopt, Percent(b.planted_skate_cm_s, b.foot_skate_cm_s) + " of captured skate; the rest is feet in the air, low over the floor"});
  section->figures.push_back({"99.9th percentile of joint acceleration, synthesised / captured" + trained,
                              Finite(Ratio(a.acceleration_p999_m_s2, b.acceleration_p999_m_s2)), "", std::nullopt, "", std::nullopt, std::nullopt, ""});
  section->figures.push_back({"mean jerk, synthesised / captured" + trained, Finite(Ratio(a.mean_jerk_m_s3, b.mean_jerk_m_s3)), "", std::nullopt, "",
                              std::nullopt, std::nullopt, ""});
}

// Ratios style by style, as bars; and into the data. What has a published figure has a chart of its own, in which it is marked.
std::vector<Chart> StyleRatios(const Compared& compared, const Published& published, int piece_frames, Json* data) {
  const auto of = [&](const std::string& what, const std::string& better, const std::string& caption) {
    return Chart{.title = what + ", synthesised / captured by style, " + compared.name, .x_label = "style", .y_label = "synthesised / captured", .better = better, .caption = caption};
  };
  std::vector<Chart> charts = {of("Contact distance", "lower", "Published: the better of the two steps of Du Table 4.4."),
                               of("Naturalness", "", "1 is as captured, and best. Published: the better of the two steps of Du Table 4.5."),
                               of("Feet and flow", "", "1 is as captured. Foot skate: lower is better; acceleration (its 99.9th percentile) and jerk are best at 1.")};
  charts[0].marks = {{"published", published.least_contact()}};
  charts[1].marks = {{"published", published.least_naturalness()}};
  charts[2].marks = {{"as captured", 1}};
  const std::array<std::pair<const char*, double SetQuality::*>, 5> measures = {{{"contact distance", &SetQuality::contact_distance_m},
                                                                               {"naturalness", &SetQuality::naturalness},
                                                                               {"foot skate", &SetQuality::foot_skate_cm_s},
                                                                               {"acceleration", &SetQuality::acceleration_p999_m_s2},
                                                                               {"jerk", &SetQuality::mean_jerk_m_s3}}};
  const auto chart_of = [&](size_t measure) -> Chart& { return charts[std::min<size_t>(measure, 2)]; };
  for (size_t m = 0; m < measures.size(); ++m) chart_of(m).series.push_back({.name = measures[m].first, .x = {}, .y = {}, .form = Form::kBars});
  for (const auto& [style, clips] : compared.captured) {
    const auto drawn = compared.synthesised.find(style);
    const auto holds = [&](const MotionClip& clip) { return clip.frame_count() >= piece_frames; };
    if (drawn == compared.synthesised.end() || std::none_of(clips.begin(), clips.end(), holds)) continue;
    const SetQuality captured = MeasureSet(clips, {.piece_frames = piece_frames});
    const SetQuality synthesised = MeasureSet(drawn->second, {.piece_frames = piece_frames});
    (*data)["styles"][StyleLabel(style)] = {{"captured", QualityJson(captured)}, {"synthesised", QualityJson(synthesised)}};
    for (size_t m = 0; m < measures.size(); ++m) {
      ChartSeries& series = chart_of(m).series[m < 2 ? 0 : m - 2];
      series.x.push_back(static_cast<double>(charts[0].x_names.size()));
      series.y.push_back(Ratio(synthesised.*measures[m].second, captured.*measures[m].second));
    }
    for (Chart& chart : charts) chart.x_names.push_back(StyleLabel(style));
  }
  return charts;
}

}  // namespace

StudySection StudyFeetAndFlow(StudyContext& context) {
  const int piece_frames = PieceFrames(AtEvaluationRate(context.clips(StudyData::kClean), context.options().jobs));
  StudySection section{.id = "feet_and_flow", .title = "Feet and flow of the samples"};
  section.text =
      "Contact distance is the height of a planted foot over the plane on which the feet of the clip stand; it is taken where heel or ball "
      "is planted, as found from the clip itself. Naturalness is the variance of the frame distance from each frame to the next (Du Eq. 4.6). "
      "Captured and synthesised clips go through the same code: 30 frames a second, cut into pieces of " +
      std::to_string(piece_frames) +
      " frames, as long ones would compare badly with short ones.\n\nThe published work compares synthesised steps with the captured ones that "
      "its model was learned from, and so does this: a model of noisy clips is held against noisy clips. Beside it stands what matters to those "
      "who use such a model, its clips against the clean capture.\n\nFoot skate is the speed of the balls of the feet, weighted by how near to the "
      "floor they are, standing or not. Most of it is the swinging foot, which passes low over the floor at two or three metres a second, as captured "
      "feet do; what can be seen as sliding is the part from planted balls, which is given beside it.";
  section.data["piece_frames"] = piece_frames;

  const Compared clean = Compare(context, StudyData::kClean, piece_frames);
  for (const std::string& primitive : TwoPrimitives(clean)) DrawCurves(clean, primitive, &section);
  AddFigures(clean, kPublishedClean, false, &section);
  Json& data = section.data;
  data["clean"]["captured"] = QualityJson(clean.captured_quality);
  data["clean"]["synthesised"] = QualityJson(clean.synthesised_quality);
  for (Chart& chart : StyleRatios(clean, kPublishedClean, piece_frames, &data["clean"])) section.drawings.push_back(std::move(chart));

  try {
    const Compared noisy = Compare(context, StudyData::kNoisy, piece_frames);
    for (const std::string& primitive : TwoPrimitives(noisy)) DrawCurves(noisy, primitive, &section);
    AddFigures(noisy, kPublishedNoisy, true, &section);
    const SetQuality &a = noisy.synthesised_quality, &b = clean.captured_quality;
    section.figures.push_back({"contact distance, trained on noisy clips, against the clean capture", Finite(Ratio(a.contact_distance_m, b.contact_distance_m)),
                               "", std::nullopt, "", std::nullopt, std::nullopt, "noisy capture against clean capture: " +
                               ShortNumber(Ratio(noisy.captured_quality.contact_distance_m, b.contact_distance_m), 3)});
    section.figures.push_back({"naturalness, trained on noisy clips, against the clean capture", Finite(Ratio(a.naturalness, b.naturalness)), "",
                               std::nullopt, "", std::nullopt, std::nullopt, "noisy capture against clean capture: " +
                               ShortNumber(Ratio(noisy.captured_quality.naturalness, b.naturalness), 3)});
    data["noisy"]["captured"] = QualityJson(noisy.captured_quality);
    data["noisy"]["synthesised"] = QualityJson(noisy.synthesised_quality);
    for (Chart& chart : StyleRatios(noisy, kPublishedNoisy, piece_frames, &data["noisy"])) section.drawings.push_back(std::move(chart));
  } catch (const std::runtime_error& unfit) {  // noise can leave too few steps to learn from
    section.text += "\n\nLeft out for noisy clips: " + std::string(unfit.what());
    const std::string why = "no model can be learned from the noisy clips";
    section.figures.push_back({"contact distance, synthesised / captured, trained on noisy clips", std::nullopt, "", 4.1, "Du Table 4.4", std::nullopt, 1.2, why});
    section.figures.push_back({"naturalness, synthesised / captured, trained on noisy clips", std::nullopt, "", 1.8, "Du Table 4.5", std::nullopt, 1.3, why});
    data["noisy"] = nullptr;
  }
  return section;
}

}  // namespace morphograph
