// Do long walks keep to what was captured? METHODS section 3, "Hold the captured marginal".

#include <algorithm>
#include <cmath>
#include <random>

#include "api/study/sample_sets.h"
#include "api/study/sample_study.h"
#include "datasets/parallel_for.h"
#include "synthesis/unsatisfiable_request.h"
#include "synthesis/walk_sampler.h"

namespace morphograph {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kSteps = 200;
constexpr int kLeftOut = 20;           // steps at the beginning, which come from the captured marginal anyway
constexpr double kLeadingPart = 0.9;   // of the captured variance, in the leading components
constexpr int kFewestLeading = 3;

// Sums over the latents of one primitive's steps.
struct Sums {
  Eigen::VectorXd values, squares;
  int count = 0;
};

// Mean and variance of every component over the captured steps, as the primitive's mixture has them.
struct Moments {
  Eigen::VectorXd mean, variance;
};

Moments CapturedMoments(const GaussianMixture& mixture) {
  Moments moments{Eigen::VectorXd::Zero(mixture.dimension()), Eigen::VectorXd::Zero(mixture.dimension())};
  for (const MixtureComponent& component : mixture.components()) {
    const double weight = std::exp(component.log_weight);
    moments.mean += weight * component.mean;
    moments.variance += weight * (component.cholesky.rowwise().squaredNorm() + component.mean.cwiseAbs2());
  }
  moments.variance -= moments.mean.cwiseAbs2();
  return moments;
}

// By primitive. Empty where the style cannot walk on for so long.
std::vector<Sums> WalkOn(const MotionGraph& graph, int style, int walks, std::uint64_t seed) {
  std::vector<Sums> sums(static_cast<size_t>(graph.primitive_count()));
  for (int walk = 0; walk < walks; ++walk) {
    std::mt19937_64 rng(seed + static_cast<std::uint64_t>(walk));
    DrawnWalk drawn;
    try {
      drawn = DrawWalk(graph, {.style = style, .steps = kSteps, .frame_rate_hz = graph.frame_rate_hz()}, rng);
    } catch (const UnsatisfiableRequest&) {
      return {};
    }
    for (size_t i = kLeftOut; i < drawn.steps.size(); ++i) {
      const WalkStep& step = drawn.steps[i].step;
      Sums& of = sums[static_cast<size_t>(step.primitive)];
      if (of.count++ == 0) of.values = of.squares = Eigen::VectorXd::Zero(step.latent.size());
      of.values += step.latent;
      of.squares += step.latent.cwiseAbs2();
    }
  }
  return sums;
}

int LeadingComponents(const Eigen::VectorXd& variance) {
  int leading = 0;
  double sum = 0;
  while (leading < variance.size() && (leading < kFewestLeading || sum < kLeadingPart * variance.sum())) sum += variance[leading++];
  return leading;
}

}  // namespace

StudySection StudyLongWalks(StudyContext& context) {
  const StudyOptions& options = context.options();
  const std::shared_ptr<const MotionGraph> graph = context.Model(StudyData::kClean);
  const int walks = options.quick ? 5 : 2000;
  StudySection section{.id = "long_walks", .title = "Walks of " + std::to_string(kSteps) + " steps"};
  section.text = "A walk that is drawn step after step may drift off, or grow wilder or tamer, without any single step being wrong. Here " +
                 std::to_string(walks) + " walks of " + std::to_string(kSteps) + " steps are drawn in every style, the first " +
                 std::to_string(kLeftOut) +
                 " steps left out, and each component of a primitive's steps is compared with the captured steps: how far the mean has moved, in "
                 "captured standard deviations, and how wide the steps spread, over the captured standard deviation. Leading components are those that "
                 "together hold 90 % of a primitive's variance.";
  const int styles = static_cast<int>(graph->styles().size());
  std::vector<std::vector<Sums>> sums(static_cast<size_t>(styles));
  ParallelFor(options.jobs, styles, [&](int style) { sums[static_cast<size_t>(style)] = WalkOn(*graph, style, walks, options.seed); });

  Chart mean{.title = "Mean after many steps", .x_label = "component, by captured variance", .y_label = "shift, captured standard deviations"};
  mean.caption = "A curve a primitive. 0 is where the captured steps are.";
  mean.marks = {{"limit", 0.2}, {"limit", -0.2}};
  mean.y_from_zero = false;
  Chart spread{.title = "Spread after many steps", .x_label = "component, by captured variance", .y_label = "spread / captured"};
  spread.caption = "A curve a primitive. 1 is as wide as the captured steps.";
  spread.marks = {{"limit", 0.9}, {"limit", 1.1}};
  spread.y_from_zero = false;
  double greatest_shift = 0, least_spread = 1e9, greatest_spread = 0;
  std::string shift_at, least_at, greatest_at;
  for (int p = 0; p < graph->primitive_count(); ++p) {
    const MotionPrimitive& primitive = graph->primitive(p);
    const std::vector<Sums>& of_style = sums[static_cast<size_t>(primitive.style_index)];
    if (of_style.empty() || of_style[static_cast<size_t>(p)].count < 2) continue;  // a start: no walk comes back to it
    const Sums& drawn = of_style[static_cast<size_t>(p)];
    const Moments captured = CapturedMoments(primitive.mixture);
    const Eigen::ArrayXd drawn_mean = drawn.values.array() / drawn.count;
    const Eigen::ArrayXd shift = (drawn_mean - captured.mean.array()) / captured.variance.array().sqrt();
    const Eigen::ArrayXd ratio = ((drawn.squares.array() / drawn.count - drawn_mean.square()) / captured.variance.array()).max(0.0).sqrt();
    const int leading = LeadingComponents(captured.variance);
    const std::string name = primitive.name + (primitive.style.empty() ? "" : " (" + primitive.style + ")");
    ChartSeries shifts{name}, ratios{name};
    for (int k = 0; k < leading; ++k) {
      shifts.x.push_back(k + 1), ratios.x.push_back(k + 1);
      shifts.y.push_back(shift[k]), ratios.y.push_back(ratio[k]);
      if (std::abs(shift[k]) >= greatest_shift) greatest_shift = std::abs(shift[k]), shift_at = name + ", component " + std::to_string(k + 1);
      if (ratio[k] < least_spread) least_spread = ratio[k], least_at = name + ", component " + std::to_string(k + 1);
      if (ratio[k] > greatest_spread) greatest_spread = ratio[k], greatest_at = name + ", component " + std::to_string(k + 1);
    }
    section.data["primitives"].push_back({{"name", name}, {"steps", drawn.count}, {"leading", leading}, {"shift_sd", shifts.y}, {"spread", ratios.y}});
    mean.series.push_back(std::move(shifts));
    spread.series.push_back(std::move(ratios));
  }
  const bool any = !mean.series.empty();
  if (!any) section.text += "\n\nNo style of this model can walk on for so long.";
  const auto given = [&](double value) { return any ? std::optional(value) : std::nullopt; };
  const std::string what = "of leading components over walks of " + std::to_string(kSteps) + " steps";
  section.figures.push_back({"greatest shift of the mean " + what, given(greatest_shift), "captured sd", std::nullopt, "", std::nullopt, 0.2, shift_at});
  section.figures.push_back({"least spread " + what, given(least_spread), "", std::nullopt, "", 0.9, std::nullopt, least_at});
  section.figures.push_back({"greatest spread " + what, given(greatest_spread), "", std::nullopt, "", std::nullopt, 1.1, greatest_at});
  if (any) {
    section.drawings.push_back(std::move(mean));
    section.drawings.push_back(std::move(spread));
  }
  return section;
}

}  // namespace morphograph
