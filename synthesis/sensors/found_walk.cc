#include "synthesis/sensors/found_walk.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
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

// The style that most of the nearest captured steps have, of those that the graph walks in.
WalkingPrimitives ChooseStyle(const MotionGraph& graph, const CapturedSteps& steps, const std::vector<FittedStep>& fitted) {
  std::vector<WalkingPrimitives> styles = FindWalking(graph);
  // Of the graph's own action: styles of another may be called the same, and its feet stand otherwise.
  std::erase_if(styles, [&](const WalkingPrimitives& walking) { return !graph.styles()[static_cast<std::size_t>(walking.style)].other_action.empty(); });
  if (styles.empty()) throw UnsatisfiableRequest("/model", "no style of this model walks");
  Eigen::VectorXd votes = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(steps.styles().size()));
  for (const FittedStep& step : fitted) votes += step.styles;
  double most = -1;
  WalkingPrimitives chosen = styles.front();
  for (const WalkingPrimitives& walking : styles) {
    const auto place = std::find(steps.styles().begin(), steps.styles().end(), graph.styles()[static_cast<std::size_t>(walking.style)].name);
    const double count = place == steps.styles().end() ? 0 : votes[place - steps.styles().begin()];
    if (count > most) most = count, chosen = walking;
  }
  return chosen;
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

// Latents of steps under a primitive's reduction, by weighted least squares.
class Projector {
 public:
  Projector(const MotionPrimitive& primitive, const Eigen::VectorXd& weights)
      : mean_(primitive.reduction.mean), weighted_(weights.array().square().matrix().asDiagonal() * primitive.reduction.basis.cast<double>()) {
    solver_.compute(primitive.reduction.basis.cast<double>().transpose() * weighted_);
  }
  Eigen::VectorXd operator()(const StepShape& shape) const {
    Eigen::VectorXd vector(mean_.size());
    vector << shape.poses.reshaped(), std::log(shape.duration_s), shape.log_slopes;
    return solver_.solve(weighted_.transpose() * (vector - mean_));
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
    manner.components[p] = model.components.cast<double>().rowwise().mean();
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

FoundWalk FindWalk(const MotionGraph& graph, const SensorSteps& sensors, const Eigen::MatrixXd& readings, std::optional<int> style, const StepFitOptions& options) {
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
  const WalkingPrimitives walking = style ? WalkingIn(graph, *style) : ChooseStyle(graph, steps, fitted);
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
