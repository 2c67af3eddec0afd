#include "api/study/mixture_study.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "api/study/markup.h"
#include "api/study/study_steps.h"
#include "datasets/errors.h"
#include "datasets/parallel_for.h"
#include "primitives/gaussian_mixture.h"
#include "primitives/step_vector.h"
#include "primitives/weighted_pca.h"

namespace morphograph {
namespace {

using nlohmann::ordered_json;

constexpr std::array kForms = {CovarianceForm::kFull, CovarianceForm::kTied, CovarianceForm::kDiagonal};
enum Reduction { kWithWeights, kWithoutWeights };
constexpr std::array kReductionNames = {"weighted PCA", "plain PCA"};
constexpr int kFewestForMixture = 12;
// Noisy steps need over a hundred components for 99 % of their variance, most of it noise, and a full covariance of that size for each
// Gaussian: minutes of fitting to learn that one is best.
constexpr int kMostComponents = 40;

GaussianMixtureOptions FitOptions() {
  GaussianMixtureOptions options;
  options.restarts = 2;
  options.max_iterations = 60;
  return options;
}

// Figures per step, so that classes of any size can be averaged; [form][K - 1].
struct FormTable {
  std::array<std::vector<double>, kForms.size()> values;
};

struct MixtureResult {
  int steps = 0;
  FormTable bic[2];      // by reduction
  FormTable held_out;    // log likelihood, weighted reduction; both halves judged by the other
  bool has_held_out = false;
};

Eigen::MatrixXd Latents(const Eigen::MatrixXd& vectors, const Eigen::VectorXd& weights, WeightedPca* pca) {
  *pca = FitWeightedPca(vectors, weights, {.variance_kept = 0.99, .max_components = kMostComponents});
  return pca->ProjectAll(vectors);
}

// Fits of every form and K. Fewer components than asked for come back where there are too few steps; then the fit repeats the last one.
template <typename Judge>
FormTable FitAll(const Eigen::MatrixXd& latents, int most, std::uint64_t seed, const Judge& judge) {
  FormTable table;
  for (size_t f = 0; f < kForms.size(); ++f) {
    for (int k = 1; k <= most; ++k) {
      std::mt19937_64 rng(seed);
      table.values[f].push_back(judge(FitGaussianMixture(latents, k, kForms[f], FitOptions(), rng)));
    }
  }
  return table;
}

double HeldOut(const GaussianMixture& mixture, const Eigen::MatrixXd& latents) {
  double sum = 0;
  for (Eigen::Index i = 0; i < latents.cols(); ++i) sum += mixture.LogDensity(latents.col(i));
  return sum / static_cast<double>(latents.cols());
}

MixtureResult MixturesOfClass(const Eigen::MatrixXd& all, const Eigen::MatrixXd (&halves)[2], const Eigen::VectorXd& scale, int most, std::uint64_t seed) {
  MixtureResult result;
  result.steps = static_cast<int>(all.cols());
  const Eigen::VectorXd weights[2] = {scale.cwiseAbs2(), Eigen::VectorXd::Ones(scale.size())};
  WeightedPca pca;
  for (const Reduction reduction : {kWithWeights, kWithoutWeights}) {
    const Eigen::MatrixXd latents = Latents(all, weights[reduction], &pca);
    if (latents.rows() == 0) throw DatasetError("mixture", "the steps of a class are all alike");
    result.bic[reduction] =
        FitAll(latents, most, seed, [&](const GaussianMixtureFit& fit) { return fit.bic / static_cast<double>(latents.cols()); });
  }
  if (std::min(halves[0].cols(), halves[1].cols()) < kFewestForMixture) return result;
  result.has_held_out = true;
  for (int taught = 0; taught < 2; ++taught) {
    const Eigen::MatrixXd latents = Latents(halves[taught], weights[kWithWeights], &pca);
    const Eigen::MatrixXd judged = pca.ProjectAll(halves[1 - taught]);
    // Per dimension: the two halves keep their own numbers of components.
    const double dimensions = static_cast<double>(latents.rows());
    const FormTable table =
        FitAll(latents, most, seed, [&](const GaussianMixtureFit& fit) { return HeldOut(fit.mixture, judged) / dimensions; });
    for (size_t f = 0; f < kForms.size(); ++f) {
      result.held_out.values[f].resize(static_cast<size_t>(most), 0);
      for (size_t k = 0; k < table.values[f].size(); ++k) result.held_out.values[f][k] += table.values[f][k] / 2;
    }
  }
  return result;
}

// Mean over classes of one form; `of` picks the table.
template <typename Of>
std::vector<double> MeanOf(const std::vector<MixtureResult>& classes, size_t form, const Of& of) {
  std::vector<double> mean;
  int counted = 0;
  for (const MixtureResult& result : classes) {
    const FormTable* table = of(result);
    if (!table) continue;
    mean.resize(table->values[form].size(), 0);
    for (size_t k = 0; k < mean.size(); ++k) mean[k] += table->values[form][k];
    ++counted;
  }
  for (double& value : mean) value /= std::max(1, counted);
  return mean;
}

std::vector<double> Least(const std::vector<std::vector<double>>& curves) {
  std::vector<double> least = curves.front();
  for (const std::vector<double>& curve : curves) {
    for (size_t k = 0; k < least.size(); ++k) least[k] = std::min(least[k], curve[k]);
  }
  return least;
}

ChartSeries SeriesFromOne(const std::string& name, const std::vector<double>& values, bool dashed) {
  ChartSeries series{.name = name, .x = {}, .y = values};
  for (size_t k = 0; k < values.size(); ++k) series.x.push_back(static_cast<double>(k + 1));
  series.dashed = dashed;
  return series;
}

// Density of the mixture's first two coordinates.
double PlaneDensity(const GaussianMixture& mixture, const Eigen::Vector2d& point) {
  double density = 0;
  for (const MixtureComponent& component : mixture.components()) {
    const Eigen::MatrixXd rows = component.cholesky.topRows(2);
    const Eigen::Matrix2d covariance = rows * rows.transpose();
    const Eigen::Vector2d apart = point - component.mean.head<2>();
    const double determinant = covariance.determinant();
    density += std::exp(component.log_weight - 0.5 * apart.dot(covariance.inverse() * apart)) / (2 * std::numbers::pi * std::sqrt(determinant));
  }
  return density;
}

// Fig. 3.10: the steps of a class in their first two components, and what the mixture says of them.
std::optional<HeatMap> DrawDensity(const Eigen::MatrixXd& vectors, const Eigen::VectorXd& scale, int most, std::uint64_t seed, const std::string& which) {
  WeightedPca pca;
  const Eigen::MatrixXd latents = Latents(vectors, scale.cwiseAbs2(), &pca);
  if (latents.rows() < 2) return std::nullopt;
  GaussianMixtureOptions options = FitOptions();
  options.max_components = most;
  std::mt19937_64 rng(seed);
  const GaussianMixtureFit fit = SelectGaussianMixture(latents, options, rng).best;
  constexpr int kCells = 60;
  HeatMap map;
  map.title = "Steps in their first two components, and the mixture behind";
  map.x_label = "first component, m", map.y_label = "second component, m", map.value_label = "density, 1/m²";
  map.caption = which + ": each point is a captured step, the colour how likely the mixture takes it to be (" + std::to_string(fit.mixture.size()) +
                (fit.mixture.size() == 1 ? " Gaussian, " : " Gaussians, ") + std::string(CovarianceFormName(fit.form)) +
                " covariance, as the criterion chooses; Du Fig. 3.10).";
  const Eigen::VectorXd low = latents.topRows(2).rowwise().minCoeff(), high = latents.topRows(2).rowwise().maxCoeff();
  const Eigen::VectorXd margin = 0.15 * (high - low);
  map.x_from = low[0] - margin[0], map.x_to = high[0] + margin[0];
  map.y_from = low[1] - margin[1], map.y_to = high[1] + margin[1];
  map.values.resize(kCells, kCells);
  for (int r = 0; r < kCells; ++r) {
    for (int c = 0; c < kCells; ++c) {
      const Eigen::Vector2d point(map.x_from + (c + 0.5) * (map.x_to - map.x_from) / kCells, map.y_from + (r + 0.5) * (map.y_to - map.y_from) / kCells);
      map.values(r, c) = PlaneDensity(fit.mixture, point);
    }
  }
  ChartSeries points{.name = "captured steps", .x = {}, .y = {}, .form = ChartSeries::Form::kPoints};
  for (Eigen::Index i = 0; i < latents.cols(); ++i) points.x.push_back(latents(0, i)), points.y.push_back(latents(1, i));
  map.over.push_back(points);
  return map;
}

}  // namespace

StudySection StudyMixture(StudyContext& context) {
  StudySection section;
  section.id = "mixture";
  section.title = "Mixture: how steps are spread";
  const StudyOptions& options = context.options();
  const int most = options.quick ? 3 : 6;
  Chart bic, forms, held_out;
  bic.title = "Information criterion against the number of Gaussians";
  bic.x_label = "Gaussians", bic.y_label = "BIC per step, less that of one Gaussian", bic.better = "lower", bic.y_from_zero = false;
  bic.caption = "Least of the three covariance forms, mean over classes (Du Fig. 4.14). Densities of weighted and of plain components have other "
                "units, so each curve starts from its own single Gaussian.";
  forms.title = "Covariance forms by the criterion";
  forms.x_label = "Gaussians", forms.y_label = "BIC per step, weighted PCA", forms.better = "lower", forms.y_from_zero = false;
  forms.caption = "Full: each Gaussian its own; tied: all the same; diagonal: components on their own.";
  held_out.title = "Covariance forms by steps left out";
  held_out.x_label = "Gaussians", held_out.y_label = "log likelihood per step and component", held_out.better = "higher", held_out.y_from_zero = false;
  held_out.caption = "Learned from one half of the clips and judged on the other, both ways: what the criterion stands in for.";
  std::string measured;
  std::vector<HeatMap> maps;
  for (const StudyData data : {StudyData::kClean, StudyData::kNoisy}) {
    const std::string name = DataName(data);
    if (options.progress) options.progress("mixture, " + name, 0.5 * static_cast<int>(data));
    const StudySteps steps = FindStudySteps(context, data);
    const Eigen::VectorXd scale = StepWeights(steps.set.channel_weights);
    std::vector<size_t> groups;
    for (size_t c = 0; c < steps.classes.size(); ++c) {
      if (steps.aligned[c].steady.size() >= kFewestForMixture) groups.push_back(c);
    }
    if (groups.empty()) {
      measured += "The " + name + " data hold no class with " + std::to_string(kFewestForMixture) + " steps: nothing can be told.\n\n";
      continue;
    }
    std::vector<MixtureResult> classes(groups.size());
    ParallelFor(options.jobs, static_cast<int>(groups.size()), [&](int g) {
      const size_t c = groups[g];
      const Eigen::MatrixXd& vectors = steps.aligned[c].vectors;
      const Eigen::MatrixXd halves[2] = {vectors(Eigen::all, steps.Half(context, c, 0)), vectors(Eigen::all, steps.Half(context, c, 1))};
      classes[g] = MixturesOfClass(vectors(Eigen::all, steps.aligned[c].steady), halves, scale, most, options.seed);
    });

    ordered_json& json = section.data[name];
    for (const size_t c : groups) json["classes"].push_back({{"class", steps.Name(c)}, {"steps", steps.aligned[c].steady.size()}});
    std::string chosen;
    for (const Reduction reduction : {kWithWeights, kWithoutWeights}) {
      std::vector<std::vector<double>> by_form;
      for (size_t f = 0; f < kForms.size(); ++f) {
        by_form.push_back(MeanOf(classes, f, [&](const MixtureResult& result) { return &result.bic[reduction]; }));
        json[reduction == kWithWeights ? "bic_per_step_weighted" : "bic_per_step_plain"][std::string(CovarianceFormName(kForms[f]))] = by_form.back();
        if (reduction == kWithWeights) forms.series.push_back(SeriesFromOne(std::string(CovarianceFormName(kForms[f])) + ", " + name, by_form.back(), data == StudyData::kNoisy));
      }
      std::vector<double> least = Least(by_form);
      const double first = least.front();
      for (double& value : least) value -= first;
      bic.series.push_back(SeriesFromOne(std::string(kReductionNames[reduction]) + ", " + name, least, reduction == kWithoutWeights));
      const auto best = static_cast<int>(std::min_element(least.begin(), least.end()) - least.begin()) + 1;
      section.figures.push_back({.what = "Gaussians of the least BIC, " + std::string(kReductionNames[reduction]) + ", " + name,
                                 .value = best,
                                 .source = "Du Fig. 4.14",
                                 .note = "of 1 to " + std::to_string(most) + ", mean over classes"});
      chosen += (chosen.empty() ? "" : " and ") + std::to_string(best) + " after " + kReductionNames[reduction];
    }
    size_t best_form = 0, best_k = 0, worst_form = 0;
    double best = -1e300, worst = 1e300;
    bool any = false;
    for (size_t f = 0; f < kForms.size(); ++f) {
      const std::vector<double> mean =
          MeanOf(classes, f, [](const MixtureResult& result) { return result.has_held_out ? &result.held_out : nullptr; });
      json["held_out_log_likelihood_per_step_and_component"][std::string(CovarianceFormName(kForms[f]))] = mean;
      if (mean.empty()) continue;
      any = true;
      held_out.series.push_back(SeriesFromOne(std::string(CovarianceFormName(kForms[f])) + ", " + name, mean, data == StudyData::kNoisy));
      const auto top = std::max_element(mean.begin(), mean.end());
      if (*top > best) best = *top, best_form = f, best_k = static_cast<size_t>(top - mean.begin()) + 1;
      if (*top < worst) worst = *top, worst_form = f;
    }
    measured += "On " + name + " data the criterion is least for " + chosen + " (Gaussians, mean over " + std::to_string(groups.size()) + " classes). ";
    if (any) {
      measured += "Steps left out are likeliest under " + std::to_string(best_k) + (best_k == 1 ? " Gaussian" : " Gaussians") + " with " +
                  std::string(CovarianceFormName(kForms[best_form])) + " covariance: " + FixedNumber(best) + " per step and component, against " + FixedNumber(worst) +
                  " at best with " + std::string(CovarianceFormName(kForms[worst_form])) + " covariance.";
      section.figures.push_back({.what = "Gaussians of the greatest likelihood of steps left out, " + name,
                                 .value = static_cast<double>(best_k),
                                 .note = std::string(CovarianceFormName(kForms[best_form])) + " covariance"});
    } else {
      measured += "No class has " + std::to_string(kFewestForMixture) + " steps in both halves, so nothing is said of steps left out.";
    }
    measured += "\n\n";
    const size_t drawn = groups.front();
    if (std::optional<HeatMap> map = DrawDensity(steps.aligned[drawn].vectors(Eigen::all, steps.aligned[drawn].steady), scale, most, options.seed,
                                                 steps.Name(drawn) + ", " + name))
      maps.push_back(std::move(*map));
  }
  section.drawings.emplace_back(bic);
  section.drawings.emplace_back(forms);
  if (!held_out.series.empty()) section.drawings.emplace_back(held_out);
  for (HeatMap& map : maps) section.drawings.emplace_back(std::move(map));
  section.text =
      "The steps of a class, reduced to the components that keep 99 % of their variance, or to the leading 40, are described by a mixture of Gaussians (Du 3.4). "
      "The Bayesian information criterion, -2 ln L + d ln N, weighs how likely the steps are against the number d of parameters; less is "
      "better. The likelihood of steps from clips left out asks the same without a rule of thumb. Models take at least one component for 35 captured steps, "
      "four at most: with fewer, drawn steps are told from captured ones more easily.\n\n" +
      measured;
  while (!section.text.empty() && section.text.back() == '\n') section.text.pop_back();
  return section;
}

}  // namespace morphograph
