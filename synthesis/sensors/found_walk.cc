#include "synthesis/sensors/found_walk.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "graph/walk_boundary.h"
#include "primitives/rotation_math.h"
#include "primitives/step_vector.h"
#include "primitives/whitening.h"
#include "synthesis/control/walk_prior.h"
#include "synthesis/unsatisfiable_request.h"

namespace morphograph {
namespace {

// The primitives of steady walking in one style.
struct WalkingPrimitives {
  int style = -1;      // of the graph
  int landing[2] = {-1, -1};  // by the foot that lands: left, right
  bool complete() const { return landing[0] >= 0 && landing[1] >= 0; }
};

std::vector<WalkingPrimitives> FindWalking(const MotionGraph& graph) {
  std::vector<WalkingPrimitives> styles(graph.styles().size());
  for (int p = 0; p < graph.primitive_count(); ++p) {
    const MotionPrimitive& primitive = graph.primitive(p);
    if (!IsSteady(primitive)) continue;
    WalkingPrimitives& walking = styles[static_cast<std::size_t>(primitive.style_index)];
    walking.style = primitive.style_index;
    int& place = walking.landing[primitive.end == KeyframeLabel::kLeftStance ? 0 : 1];
    if (place < 0 || graph.primitive(place).examples < primitive.examples) place = p;
  }
  std::erase_if(styles, [](const WalkingPrimitives& walking) { return !walking.complete(); });
  return styles;
}


WalkingPrimitives WalkingIn(const MotionGraph& graph, int style) {
  const std::vector<WalkingPrimitives> styles = FindWalking(graph);
  const auto found = std::find_if(styles.begin(), styles.end(), [&](const WalkingPrimitives& walking) { return walking.style == style; });
  if (found == styles.end()) throw UnsatisfiableRequest("/style", "the model has no steady steps of both feet in this style to fit to readings");
  return *found;
}

StepShape ShapeOf(const PoseLayout& layout, const MeanRotations& from, const MeanRotations& to, const FittedStep& fitted, double duration_s) {
  StepShape shape{fitted.poses, duration_s, Eigen::VectorXd::Zero(kWarpKnots)};
  for (std::size_t n = 0; n < layout.active_joints().size(); ++n) {
    const auto joint = static_cast<std::size_t>(layout.active_joints()[n]);
    for (Eigen::Index i = 0; i < shape.poses.cols(); ++i) {
      auto channels = shape.poses.block<3, 1>(3 + 3 * static_cast<Eigen::Index>(n), i);
      channels = LogMapAbout(to[joint], ExpMapAbout(from[joint], channels));
    }
  }
  return shape;
}

// The vector of a step (StepReduction).
Eigen::VectorXd VectorOf(const StepShape& shape, Eigen::Index size) {
  Eigen::VectorXd vector(size);
  vector << shape.poses.reshaped(), std::log(shape.duration_s), shape.log_slopes;
  return vector;
}

// Which of some styles' mean steps a step is nearest to: their place in the list.
std::size_t NearestStyle(const MotionGraph& graph, const CapturedSteps& steps, const std::vector<WalkingPrimitives>& styles, const FoundStep& found, const FittedStep& fitted) {
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < styles.size(); ++i) {
    const MeanRotations& means = graph.styles()[static_cast<std::size_t>(styles[i].style)].mean_rotations;
    const StepReduction& reduction = graph.primitive(styles[i].landing[found.left ? 0 : 1]).reduction;
    const Eigen::VectorXd step = VectorOf(ShapeOf(graph.layout(), steps.means(), means, fitted, found.frames() / kSensorRate_hz), reduction.mean.size());
    const double distance = (step - reduction.mean).cwiseProduct(StepWeights(graph.layout().ChannelWeights(means))).squaredNorm();
    if (distance < least) least = distance, nearest = i;
  }
  return nearest;
}

// The style of an action that most of the nearest captured steps have, of those that the graph walks in. Captured steps know their style's name only: where styles
// of several actions are called the same, a step's votes for that name are for the one whose mean step it is nearest to.
WalkingPrimitives ChooseStyle(const MotionGraph& graph, const CapturedSteps& steps, const std::string& action, const std::vector<FoundStep>& found, const std::vector<FittedStep>& fitted) {
  const std::vector<WalkingPrimitives> styles = FindWalking(graph);
  const auto style_of = [&](const WalkingPrimitives& walking) -> const GraphStyle& { return graph.styles()[static_cast<std::size_t>(walking.style)]; };
  std::optional<WalkingPrimitives> chosen;
  double most = -1;
  for (const WalkingPrimitives& walking : styles) {
    if (graph.action_of(style_of(walking)) != action) continue;
    std::vector<WalkingPrimitives> same_name = {walking};
    for (const WalkingPrimitives& other : styles) {
      if (other.style != walking.style && style_of(other).name == style_of(walking).name) same_name.push_back(other);
    }
    const auto place = std::find(steps.styles().begin(), steps.styles().end(), style_of(walking).name) - steps.styles().begin();
    double votes = 0;
    for (std::size_t k = 0; k < fitted.size() && place < static_cast<std::ptrdiff_t>(steps.styles().size()); ++k) {
      if (same_name.size() == 1 || NearestStyle(graph, steps, same_name, found[k], fitted[k]) == 0) votes += fitted[k].styles[place];
    }
    if (votes > most) most = votes, chosen = walking;
  }
  if (!chosen) throw UnsatisfiableRequest("/model", "no style of this model has steady steps of both feet" + (action == graph.action() ? std::string() : " in the action '" + action + "'"));
  return *chosen;
}

// Latents of steps under a primitive's reduction, by weighted least squares.
class Projector {
 public:
  Projector(const MotionPrimitive& primitive, const Eigen::VectorXd& weights)
      : mean_(primitive.reduction.mean), weighted_(weights.array().square().matrix().asDiagonal() * primitive.reduction.basis.cast<double>()) {
    solver_.compute(primitive.reduction.basis.cast<double>().transpose() * weighted_);
  }
  Eigen::VectorXd operator()(const StepShape& shape) const {
    return solver_.solve(weighted_.transpose() * (VectorOf(shape, mean_.size()) - mean_));
  }

 private:
  Eigen::VectorXd mean_;
  Eigen::MatrixXd weighted_;
  Eigen::LLT<Eigen::MatrixXd> solver_;
};

// Puts the steps on the graph: latents, components, edges and likelihoods.
void Locate(const MotionGraph& graph, int style, std::vector<DrawnStep>* walk) {
  const Eigen::VectorXd weights = StepWeights(graph.layout().ChannelWeights(graph.styles()[static_cast<std::size_t>(style)].mean_rotations));
  std::map<int, Projector> projectors;
  WalkManner manner;
  manner.m.resize(static_cast<std::size_t>(graph.primitive_count()));
  manner.met.resize(manner.m.size());
  manner.components.resize(manner.m.size());
  std::map<int, int> counts;
  for (DrawnStep& drawn : *walk) {
    const int p = drawn.step.primitive;
    const MotionPrimitive& primitive = graph.primitive(p);
    drawn.step.latent = projectors.try_emplace(p, primitive, weights).first->second(drawn.shape);
    drawn.step.component = primitive.mixture.MostLikely(drawn.step.latent);
    drawn.step.whitened = Whiten(primitive.mixture.Component(drawn.step.component), drawn.step.latent);
    Eigen::VectorXd& sum = manner.m[static_cast<std::size_t>(p)];
    if (sum.size() == 0) sum = Eigen::VectorXd::Zero(drawn.step.whitened.size());
    sum += drawn.step.whitened;
    ++counts[p];
  }
  // The walk's manner: the best prediction of what its steps have in common (MannerModel).
  for (const auto& [p, n] : counts) {
    const MannerModel& model = graph.primitive(p).manner;
    if (model.empty()) continue;
    const Eigen::ArrayXd share = model.share.array();
    manner.m[static_cast<std::size_t>(p)].array() *= share / (n * share + 1 - share);
  }
  // A walk that goes on from here needs a manner in every primitive of its style: that of the captured walks together where it has no step.
  for (std::size_t p = 0; p < manner.m.size(); ++p) {
    const MannerModel& model = graph.primitive(static_cast<int>(p)).manner;
    if (model.empty() || graph.primitive(static_cast<int>(p)).style_index != style) continue;
    if (manner.m[p].size() == 0) manner.m[p] = Eigen::VectorXd::Zero(model.captured.rows());
  }
  for (std::size_t k = 0; k < walk->size(); ++k) {
    WalkStep& step = (*walk)[k].step;
    step.manner = manner;
    step.edge = -1;
    if (k > 0) {
      const WalkStep& previous = (*walk)[k - 1].step;
      for (const int edge : graph.out_edges(previous.primitive)) {
        if (graph.edge_to(edge) == step.primitive) step.edge = edge;
      }
      if (step.edge >= 0) step.log_likelihood = StepInnovation(graph, previous, step).LogLikelihood(previous.whitened, step.whitened);
    }
    if (step.edge < 0) step.log_likelihood = graph.primitive(step.primitive).mixture.LogDensity(step.latent);
  }
}

}  // namespace

FoundWalk FindWalk(const MotionGraph& graph, const SensorSteps& sensors, const Eigen::MatrixXd& readings, const StyleChoice& style, const StepFitOptions& options) {
  const CapturedSteps& steps = sensors.steps();
  if (readings.rows() != 3 * static_cast<Eigen::Index>(steps.sensors().size())) throw std::invalid_argument("FindWalk: readings are not of these sensors");
  const std::vector<FoundStep> found = sensors.search().Find(readings);
  FoundWalk walk;
  if (found.empty()) return walk;
  std::vector<FittedStep> fitted;
  double squares = 0;
  for (const FoundStep& step : found) {
    fitted.push_back(FitStep(steps, readings, step, options));
    squares += fitted.back().residual_m_s2 * fitted.back().residual_m_s2 / static_cast<double>(found.size());
  }
  walk.residual_m_s2 = std::sqrt(squares);
  const WalkingPrimitives walking = style.style ? WalkingIn(graph, *style.style) : ChooseStyle(graph, steps, style.action.empty() ? graph.action() : style.action, found, fitted);
  walk.style = walking.style;
  const MeanRotations& means = graph.styles()[static_cast<std::size_t>(walking.style)].mean_rotations;
  for (std::size_t k = 0; k < found.size(); ++k) {
    DrawnStep drawn;
    drawn.step.primitive = walking.landing[found[k].left ? 0 : 1];
    drawn.shape = ShapeOf(graph.layout(), steps.means(), means, fitted[k], found[k].frames() / kSensorRate_hz);
    drawn.start = found[k].start_frame;
    drawn.end = found[k].end_frame;
    walk.steps.push_back(std::move(drawn));
  }
  Locate(graph, walking.style, &walk.steps);
  return walk;
}

}  // namespace morphograph
