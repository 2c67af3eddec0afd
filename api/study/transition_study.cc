#include "api/study/transition_study.h"

#include <algorithm>
#include <array>
#include <boost/random/uniform_int_distribution.hpp>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <set>

#include "api/study/study_steps.h"
#include "datasets/errors.h"
#include "datasets/parallel_for.h"
#include "graph/gaussian_process.h"
#include "graph/primitive_fit.h"
#include "graph/ridge_regression.h"
#include "graph/step_pairs.h"
#include "graph/transition_fit.h"
#include "primitives/whitening.h"

namespace morphograph {
namespace {

enum TransitionMethod { kInUse, kRbf, kRidge, kNone, kTransitionMethods };
const std::array<std::string, kTransitionMethods> kTransitionMethodNames = {"Gaussian process in use (linear + RBF)", "RBF process alone (Du 3.5)", "ridge regression",
                                                  "no transition (mixture alone)"};
const std::array<std::string, kTransitionMethods> kTransitionMethodKeys = {"in_use", "rbf", "ridge", "none"};

// Pairs of an edge in whitened space, where the mixture alone says N(0, I).
struct WhitenedPairs {
  Eigen::MatrixXd previous, next;
};

// A prediction held against what followed, value by value.
struct Judged {
  Eigen::VectorXd mean, truth, sd;
  double log_likelihood = 0;
};

// All held-out pairs of an edge, in the order of the pairs.
struct JudgedEdge {
  std::string style, from, to;
  int pairs = 0, clips = 0;
  std::array<std::vector<Judged>, kTransitionMethods> judged;
};

Eigen::MatrixXd WhitenColumns(const Eigen::MatrixXd& latents, const GaussianMixture& mixture) {
  Eigen::MatrixXd whitened(latents.rows(), latents.cols());
  for (Eigen::Index i = 0; i < latents.cols(); ++i)
    whitened.col(i) = Whiten(mixture.Component(mixture.MostLikely(latents.col(i))), latents.col(i));
  return whitened;
}

Judged JudgeIsotropic(const Eigen::VectorXd& mean, double variance, const Eigen::VectorXd& truth) {
  const double dims = static_cast<double>(truth.size());
  const double log_likelihood =
      -0.5 * ((truth - mean).squaredNorm() / variance + dims * std::log(2 * std::numbers::pi * variance));
  return {mean, truth, Eigen::VectorXd::Constant(truth.size(), std::sqrt(variance)), log_likelihood};
}

Judged JudgeInUse(const TransitionModel& model, const Eigen::VectorXd& offset, const Eigen::VectorXd& whitened, const Eigen::VectorXd& truth) {
  const auto noise = model.noise_cholesky.triangularView<Eigen::Lower>();
  Judged judged{model.Mean(whitened) + offset, truth, model.noise_cholesky.rowwise().norm(), 0};
  const Eigen::VectorXd standard = noise.solve(truth - judged.mean);
  judged.log_likelihood = -0.5 * (standard.squaredNorm() + static_cast<double>(truth.size()) * std::log(2 * std::numbers::pi)) -
                          model.noise_cholesky.diagonal().array().log().sum();
  return judged;
}

// Learns from all pairs but those of the fold, and judges these.
void JudgeFold(const TransitionPairs& latents, const WhitenedPairs& pairs, const MotionPrimitive& from, const MotionPrimitive& to,
               const SharedMargin& margin, const std::vector<Eigen::Index>& left_out, JudgedEdge* edge) {
  std::vector<Eigen::Index> used;
  for (Eigen::Index i = 0; i < pairs.next.cols(); ++i)
    if (!std::binary_search(left_out.begin(), left_out.end(), i)) used.push_back(i);
  TransitionPairs training{latents.previous(Eigen::all, used), latents.next(Eigen::all, used), {}, {}};
  for (const Eigen::Index i : used) {
    training.clip.push_back(latents.clip[static_cast<size_t>(i)]);
    training.made.push_back(latents.made[static_cast<size_t>(i)]);
  }
  const Eigen::MatrixXd inputs = pairs.previous(Eigen::all, used), outputs = pairs.next(Eigen::all, used);
  TransitionFitOptions options;
  options.keep_marginal = IsWalking(from.start) || !IsWalking(to.end);  // as graph_builder.cc does
  options.margin = margin;
  const TransitionModel in_use = FitTransition(training, from.mixture, to.mixture, options);
  const Eigen::VectorXd offset = in_use.residuals.cast<double>().rowwise().mean();
  const GaussianProcess rbf = GaussianProcess::Fit(inputs, outputs);
  const RidgeRegression ridge = FitRidge(inputs, outputs, training.clip);
  for (const Eigen::Index i : left_out) {
    const Eigen::VectorXd input = pairs.previous.col(i), truth = pairs.next.col(i);
    const size_t place = static_cast<size_t>(i);
    edge->judged[kInUse][place] = JudgeInUse(in_use, offset, input, truth);
    const GaussianPrediction predicted = rbf.Predict(input);
    edge->judged[kRbf][place] = JudgeIsotropic(predicted.mean, predicted.variance + rbf.kernel().noise_variance, truth);
    edge->judged[kRidge][place] = JudgeIsotropic(ridge.Mean(input), ridge.noise_variance, truth);
    edge->judged[kNone][place] = JudgeIsotropic(Eigen::VectorXd::Zero(truth.size()), 1, truth);
  }
}

// Pairs of whole clips in `count` folds, drawn by the generator; each list ascending.
std::vector<std::vector<Eigen::Index>> FoldsByClip(const std::vector<int>& clip_of_pair, int count, std::mt19937_64& rng) {
  const std::set<int> distinct(clip_of_pair.begin(), clip_of_pair.end());
  std::vector<int> clips(distinct.begin(), distinct.end());
  for (size_t i = clips.size(); i > 1; --i)
    std::swap(clips[i - 1], clips[boost::random::uniform_int_distribution<size_t>(0, i - 1)(rng)]);
  std::vector<std::vector<Eigen::Index>> folds(static_cast<size_t>(count));
  for (size_t i = 0; i < clip_of_pair.size(); ++i) {
    const auto place = std::find(clips.begin(), clips.end(), clip_of_pair[i]) - clips.begin();
    folds[static_cast<size_t>(place % count)].push_back(static_cast<Eigen::Index>(i));
  }
  return folds;
}

std::vector<JudgedEdge> JudgeEdges(const StudyContext& context, StudyData data) {
  const StudyOptions& options = context.options();
  const int folds = options.quick ? 2 : 5, fewest_pairs = options.quick ? 8 : 20;
  constexpr size_t kQuickEdges = 4;
  const TrainingSet set = StudyTrainingSet(context, data);

  std::vector<StepPairs> pairs = FindStepPairs(set);
  std::erase_if(pairs, [&](const StepPairs& list) {
    return list.size() < fewest_pairs || static_cast<int>(std::set<int>(list.source.begin(), list.source.end()).size()) < folds;
  });
  if (options.quick && pairs.size() > kQuickEdges) pairs.resize(kQuickEdges);
  std::set<int> needed;
  for (const StepPairs& list : pairs) needed.insert({list.from, list.to});
  const std::vector<int> classes(needed.begin(), needed.end());
  std::vector<FittedPrimitive> fitted(set.classes.size());
  ParallelFor(options.jobs, static_cast<int>(classes.size()), [&](int i) {
    const StepClass& members = set.classes[classes[i]];
    fitted[classes[i]] = FitPrimitive(set.clips, set.steps, members, set.layout, StyleOf(set, members).mean_rotations, set.channel_weights, {});
  });

  struct Fold {
    int edge;
    std::vector<Eigen::Index> left_out;
  };
  std::vector<JudgedEdge> edges(pairs.size());
  std::vector<TransitionPairs> latents;
  std::vector<WhitenedPairs> whitened;
  std::vector<SharedMargin> margins;
  std::vector<Fold> work;
  std::mt19937_64 rng(options.seed);
  for (size_t e = 0; e < pairs.size(); ++e) {
    const FittedPrimitive &from = fitted[pairs[e].from], &to = fitted[pairs[e].to];
    latents.push_back(LatentsOf(pairs[e], from.latents, to.latents));
    whitened.push_back({WhitenColumns(latents[e].previous, from.primitive.mixture), WhitenColumns(latents[e].next, to.primitive.mixture)});
    const StepClass& named = set.classes[pairs[e].from];
    margins.push_back(FindSharedMargin(from.primitive, to.primitive, set.layout, StyleOf(set, named).mean_rotations, set.channel_weights));
    edges[e].style = named.style, edges[e].from = named.primitive, edges[e].to = set.classes[pairs[e].to].primitive;
    edges[e].pairs = pairs[e].size();
    edges[e].clips = static_cast<int>(std::set<int>(pairs[e].source.begin(), pairs[e].source.end()).size());
    for (std::vector<Judged>& judged : edges[e].judged) judged.resize(static_cast<size_t>(pairs[e].size()));
    for (std::vector<Eigen::Index>& fold : FoldsByClip(pairs[e].source, folds, rng)) work.push_back({static_cast<int>(e), std::move(fold)});
  }
  ParallelFor(options.jobs, static_cast<int>(work.size()), [&](int i) {
    const size_t e = static_cast<size_t>(work[i].edge);
    JudgeFold(latents[e], whitened[e], fitted[pairs[e].from].primitive, fitted[pairs[e].to].primitive, margins[e], work[i].left_out, &edges[e]);
  });
  return edges;
}

// What a method comes to over all held-out pairs.
struct Verdict {
  double log_likelihood = 0;  // mean of a pair, nats
  double error = 0;           // squared, to that of the mixture's mean
  double standardised = 0;    // mean square of (truth - mean) / sd: 1 where the variance is right
  std::vector<double> inside; // observed part in the central interval of each nominal part kNominal
  std::vector<double> pit;    // histogram of the cumulative probability of the truth, densities
};

constexpr int kPitBins = 20;
std::vector<double> NominalParts() {
  std::vector<double> parts;
  for (int i = 1; i < 20; ++i) parts.push_back(0.05 * i);
  return parts;
}

Verdict VerdictOn(const std::vector<JudgedEdge>& edges, TransitionMethod method) {
  Verdict verdict;
  const std::vector<double> nominal = NominalParts();
  verdict.inside.assign(nominal.size(), 0);
  verdict.pit.assign(kPitBins, 0);
  double pairs = 0, values = 0, squares = 0, of_mean = 0;
  for (const JudgedEdge& edge : edges) {
    for (const Judged& judged : edge.judged[method]) {
      ++pairs;
      verdict.log_likelihood += judged.log_likelihood;
      of_mean += judged.truth.squaredNorm();
      for (Eigen::Index d = 0; d < judged.truth.size(); ++d) {
        const double miss = judged.truth[d] - judged.mean[d], z = miss / judged.sd[d];
        ++values;
        squares += miss * miss;
        verdict.standardised += z * z;
        const double central = std::erf(std::abs(z) / std::numbers::sqrt2);  // the least central interval that holds it
        for (size_t i = 0; i < nominal.size(); ++i) verdict.inside[i] += central <= nominal[i];
        const double cumulative = 0.5 * std::erfc(-z / std::numbers::sqrt2);
        ++verdict.pit[static_cast<size_t>(std::min(kPitBins - 1, static_cast<int>(kPitBins * cumulative)))];
      }
    }
  }
  verdict.log_likelihood /= pairs;
  verdict.error = squares / of_mean;
  verdict.standardised /= values;
  for (double& part : verdict.inside) part /= values;
  for (double& part : verdict.pit) part *= kPitBins / values;
  return verdict;
}

using Verdicts = std::array<Verdict, kTransitionMethods>;
Verdicts AllVerdicts(const std::vector<JudgedEdge>& edges) {
  Verdicts verdicts;
  for (int m = 0; m < kTransitionMethods; ++m) verdicts[static_cast<size_t>(m)] = VerdictOn(edges, static_cast<TransitionMethod>(m));
  return verdicts;
}

Chart ByMethod(const std::vector<std::pair<std::string, Verdicts>>& verdicts, const std::vector<TransitionMethod>& methods,
               double (*value)(const Verdicts&, TransitionMethod)) {
  Chart chart;
  chart.x_label = "learned from and judged on";
  for (const auto& [name, of_data] : verdicts) chart.x_names.push_back(name);
  for (const TransitionMethod method : methods) {
    ChartSeries bars{kTransitionMethodNames[method], {}, {}, ChartSeries::Form::kBars};
    for (size_t i = 0; i < verdicts.size(); ++i) {
      bars.x.push_back(static_cast<double>(i));
      bars.y.push_back(value(verdicts[i].second, method));
    }
    chart.series.push_back(std::move(bars));
  }
  return chart;
}

Chart CalibrationChart(const Verdicts& verdicts) {
  Chart chart;
  chart.title = "Calibration of the predicted variance, clean clips";
  chart.x_label = "part of next steps that should lie inside the interval, %";
  chart.y_label = "part that does, less the part that should, percentage points";
  chart.caption = "Central intervals of every size around the predicted mean, over all components of all held-out pairs. At 0 the variance is right; "
                  "above, it is too large; below, too small.";
  std::vector<double> parts = NominalParts();
  for (size_t m = 0; m < kTransitionMethods; ++m) {
    ChartSeries line{kTransitionMethodNames[m], {}, {}};
    for (size_t i = 0; i < parts.size(); ++i) {
      line.x.push_back(100 * parts[i]);
      line.y.push_back(100 * (verdicts[m].inside[i] - parts[i]));
    }
    chart.series.push_back(std::move(line));
  }
  chart.marks.push_back({"as it should be", 0});
  return chart;
}

Chart PitChart(const Verdicts& verdicts) {
  Chart chart;
  chart.title = "Where the next step falls in its predicted distribution, clean clips";
  chart.x_label = "cumulative probability of what was captured";
  chart.y_label = "density";
  chart.caption = "Flat at 1 where predictions are right as a whole. A hill in the middle: the variance is too large, or the tails are "
                  "heavier than a Gaussian's; hills at the ends: it is too small.";
  for (const TransitionMethod method : {kInUse, kRbf}) {
    ChartSeries line{kTransitionMethodNames[method], {}, verdicts[method].pit};
    for (int i = 0; i < kPitBins; ++i) line.x.push_back((i + 0.5) / kPitBins);
    chart.series.push_back(std::move(line));
  }
  chart.marks.push_back({"as it should be", 1});
  return chart;
}

// Truth against prediction of the component that is told best, on the edge with the most pairs.
Chart PredictionChart(const std::vector<JudgedEdge>& edges) {
  const JudgedEdge& edge = *std::max_element(edges.begin(), edges.end(), [](const auto& a, const auto& b) { return a.pairs < b.pairs; });
  const std::vector<Judged>& judged = edge.judged[kInUse];
  Eigen::Index best = 0;
  double least = 0;
  for (Eigen::Index d = 0; d < judged.front().truth.size(); ++d) {
    double squares = 0, of_mean = 0;
    for (const Judged& one : judged) {
      squares += std::pow(one.truth[d] - one.mean[d], 2);
      of_mean += std::pow(one.truth[d], 2);
    }
    if (d == 0 || squares / of_mean < least) best = d, least = squares / of_mean;
  }
  std::vector<size_t> order(judged.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return judged[a].mean[best] < judged[b].mean[best]; });
  Chart chart;
  chart.title = "One component of the next step: predicted and captured";
  chart.x_label = "held-out pairs, by what is predicted";
  chart.y_label = "whitened component " + std::to_string(best + 1) + ", standard deviations";
  chart.caption = "From " + edge.from + " to " + edge.to + (edge.style.empty() ? "" : " (" + edge.style + ")") +
                  ", the component that the step before tells most of. Band: mean ± one predicted standard deviation, which should hold two "
                  "thirds of the points.";
  ChartSeries band{"predicted, ± 1 sd", {}, {}, ChartSeries::Form::kBand}, line{"predicted, ± 1 sd", {}, {}}, points{"captured", {}, {}, ChartSeries::Form::kPoints};
  for (size_t i = 0; i < order.size(); ++i) {
    const Judged& one = judged[order[i]];
    const double x = static_cast<double>(i + 1), mean = one.mean[best], sd = one.sd[best];
    for (ChartSeries* series : {&band, &line, &points}) series->x.push_back(x);
    band.y.push_back(mean + sd);
    band.y_low.push_back(mean - sd);
    line.y.push_back(mean);
    points.y.push_back(one.truth[best]);
  }
  chart.series = {band, line, points};
  return chart;
}

nlohmann::ordered_json VerdictJson(const Verdict& verdict) {
  return {{"log_likelihood", verdict.log_likelihood}, {"relative_error", verdict.error}, {"standardised_variance", verdict.standardised},
          {"inside_50", verdict.inside[9]},           {"inside_80", verdict.inside[15]}, {"inside_95", verdict.inside[18]},
          {"inside", verdict.inside},                 {"pit", verdict.pit}};
}

nlohmann::ordered_json DataJson(const std::vector<JudgedEdge>& edges, const Verdicts& verdicts) {
  nlohmann::ordered_json json = {{"edges", nlohmann::ordered_json::array()}};
  for (const JudgedEdge& edge : edges) {
    nlohmann::ordered_json of_edge = {{"style", edge.style}, {"from", edge.from}, {"to", edge.to}, {"pairs", edge.pairs}, {"clips", edge.clips},
                                      {"components", edge.judged[kInUse].front().truth.size()}};
    for (int m = 0; m < kTransitionMethods; ++m) {
      const Verdict verdict = VerdictOn({edge}, static_cast<TransitionMethod>(m));
      of_edge[kTransitionMethodKeys[static_cast<size_t>(m)]] = {{"log_likelihood", verdict.log_likelihood}, {"relative_error", verdict.error}};
    }
    json["edges"].push_back(std::move(of_edge));
  }
  for (size_t m = 0; m < kTransitionMethods; ++m) json[kTransitionMethodKeys[m]] = VerdictJson(verdicts[m]);
  return json;
}

}  // namespace

StudySection StudyTransitions(StudyContext& context) {
  StudySection section;
  section.id = "transitions";
  section.title = "Transitions: what one step tells of the next";
  const StudyOptions& options = context.options();
  if (options.progress) options.progress(section.title, 0);
  const std::vector<JudgedEdge> clean = JudgeEdges(context, StudyData::kClean);
  if (clean.empty()) throw DatasetError("transitions", "no kind of step is followed by another often enough, in enough clips");
  if (options.progress) options.progress(section.title, 0.5);
  std::vector<JudgedEdge> noisy;
  std::string no_noisy;
  try {
    noisy = JudgeEdges(context, StudyData::kNoisy);
    if (noisy.empty()) no_noisy = "too few steps follow each other in them";
  } catch (const DatasetError& unfit) {
    no_noisy = unfit.what();
  }
  std::vector<std::pair<std::string, Verdicts>> verdicts = {{"clean clips", AllVerdicts(clean)}};
  if (!noisy.empty()) verdicts.emplace_back("noisy clips", AllVerdicts(noisy));
  const Verdicts& of_clean = verdicts.front().second;

  int pairs = 0;
  for (const JudgedEdge& edge : clean) pairs += edge.pairs;
  section.text =
      std::to_string(pairs) + " pairs of steps that follow each other in the capture, of " + std::to_string(clean.size()) +
      (clean.size() == 1 ? " transition" : " transitions") + ", judged in " + std::to_string(options.quick ? 2 : 5) +
      " folds: each fold leaves whole clips out, learns the transition from the others, and predicts every next step of the clips left out.\n\n"
      "All methods are judged in one space: the components of the next step, whitened by the mixture's own covariance, so that the mixture alone "
      "says mean 0 and variance 1 and likelihoods compare. Reduction and mixture were learned from all clips; this favours \"no transition\", "
      "which has seen the clips that it is judged on. The noise of ridge regression is one number, found on clips left out; the RBF process "
      "predicts its own variance; the process in use carries the covariance that keeps the captured spread over long walks.";
  if (!no_noisy.empty()) section.text += "\n\nNoisy clips are left out: " + no_noisy + ".";

  Chart error = ByMethod(verdicts, {kInUse, kRbf, kRidge, kNone}, [](const Verdicts& v, TransitionMethod m) { return v[m].error; });
  error.title = "Error of the predicted next step";
  error.y_label = "mean squared error, 1 = that of the mixture's mean";
  error.better = "lower";
  error.caption = "Part of the spread of the next step that the step before does not tell, on clips left out.";
  Chart gain = ByMethod(verdicts, {kInUse, kRbf, kRidge},
                        [](const Verdicts& v, TransitionMethod m) { return v[m].log_likelihood - v[kNone].log_likelihood; });
  gain.title = "Likelihood gained by the transition";
  gain.y_label = "log likelihood of a held-out pair over the mixture's, nats";
  gain.better = "higher";
  gain.caption = "Below 0, a transition is worse than drawing each step by itself.";
  section.drawings = {error, gain, CalibrationChart(of_clean), PitChart(of_clean), PredictionChart(clean)};

  section.data = {{"methods", kTransitionMethodNames}, {"folds", options.quick ? 2 : 5}, {"nominal", NominalParts()}, {"clean", DataJson(clean, of_clean)}};
  section.data["noisy"] = noisy.empty() ? nlohmann::ordered_json(nullptr) : DataJson(noisy, verdicts.back().second);

  for (const auto& [name, of_data] : verdicts) {
    const std::string what = ", " + name;
    StudyFigure told{"error of the predicted next step, to that of the mixture's mean" + what, of_data[kInUse].error, ""};
    told.at_most = 1;
    told.note = "ridge regression " + std::to_string(of_data[kRidge].error).substr(0, 5) + ", RBF process alone " +
                std::to_string(of_data[kRbf].error).substr(0, 5) + "; Du gives no figure";
    section.figures.push_back(told);
    StudyFigure likelihood{"log likelihood of a next step, transition in use over mixture alone" + what,
                           of_data[kInUse].log_likelihood - of_data[kNone].log_likelihood, "nats"};
    likelihood.at_least = 0;
    section.figures.push_back(likelihood);
    StudyFigure inside{"next steps inside the predicted 95 % interval" + what, of_data[kInUse].inside[18], ""};
    inside.at_least = 0.92;
    inside.at_most = 0.98;
    section.figures.push_back(inside);
  }
  return section;
}

}  // namespace morphograph
