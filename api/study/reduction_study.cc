#include "api/study/reduction_study.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "api/study/markup.h"
#include "api/study/study_steps.h"
#include "datasets/errors.h"
#include "datasets/parallel_for.h"
#include "primitives/frame_distance.h"
#include "primitives/locally_linear_embedding.h"
#include "primitives/step_vector.h"
#include "primitives/weighted_pca.h"

namespace morphograph {
namespace {

using nlohmann::ordered_json;

enum ReductionMethod { kWeighted, kByDepth, kPlain, kLle, kReductionMethods };
const std::array<std::string, kReductionMethods> kReductionMethodNames = {"weighted PCA", "PCA weighted by depth", "plain PCA", "locally linear embedding"};
const std::array<std::string, kReductionMethods> kReductionMethodKeys = {"weighted_pca", "depth_weighted_pca", "plain_pca", "lle"};
constexpr int kFewestForReduction = 8;  // in either half of a class
const std::vector<int> kLleComponents = {1, 2, 3, 5, 8, 12, 16, 20};
constexpr int kComparedAt = 8;  // components at which methods are held against each other

// Of one class and one split: errors against the number of components (0, 1, …).
struct Curves {
  std::vector<double> taught, left_out;  // weighted squared error, mean over steps, m^2
  std::vector<double> kept;              // variance kept on the steps taught, in the method's own weights
  int for_99 = 0;                        // components that keep 99 %
};

struct ReductionResult {
  int taught = 0, left_out = 0;
  std::array<Curves, kReductionMethods> curves;   // of kLle: at kLleComponents only
  LocallyLinearEmbeddingOptions lle;     // that the curve is drawn with
  double neighbours_alone = 0;           // left out, made of as many neighbours without any coordinates
  std::vector<double> lle_sweep;         // left out at kComparedAt, by neighbours and regularisation
};

const std::vector<LocallyLinearEmbeddingOptions>& Sweep() {
  static const std::vector<LocallyLinearEmbeddingOptions> sweep = [] {
    std::vector<LocallyLinearEmbeddingOptions> all;
    for (const int neighbours : {12, 24, 48, 96}) {
      for (const double regularisation : {1e-4, 1e-3, 1e-2}) all.push_back({neighbours, regularisation, kComparedAt});
    }
    return all;
  }();
  return sweep;
}
// Where nothing is swept.
const LocallyLinearEmbeddingOptions kLleUsual{12, 1e-2, kComparedAt};

// Weighted squared error of the first k = 0, 1, … components, mean over the columns. Components are orthonormal in their own weights,
// so each takes its part away from what is left.
std::vector<double> Errors(const WeightedPca& pca, const Eigen::MatrixXd& steps, const Eigen::VectorXd& judged_by) {
  std::vector<double> errors;
  Eigen::MatrixXd left = steps.colwise() - pca.mean;
  const Eigen::MatrixXd latents = pca.ProjectAll(steps);
  for (Eigen::Index k = 0;; ++k) {
    errors.push_back((judged_by.asDiagonal() * left.cwiseAbs2()).sum() / static_cast<double>(steps.cols()));
    if (k == latents.rows()) return errors;
    left -= pca.basis.col(k) * latents.row(k);
  }
}

Curves PcaCurves(const Eigen::MatrixXd& taught, const Eigen::MatrixXd& left_out, const Eigen::VectorXd& weights,
                 const Eigen::VectorXd& judged_by) {
  const WeightedPca pca = FitWeightedPca(taught, weights, {.variance_kept = 1});
  Curves curves{Errors(pca, taught, judged_by), Errors(pca, left_out, judged_by), {0}, 0};
  const double all = pca.variances.sum();
  for (Eigen::Index k = 0; k < pca.variances.size(); ++k) {
    curves.kept.push_back(curves.kept.back() + (all > 0 ? pca.variances[k] / all : 0));
    if (curves.for_99 == 0 && curves.kept.back() >= 0.99) curves.for_99 = static_cast<int>(k) + 1;
  }
  return curves;
}

double LleError(const LocallyLinearEmbedding& embedding, const Eigen::MatrixXd& scaled) {
  double error = 0;
  for (Eigen::Index i = 0; i < scaled.cols(); ++i)
    error += (embedding.Reconstruct(embedding.Embed(scaled.col(i))) - scaled.col(i)).squaredNorm();
  return error / static_cast<double>(scaled.cols());
}

// Weights of Du 4.4: 1 / (1 + depth) of the joint that a value belongs to, 1 for the root's place and for timing.
Eigen::VectorXd DepthWeights(const PoseLayout& layout) {
  const Eigen::VectorXd joints = FrameDistanceWeights(layout.skeleton());
  const double root = joints[layout.skeleton().moving_root()];
  Eigen::VectorXd channels = Eigen::VectorXd::Ones(layout.channels());
  for (size_t n = 0; n < layout.active_joints().size(); ++n) {
    // A joint without bone weighs nothing as a point, and still turns what hangs on it: then its child's.
    const double weight = joints[layout.active_joints()[n]] / root;
    channels.segment<3>(3 + 3 * static_cast<Eigen::Index>(n)).setConstant(weight > 0 ? weight : 0.5);
  }
  Eigen::VectorXd weights(layout.channels() * kPhaseSamples + kTimingValues);
  weights << channels.replicate(kPhaseSamples, 1), Eigen::VectorXd::Ones(kTimingValues);
  return weights;
}

ReductionResult ReductionsOfClass(const Eigen::MatrixXd& taught, const Eigen::MatrixXd& left_out, const Eigen::VectorXd& scale,
                       const Eigen::VectorXd& depth, bool quick) {
  ReductionResult result;
  result.taught = static_cast<int>(taught.cols()), result.left_out = static_cast<int>(left_out.cols());
  const Eigen::VectorXd weights = scale.cwiseAbs2();
  result.curves[kWeighted] = PcaCurves(taught, left_out, weights, weights);
  result.curves[kByDepth] = PcaCurves(taught, left_out, depth, weights);
  result.curves[kPlain] = PcaCurves(taught, left_out, Eigen::VectorXd::Ones(scale.size()), weights);

  // In all weighted components distances are the weighted ones, at a twelfth of the numbers. What of a step left out lies outside of them
  // is out of reach of any mean of the steps taught.
  const WeightedPca span = FitWeightedPca(taught, weights, {.variance_kept = 1});
  const Eigen::MatrixXd scaled = span.ProjectAll(taught), scaled_out = span.ProjectAll(left_out);
  const double outside = result.curves[kWeighted].left_out.back();
  result.lle = kLleUsual;
  for (const LocallyLinearEmbeddingOptions& options : Sweep()) {
    if (quick || options.components + 2 > result.taught) break;
    result.lle_sweep.push_back(outside + LleError(FitLocallyLinearEmbedding(scaled, options), scaled_out));
    if (result.lle_sweep.back() <= *std::min_element(result.lle_sweep.begin(), result.lle_sweep.end())) result.lle = options;
  }
  Curves& lle = result.curves[kLle];
  for (const int components : kLleComponents) {
    if (components + 2 > result.taught) break;
    LocallyLinearEmbeddingOptions options = result.lle;
    options.components = components;
    const LocallyLinearEmbedding embedding = FitLocallyLinearEmbedding(scaled, options);
    lle.taught.push_back(LleError(embedding, scaled));
    lle.left_out.push_back(outside + LleError(embedding, scaled_out));
  }
  result.neighbours_alone = outside;
  for (Eigen::Index i = 0; i < scaled_out.cols(); ++i) {
    const std::vector<int> nearest = NearestColumns(scaled, scaled_out.col(i), result.lle.neighbours);
    const Eigen::MatrixXd neighbours = scaled(Eigen::all, nearest);
    const Eigen::VectorXd made = neighbours * ReconstructionWeights(scaled_out.col(i), neighbours, result.lle.regularisation);
    result.neighbours_alone += (made - scaled_out.col(i)).squaredNorm() / static_cast<double>(scaled_out.cols());
  }
  return result;
}

// Value of a curve at k; one that ends before stays where it ended.
double At(const std::vector<double>& curve, size_t k) { return curve.empty() ? 0 : curve[std::min(k, curve.size() - 1)]; }

std::vector<double> Mean(const std::vector<ReductionResult>& results, ReductionMethod method, std::vector<double> Curves::*part, size_t length) {
  std::vector<double> mean(length, 0);
  for (size_t k = 0; k < length; ++k) {
    for (const ReductionResult& result : results) mean[k] += At(result.curves[method].*part, k) / static_cast<double>(results.size());
  }
  return mean;
}

ChartSeries SeriesFromZero(const std::string& name, const std::vector<double>& values, bool dashed) {
  ChartSeries series{.name = name, .x = {}, .y = {}};
  for (size_t k = 0; k < values.size(); ++k) {
    // With as many components as steps nothing is left but rounding, which a logarithm would make the most of.
    if (k > 0 && values[k] < 1e-6 * values[0]) break;
    series.x.push_back(static_cast<double>(k)), series.y.push_back(values[k]);
  }
  series.dashed = dashed;
  return series;
}

struct DataResult {
  std::vector<ReductionResult> classes;
  std::vector<std::string> names;
};

DataResult ReduceAll(const StudyContext& context, StudyData data) {
  const StudySteps steps = FindStudySteps(context, data);
  const Eigen::VectorXd scale = StepWeights(steps.set.channel_weights), depth = DepthWeights(steps.set.layout);
  struct Task {
    size_t group;
    std::vector<int> taught, left_out;
  };
  std::vector<Task> tasks;
  for (size_t c = 0; c < steps.classes.size(); ++c) {
    Task task{c, steps.Half(context, c, 0), steps.Half(context, c, 1)};
    if (std::min(task.taught.size(), task.left_out.size()) >= kFewestForReduction) tasks.push_back(std::move(task));
  }
  DataResult result;
  result.classes.resize(tasks.size());
  ParallelFor(context.options().jobs, static_cast<int>(tasks.size()), [&](int t) {
    const Eigen::MatrixXd& vectors = steps.aligned[tasks[t].group].vectors;
    result.classes[t] = ReductionsOfClass(vectors(Eigen::all, tasks[t].taught), vectors(Eigen::all, tasks[t].left_out), scale, depth,
                                   context.options().quick);
  });
  for (const Task& task : tasks) result.names.push_back(steps.Name(task.group));
  return result;
}

}  // namespace

StudySection StudyReduction(StudyContext& context) {
  StudySection section;
  section.id = "reduction";
  section.title = "Reduction: few numbers for a step";
  std::string measured;
  std::vector<Chart> charts;
  for (const StudyData data : {StudyData::kClean, StudyData::kNoisy}) {
    const std::string name = DataName(data);
    if (context.options().progress) context.options().progress("reduction, " + name, 0.5 * static_cast<int>(data));
    const DataResult result = ReduceAll(context, data);
    if (result.classes.empty()) {
      measured += "The " + name + " data hold no class with " + std::to_string(kFewestForReduction) + " steps in each half of the clips: nothing can be told.\n\n";
      continue;
    }
    size_t length = 0;
    for (const ReductionResult& of_class : result.classes) length = std::max(length, of_class.curves[kWeighted].taught.size());
    length = std::min<size_t>(length, 61);
    const double classes = static_cast<double>(result.classes.size());

    Chart error, kept, out;
    error.title = "Weighted squared error, " + name + ", steps taught";
    out.title = "Weighted squared error, " + name + ", steps left out";
    kept.title = "Variance kept, " + name;
    for (Chart* chart : {&error, &out}) {
      chart->x_label = "components", chart->y_label = "weighted squared error, m²", chart->better = "lower";
      chart->log_y = true, chart->y_from_zero = false;
    }
    error.caption = "Mean over steps and classes; a unit is the squared distance that joints are off, summed over the body (Du Fig. 4.12 a, 4.13 a).";
    out.caption = "The same for steps of clips that taught nothing: what a model can say of steps it has not seen.";
    kept.x_label = "components", kept.y_label = "part of the variance", kept.better = "higher";
    kept.caption = "Each method in its own weights, steps taught (Du Fig. 4.12 b, 4.13 b).";
    kept.marks = {{"99 %", 0.99}};
    ordered_json& json = section.data[name];
    json["classes"] = result.names;
    double for_99[kReductionMethods] = {};
    double at[kReductionMethods][2] = {};  // taught, left out, at kComparedAt
    for (const ReductionMethod method : {kWeighted, kByDepth, kPlain}) {
      const std::vector<double> taught = Mean(result.classes, method, &Curves::taught, length);
      const std::vector<double> left_out = Mean(result.classes, method, &Curves::left_out, length);
      const std::vector<double> kept_part = Mean(result.classes, method, &Curves::kept, length);
      for (const ReductionResult& of_class : result.classes) for_99[method] += of_class.curves[method].for_99 / classes;
      at[method][0] = At(taught, kComparedAt), at[method][1] = At(left_out, kComparedAt);
      error.series.push_back(SeriesFromZero(kReductionMethodNames[method], taught, method != kWeighted));
      out.series.push_back(SeriesFromZero(kReductionMethodNames[method], left_out, method != kWeighted));
      kept.series.push_back(SeriesFromZero(kReductionMethodNames[method], kept_part, method != kWeighted));
      json[kReductionMethodKeys[method]] = {{"error_taught_m2", taught}, {"error_left_out_m2", left_out}, {"variance_kept", kept_part}, {"components_for_99_percent", for_99[method]}};
    }
    size_t lle_count = kLleComponents.size();
    for (const ReductionResult& of_class : result.classes) lle_count = std::min(lle_count, of_class.curves[kLle].left_out.size());
    const std::vector<double> lle_taught = Mean(result.classes, kLle, &Curves::taught, lle_count);
    const std::vector<double> lle_out = Mean(result.classes, kLle, &Curves::left_out, lle_count);
    ChartSeries lle{.name = kReductionMethodNames[kLle], .x = {}, .y = {}, .form = ChartSeries::Form::kPoints};
    for (size_t i = 0; i < lle_count; ++i) lle.x.push_back(kLleComponents[i]);
    lle.y = lle_taught;
    error.series.push_back(lle);
    lle.y = lle_out;
    out.series.push_back(lle);
    double neighbours_alone = 0;
    for (const ReductionResult& of_class : result.classes) neighbours_alone += of_class.neighbours_alone / classes;
    const auto compared = std::find(kLleComponents.begin(), kLleComponents.begin() + static_cast<std::ptrdiff_t>(lle_count), kComparedAt);
    const size_t place = static_cast<size_t>(compared - kLleComponents.begin());
    const bool has_lle = place < lle_count;
    json[kReductionMethodKeys[kLle]] = {{"components", std::vector<int>(kLleComponents.begin(), kLleComponents.begin() + static_cast<std::ptrdiff_t>(lle_count))},
                         {"classes", nlohmann::ordered_json::array()},
                         {"error_taught_m2", lle_taught},
                         {"error_left_out_m2", lle_out},
                         {"error_left_out_neighbours_alone_m2", neighbours_alone}};
    for (size_t c = 0; c < result.classes.size(); ++c) {
      const LocallyLinearEmbeddingOptions& options = result.classes[c].lle;
      json[kReductionMethodKeys[kLle]]["classes"].push_back({{"neighbours", options.neighbours}, {"regularisation", options.regularisation}});
    }
    double best_lle = 0;
    std::string best_options;
    for (size_t s = 0; s < Sweep().size(); ++s) {
      double mean = 0;
      int counted = 0;
      for (const ReductionResult& of_class : result.classes) {
        if (s < of_class.lle_sweep.size()) mean += of_class.lle_sweep[s], ++counted;
      }
      if (counted == 0) continue;
      mean /= counted;
      json["lle_options"].push_back({{"neighbours", Sweep()[s].neighbours}, {"regularisation", Sweep()[s].regularisation}, {"components", kComparedAt},
                                     {"error_left_out_m2", mean}});
      if (best_options.empty() || mean < best_lle) {
        best_lle = mean;
        best_options = std::to_string(Sweep()[s].neighbours) + " neighbours and a regularisation of " + ShortNumber(Sweep()[s].regularisation);
      }
    }
    for (Chart* chart : {&error, &out, &kept}) charts.push_back(std::move(*chart));

    const std::string eight = std::to_string(kComparedAt);
    section.figures.push_back({.what = "weighted squared error with " + eight + " components, weighted / plain PCA, steps taught, " + name,
                               .value = at[kWeighted][0] / at[kPlain][0],
                               .source = data == StudyData::kClean ? "Du Fig. 4.13: near 1" : "Du Fig. 4.12: below 1",
                               .at_most = 1.0});
    section.figures.push_back({.what = "the same, steps left out, " + name, .value = at[kWeighted][1] / at[kPlain][1]});
    section.figures.push_back({.what = "components for 99 % of the variance, weighted / plain PCA, " + name,
                               .value = for_99[kPlain] > 0 ? std::optional(for_99[kWeighted] / for_99[kPlain]) : std::nullopt,
                               .source = data == StudyData::kClean ? "Du Fig. 4.13: near 1" : "Du Fig. 4.12: below 1",
                               .note = "weighted " + FixedNumber(for_99[kWeighted], 1) + ", plain " + FixedNumber(for_99[kPlain], 1) +
                                       ", on average over classes of half of the clips"});
    if (has_lle)
      section.figures.push_back({.what = "error of steps left out with " + eight + " coordinates, locally linear embedding / weighted PCA, " + name,
                                 .value = lle_out[place] / at[kWeighted][1],
                                 .source = "Xie 7: PCA ahead of LLE",
                                 .note = best_options.empty() ? std::to_string(kLleUsual.neighbours) + " neighbours, a regularisation of " + ShortNumber(kLleUsual.regularisation)
                                                              : "neighbours and regularisation are the best of " + std::to_string(Sweep().size()) + " for each class, chosen on these very steps"});
    measured += "On " + name + " data " + eight + " weighted components leave an error of " + FixedNumber(at[kWeighted][0], 4) + " m² on the steps taught and " +
                FixedNumber(at[kWeighted][1], 4) + " on those left out; plain ones " + FixedNumber(at[kPlain][0], 4) + " and " +
                FixedNumber(at[kPlain][1], 4) + "; ones weighted by depth as Du does " + FixedNumber(at[kByDepth][0], 4) + " and " +
                FixedNumber(at[kByDepth][1], 4) + ". 99 % of the variance takes " + FixedNumber(for_99[kWeighted], 1) + " weighted and " +
                FixedNumber(for_99[kPlain], 1) + " plain components.";
    if (has_lle) {
      measured += " As many coordinates of a locally linear embedding leave " + FixedNumber(lle_out[place], 4) + " on steps left out; as many of their nearest steps "
                  "alone, without any coordinates, " + FixedNumber(neighbours_alone, 4) + ".";
      if (!best_options.empty()) measured += " Neighbours and regularisation are each class's best, chosen on the steps left out; the same for all, " + best_options + " are best: " + FixedNumber(best_lle, 4) + ".";
    }
    measured += "\n\n";
  }
  for (Chart& chart : charts) section.drawings.emplace_back(std::move(chart));
  section.text =
      "The steps of each class, on one timeline, are learned from one half of the clips and judged on both halves. The error is a weighted "
      "sum of squares, the same for all methods: a rotation counts by how far it moves the joints below it. Weighted PCA minimises just "
      "that; plain PCA counts a radian of the wrist as much as one of the hips. PCA weighted by depth takes Du's weights.\n\n"
      "Locally linear embedding (Xie 5.1.3) makes each step of its neighbours, and finds coordinates that are made in the same way. A step "
      "that it has not seen gets the coordinates that its nearest steps give it, with the weights that best make the step of them; the way "
      "back is the same from the nearest coordinates. The more neighbours it takes, the nearer it comes to a linear map of all steps, as PCA is.\n\n" +
      measured;
  while (!section.text.empty() && section.text.back() == '\n') section.text.pop_back();
  return section;
}

}  // namespace morphograph
