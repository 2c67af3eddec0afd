#include "api/study/alignment_study.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "api/study/markup.h"
#include "api/study/study_steps.h"
#include "datasets/forward_kinematics.h"
#include "datasets/parallel_for.h"
#include "primitives/alignment_quality.h"
#include "primitives/frame_distance.h"

namespace morphograph {
namespace {

using Frames = std::vector<Eigen::Matrix3Xd>;
using nlohmann::ordered_json;

// A way to align that is held against the others.
struct Way {
  std::string key, name;
  std::string bar;  // under its bar of the chart; empty: not drawn
  Eigen::VectorXd weights;
  AlignmentTransform transform = AlignmentTransform::kEachFrame;
};

constexpr std::array kPowers = {0, 1, 2, 3, 4};
constexpr size_t kNoWeights = 0, kDepthWeights = 1;  // ways 0 to 4 are the powers of depth

// Joints at or below those of two roles.
Eigen::VectorXd Below(const Skeleton& skeleton, JointRole left, JointRole right) {
  Eigen::VectorXd below = Eigen::VectorXd::Zero(skeleton.joint_count());
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    const int parent = skeleton.parent(j);
    if (j == skeleton.roles()[left] || j == skeleton.roles()[right] || (parent >= 0 && below[parent] > 0)) below[j] = 1;
  }
  return below;
}

std::vector<Way> Ways(const Skeleton& skeleton) {
  const Eigen::VectorXd by_depth = FrameDistanceWeights(skeleton);
  const Eigen::ArrayXd bones = (by_depth.array() > 0).cast<double>();
  // 1 + depth of every joint; the weights are 1 over that, but for a scale.
  const Eigen::ArrayXd level = (bones > 0).select(by_depth[skeleton.moving_root()] / by_depth.array().max(1e-12), 1.0);
  std::vector<Way> ways;
  for (const int power : kPowers) {
    const std::string text = power == 0 ? "unweighted" : power == 1 ? "1 / (1 + depth)" : "1 / (1 + depth)^" + std::to_string(power);
    const std::string bar = power == 0 ? "none" : power == 1 ? "depth" : power == 2 ? "depth²" : "";
    ways.push_back({power == 0 ? "unweighted" : "depth_power_" + std::to_string(power), text, bar, bones * level.pow(-power)});
  }
  ways.push_back({"depth_straight", "falling in a straight line", "line", bones * (level.maxCoeff() + 1 - level)});
  const Eigen::ArrayXd arms = Below(skeleton, JointRole::kLeftShoulder, JointRole::kRightShoulder).array();
  const Eigen::ArrayXd legs = Below(skeleton, JointRole::kLeftHip, JointRole::kRightHip).array();
  ways.push_back({"without_arms", "unweighted, without arms", "no arms", bones * (1 - arms)});
  ways.push_back({"without_legs", "unweighted, without legs", "no legs", bones * (1 - legs)});
  ways.push_back({"without_limbs", "unweighted, trunk and head only", "trunk", bones * (1 - arms) * (1 - legs)});
  ways.push_back({"unweighted_segment", "unweighted, one move for the step", "one move", bones, AlignmentTransform::kSegment});
  ways.push_back({"weighted_segment", "1 / (1 + depth), one move for the step", "", ways[kDepthWeights].weights, AlignmentTransform::kSegment});
  for (Way& way : ways) way.weights /= way.weights.sum();
  return ways;
}

struct Quality {
  double path_difference_m = 0, speed_variance = 0;
  int steps = 0;
  void Add(const Eigen::Matrix2Xd& path, const Eigen::Matrix2Xd& reference, double rate_hz) {
    path_difference_m += PathDifference(path, reference);
    speed_variance += SpeedVariance(path, rate_hz);
    ++steps;
  }
  void Finish() { path_difference_m /= std::max(1, steps), speed_variance /= std::max(1, steps); }
};

// The frames of all steps of one kind of data.
struct StepFrames {
  StudySteps steps;
  std::vector<Frames> clips;
  int root = 0;

  double rate_hz(size_t c, int member) const { return set().clips[step(c, member).clip].clip.frame_rate_hz(); }
  const TrainingSet& set() const { return steps.set; }
  const TrainingStep& step(size_t c, int member) const { return set().steps[steps.members(c).members[member]]; }
  Frames Of(size_t c, int member) const {
    const TrainingStep& of = step(c, member);
    const auto first = clips[of.clip].begin();
    return {first + std::lround(of.span.start_frame), first + std::lround(of.span.end_frame) + 1};
  }
  double Turn(size_t c, int member) const {
    const TrainingStep& of = step(c, member);
    const MotionClip& clip = set().clips[of.clip].clip;
    return std::remainder(HeadingRad(clip, static_cast<int>(std::lround(of.span.end_frame))) -
                              HeadingRad(clip, static_cast<int>(std::lround(of.span.start_frame))),
                          2 * M_PI);
  }
};

StepFrames ReadFrames(const StudyContext& context, StudyData data) {
  StepFrames frames{FindStudySteps(context, data), {}, 0};
  frames.clips.resize(frames.set().clips.size());
  ParallelFor(context.options().jobs, static_cast<int>(frames.clips.size()),
              [&](int i) { frames.clips[i] = JointPositions(frames.set().clips[i].clip); });
  frames.root = frames.set().layout.skeleton().moving_root();
  return frames;
}

// [class][way], steady steps other than the reference; the raw steps' own speed variance comes last in each class.
std::vector<std::vector<Quality>> MeasureClasses(const StepFrames& frames, const std::vector<Way>& ways, int jobs) {
  std::vector<std::vector<Quality>> quality(frames.steps.classes.size(), std::vector<Quality>(ways.size() + 1));
  ParallelFor(jobs, static_cast<int>(quality.size()), [&](int c) {
    const AlignedClass& aligned = frames.steps.aligned[c];
    const Frames reference = frames.Of(c, aligned.reference);
    const Eigen::Matrix2Xd path = FloorPath(reference, frames.root);
    const double rate_hz = frames.rate_hz(c, aligned.reference);
    for (const int m : aligned.steady) {
      const Frames test = frames.Of(c, m);
      if (m == aligned.reference || !CanWarp(static_cast<int>(reference.size()), static_cast<int>(test.size()))) continue;
      for (size_t w = 0; w < ways.size(); ++w) {
        quality[c][w].Add(AlignSegment(reference, test, ways[w].weights, frames.root, ways[w].transform).root, path, rate_hz);
      }
      quality[c].back().speed_variance += SpeedVariance(FloorPath(test, frames.root), frames.rate_hz(c, m));
      ++quality[c].back().steps;
    }
    for (Quality& q : quality[c]) q.Finish();
  });
  return quality;
}

// Steps of all styles against the reference of the first style's class of that name: more unlike than those of one style.
std::vector<Quality> MeasurePooled(const StepFrames& frames, const std::vector<Way>& ways, int jobs) {
  std::vector<std::vector<Quality>> of_class(frames.steps.classes.size(), std::vector<Quality>(2));
  ParallelFor(jobs, static_cast<int>(of_class.size()), [&](int c) {
    size_t first = 0;
    while (frames.steps.members(first).primitive != frames.steps.members(c).primitive) ++first;
    const int own = frames.steps.aligned[first].reference;
    const Frames reference = frames.Of(first, own);
    const Eigen::Matrix2Xd path = FloorPath(reference, frames.root);
    for (const int m : frames.steps.aligned[c].steady) {
      const Frames test = frames.Of(c, m);
      if ((static_cast<size_t>(c) == first && m == own) || !CanWarp(static_cast<int>(reference.size()), static_cast<int>(test.size()))) continue;
      for (const size_t w : {kNoWeights, kDepthWeights})
        of_class[c][w].Add(AlignSegment(reference, test, ways[w].weights, frames.root).root, path, frames.rate_hz(first, own));
    }
  });
  std::vector<Quality> all(2);
  for (const std::vector<Quality>& quality : of_class) {
    for (const size_t w : {kNoWeights, kDepthWeights}) {
      all[w].path_difference_m += quality[w].path_difference_m;
      all[w].speed_variance += quality[w].speed_variance;
      all[w].steps += quality[w].steps;
    }
  }
  for (Quality& q : all) q.Finish();
  return all;
}

// Mean over the classes that have steps.
std::vector<Quality> MeanOverClasses(const std::vector<std::vector<Quality>>& classes) {
  std::vector<Quality> mean(classes.front().size());
  for (size_t w = 0; w < mean.size(); ++w) {
    int counted = 0;
    for (const std::vector<Quality>& of_class : classes) {
      if (of_class[w].steps == 0) continue;
      mean[w].path_difference_m += of_class[w].path_difference_m;
      mean[w].speed_variance += of_class[w].speed_variance;
      mean[w].steps += of_class[w].steps;
      ++counted;
    }
    mean[w].path_difference_m /= std::max(1, counted);
    mean[w].speed_variance /= std::max(1, counted);
  }
  return mean;
}

ordered_json QualityJson(const Quality& quality) {
  return {{"path_difference_m", quality.path_difference_m}, {"speed_variance_m2_s2", quality.speed_variance}, {"steps", quality.steps}};
}

// The step of the first class that turns most against its reference: Du's "hard" case.
int HardestStep(const StepFrames& frames, size_t c) {
  const AlignedClass& aligned = frames.steps.aligned[c];
  const double reference_turn = frames.Turn(c, aligned.reference);
  const int reference_frames = static_cast<int>(frames.Of(c, aligned.reference).size());
  int hardest = -1;
  double most = -1;
  for (const int m : aligned.steady) {
    const double turn = std::abs(std::remainder(frames.Turn(c, m) - reference_turn, 2 * M_PI));
    if (m == aligned.reference || turn <= most || !CanWarp(reference_frames, static_cast<int>(frames.Of(c, m).size()))) continue;
    most = turn, hardest = m;
  }
  return hardest;
}

ChartSeries Line(const std::string& name, const Eigen::Matrix2Xd& path, bool dashed = false) {
  ChartSeries line{.name = name, .x = {}, .y = {}};
  for (Eigen::Index f = 0; f < path.cols(); ++f) line.x.push_back(path(0, f)), line.y.push_back(path(1, f));
  line.dashed = dashed;
  return line;
}

ChartSeries Speeds(const std::string& name, const Eigen::Matrix2Xd& path, double rate_hz, bool dashed = false) {
  ChartSeries line{.name = name, .x = {}, .y = PathSpeeds(path, rate_hz)};
  for (size_t i = 0; i < line.y.size(); ++i) line.x.push_back((static_cast<double>(i) + 0.5) / rate_hz);
  line.dashed = dashed;
  return line;
}

// Fig. 3.7 and 4.9 to 4.11 for one step of the noisy data.
void DrawHardStep(const StepFrames& frames, const std::vector<Way>& ways, const std::string& data_name, StudySection* section) {
  const size_t c = 0;
  const int hard = HardestStep(frames, c);
  if (hard < 0) return;
  const int own = frames.steps.aligned[c].reference;
  const Frames reference = frames.Of(c, own), test = frames.Of(c, hard);
  const double rate_hz = frames.rate_hz(c, own);
  const SegmentAlignment weighted = AlignSegment(reference, test, ways[kDepthWeights].weights, frames.root);
  const SegmentAlignment unweighted = AlignSegment(reference, test, ways[kNoWeights].weights, frames.root);
  const double turn = std::abs(frames.Turn(c, hard)) * 180 / M_PI;
  const std::string which = frames.steps.Name(c) + ", " + data_name + ": a step that turns by " + FixedNumber(turn, 0) + " degrees";

  HeatMap map;
  map.title = "Frame distance of a step to its reference, and the warp";
  map.x_label = "frame of the step", map.y_label = "frame of the reference", map.value_label = "weighted frame distance, m²";
  map.caption = which + ". Dark and light: how unlike the two frames are after the best move. The curve is the cheapest way from the first to the "
                "last frames of both, found by dynamic time warping (Du Fig. 3.7).";
  map.values = weighted.distances;
  map.x_from = map.y_from = -0.5;
  map.x_to = static_cast<double>(test.size()) - 0.5, map.y_to = static_cast<double>(reference.size()) - 0.5;
  ChartSeries warp{.name = "warp", .x = {}, .y = {}};
  for (const WarpCell& cell : weighted.warp.cells) warp.x.push_back(cell.test), warp.y.push_back(cell.reference);
  map.over.push_back(warp);
  section->drawings.push_back(map);

  // The raw step is put where its first frame meets the reference's, to be seen beside it.
  PlanarTransform move;
  FrameDistance(reference.front(), test.front(), ways[kDepthWeights].weights, &move);
  Frames raw = test;
  for (Eigen::Matrix3Xd& pose : raw) pose.col(frames.root) = (move * Eigen::Vector3d(pose.col(frames.root))).eval();
  const Eigen::Matrix2Xd reference_path = FloorPath(reference, frames.root), raw_path = FloorPath(raw, frames.root);
  Chart paths;
  paths.title = "Path of the root over the floor";
  paths.x_label = "x, m", paths.y_label = "z, m", paths.y_from_zero = false;
  paths.caption = which + ". Aligned frame by frame, the root should run along the reference's (Du Fig. 4.10). Path difference: weighted " +
                  FixedNumber(1000 * PathDifference(weighted.root, reference_path), 1) + " mm, unweighted " +
                  FixedNumber(1000 * PathDifference(unweighted.root, reference_path), 1) + " mm.";
  paths.series = {Line("as captured", raw_path, true), Line("reference", reference_path), Line("unweighted", unweighted.root),
                  Line("weighted", weighted.root)};
  section->drawings.push_back(paths);
  Chart speeds;
  speeds.title = "Speed of the root";
  speeds.x_label = "time, s", speeds.y_label = "speed over the floor, m/s", speeds.better = "";
  speeds.caption = "The same step: jumps in speed are what looks unnatural in an aligned step (Du Fig. 4.11).";
  speeds.series = {Speeds("as captured", raw_path, frames.rate_hz(c, hard), true), Speeds("reference", reference_path, rate_hz),
                   Speeds("unweighted", unweighted.root, rate_hz), Speeds("weighted", weighted.root, rate_hz)};
  section->drawings.push_back(speeds);
  section->data["hard_step"] = {{"class", frames.steps.Name(c)},
                                {"data", data_name},
                                {"turn_deg", turn},
                                {"unweighted_m", PathDifference(unweighted.root, reference_path)},
                                {"weighted_m", PathDifference(weighted.root, reference_path)}};
}

}  // namespace

StudySection StudyAlignment(StudyContext& context) {
  StudySection section;
  section.id = "alignment";
  section.title = "Alignment: bringing steps onto a reference";
  Chart bars, powers;
  bars.title = "Path difference by how joints are weighted";
  bars.x_label = "weights of the joints", bars.y_label = "mean path difference, m", bars.better = "lower";
  bars.caption = "Distance of the aligned root from the reference's root (Du Eq. 4.4), mean over steps and classes. None: all joints alike; depth: "
                 "1 / (1 + depth), and its square; line: falling in a straight line with depth; then all alike but with some joints left out (trunk: with the "
                 "head, no limbs); one move: all alike, one turn and shift for the whole step.";
  powers.title = "How fast weights fall decides the ratio";
  powers.x_label = "power p of weights 1 / (1 + depth)^p", powers.y_label = "path difference / unweighted", powers.better = "lower";
  powers.caption = "The steeper the weights, the more of all weight rests on the root itself, and the nearer its path must come to the "
                   "reference's. With all weight on the root the ratio would be 0, whatever the body does.";
  powers.marks = {{"published, noisy", 0.218 / 0.496}, {"published, clean", 0.015 / 0.061}};

  const double jobs_share[] = {0, 0.5};
  double ratio[2] = {}, root_share[kPowers.size()] = {};
  std::string measured;
  for (const StudyData data : {StudyData::kClean, StudyData::kNoisy}) {
    const int d = static_cast<int>(data);
    const std::string name = DataName(data);
    if (context.options().progress) context.options().progress("alignment, " + name, jobs_share[d]);
    const StepFrames frames = ReadFrames(context, data);
    const Skeleton& skeleton = frames.set().layout.skeleton();
    const std::vector<Way> ways = Ways(skeleton);
    for (size_t p = 0; p < kPowers.size(); ++p) root_share[p] = ways[p].weights[skeleton.moving_root()];
    const std::vector<std::vector<Quality>> classes = MeasureClasses(frames, ways, context.options().jobs);
    const std::vector<Quality> mean = MeanOverClasses(classes);
    const std::vector<Quality> pooled = MeasurePooled(frames, ways, context.options().jobs);
    if (mean[kNoWeights].steps == 0) {
      section.text = "No class holds a second step to align to its reference.";
      return section;
    }
    ordered_json& out = section.data[name];
    ChartSeries bar{.name = name, .x = {}, .y = {}, .form = ChartSeries::Form::kBars};
    bars.x_names.clear();
    for (size_t w = 0; w < ways.size(); ++w) {
      out["mean"][ways[w].key] = QualityJson(mean[w]);
      out["mean"][ways[w].key]["weights"] = ways[w].name;
      out["mean"][ways[w].key]["weight_of_root"] = ways[w].weights[skeleton.moving_root()];
      if (ways[w].bar.empty()) continue;
      bar.x.push_back(static_cast<double>(bars.x_names.size())), bar.y.push_back(mean[w].path_difference_m);
      bars.x_names.push_back(ways[w].bar);
    }
    bars.series.push_back(bar);
    out["as_captured_speed_variance_m2_s2"] = mean.back().speed_variance;
    out["styles_pooled"] = {{"unweighted", QualityJson(pooled[kNoWeights])}, {"weighted", QualityJson(pooled[kDepthWeights])}};
    for (size_t c = 0; c < classes.size(); ++c) {
      ordered_json of_class = {{"class", frames.steps.Name(c)}};
      for (const size_t w : {kNoWeights, kDepthWeights}) of_class[ways[w].key] = QualityJson(classes[c][w]);
      out["classes"].push_back(of_class);
    }
    ChartSeries line{.name = name, .x = {}, .y = {}};
    for (size_t p = 0; p < kPowers.size(); ++p) {
      line.x.push_back(kPowers[p]);
      line.y.push_back(mean[p].path_difference_m / mean[kNoWeights].path_difference_m);
    }
    powers.series.push_back(line);
    ratio[d] = mean[kDepthWeights].path_difference_m / mean[kNoWeights].path_difference_m;
    const bool clean = data == StudyData::kClean;
    section.figures.push_back({.what = "path difference after alignment, weighted / unweighted, " + name,
                               .value = ratio[d],
                               .published = clean ? 0.015 / 0.061 : 0.218 / 0.496,
                               .source = "Du Table 4.3",
                               .at_most = clean ? 0.25 : 0.44,
                               .note = "weights 1 / (1 + depth) on these skeletons; squared, " +
                                       FixedNumber(mean[2].path_difference_m / mean[kNoWeights].path_difference_m) + ": see the section"});
    section.figures.push_back({.what = "path difference after alignment, weighted, " + name,
                               .value = mean[kDepthWeights].path_difference_m,
                               .unit = "m",
                               .published = clean ? 0.015 : 0.218,
                               .source = "Du Table 4.3",
                               .note = "unweighted " + FixedNumber(mean[kNoWeights].path_difference_m, 4) + " m, published " +
                                       (clean ? "0.061" : "0.496") + " m"});
    section.figures.push_back({.what = "variance of speed after alignment, weighted / unweighted, " + name,
                               .value = RatioTo(mean[kDepthWeights].speed_variance, mean[kNoWeights].speed_variance),
                               .published = clean ? 0.0009 / 0.0074 : 140.329 / 686.414,
                               .source = "Du Table 4.3",
                               .note = "weighted " + FixedNumber(mean[kDepthWeights].speed_variance, 4) + " m²/s², as captured " +
                                       FixedNumber(mean.back().speed_variance, 4)});
    measured += "On " + name + " data the path difference is " + FixedNumber(1000 * mean[kNoWeights].path_difference_m, 1) +
                " mm without weights and " + FixedNumber(1000 * mean[kDepthWeights].path_difference_m, 1) + " mm with them, a ratio of " +
                FixedNumber(ratio[d]) + " (steps of all styles against one reference: " +
                FixedNumber(pooled[kDepthWeights].path_difference_m / std::max(1e-12, pooled[kNoWeights].path_difference_m)) + "). Squared weights give " +
                FixedNumber(mean[2].path_difference_m / mean[kNoWeights].path_difference_m) + ", cubed ones " +
                FixedNumber(mean[3].path_difference_m / mean[kNoWeights].path_difference_m) +
                ", weights that fall in a straight line " + FixedNumber(mean[5].path_difference_m / mean[kNoWeights].path_difference_m) +
                ". Without any weights but with the arms left out it is " +
                FixedNumber(mean[6].path_difference_m / mean[kNoWeights].path_difference_m) + " of the whole body's, without the legs " +
                FixedNumber(mean[7].path_difference_m / mean[kNoWeights].path_difference_m) + ", with trunk and head only " +
                FixedNumber(mean[8].path_difference_m / mean[kNoWeights].path_difference_m) +
                ". One move for a whole step in place of one for each frame leaves " + FixedNumber(1000 * mean[9].path_difference_m, 1) +
                " mm unweighted and " + FixedNumber(1000 * mean[10].path_difference_m, 1) + " mm weighted.\n\n";
    if (data == StudyData::kNoisy) DrawHardStep(frames, ways, name, &section);
  }
  section.drawings.insert(section.drawings.begin(), {bars, powers});
  section.text =
      "Every step is aligned to the reference step of its class (the one least unlike the others): dynamic time warping under the frame "
      "distance, then each frame is moved by the turn and shift that bring it closest to its reference frame (Du 3.2, 4.3). Weights fall "
      "with a joint's depth in the skeleton, 1 / (1 + depth); unweighted means all joints alike. The path difference is how far the root "
      "then lies from the reference's root, on average; lower is better. Classes are those of training, one a style and side, and their "
      "means are averaged.\n\n" +
      measured +
      "How to read the ratio: where every frame is moved on its own, the root can lie off only because the rest of the body pulls it. So the "
      "ratio is mostly a matter of how much of all weight the root itself has: on this skeleton " +
      FixedNumber(100 * root_share[0], 0) + " % without weights, " + FixedNumber(100 * root_share[1], 0) + " % with 1 / (1 + depth), " +
      FixedNumber(100 * root_share[2], 0) + " % with that squared. Du does not print the weights, only that they are \"inverse linearly "
      "proportional\" to depth; the chart shows how steep they must be for the published ratios. His unweighted steps lie 61 mm "
      "(Vicon) and 496 mm (markerless) off, ours a few millimetres to centimetres: classes by style and side, cuts at sub-frame key "
      "frames and a skeleton without fingers leave little for weights to mend; and noise of the root itself, or of the reference, no weights can "
      "mend. A ratio alone can be driven to zero by weighting nothing but "
      "the root, which aligns the body no better; steeper weights were therefore not taken for the sake of this figure.";
  return section;
}

}  // namespace morphograph
