#include "synthesis/control/sensor_guide.h"

#include <algorithm>
#include <stdexcept>

#include "datasets/errors.h"
#include "synthesis/sensors/motion_source.h"
#include "synthesis/unsatisfiable_request.h"

namespace morphograph {
namespace {

constexpr int kFewestSamples = 3;
// Readings that may steer a clip, in seconds times (3 + sensors): 2 minutes of four sensors. Each solution looks at all of them.
constexpr double kMostReadings = 840;

std::string ActionAskedFor(const MotionGraph& graph, const SynthesisRequest& request) { return request.action.value_or(graph.action()); }

// The style that a request names; empty where it names none that there is.
std::optional<int> StyleAskedFor(const MotionGraph& graph, const SynthesisRequest& request) {
  for (std::size_t s = 0; request.style && s < graph.styles().size(); ++s) {
    const GraphStyle& style = graph.styles()[s];
    if (graph.action_of(style) == ActionAskedFor(graph, request) && style.name == *request.style) return static_cast<int>(s);
  }
  return std::nullopt;
}

bool HasAction(const MotionGraph& graph, const std::string& action) {
  const std::vector<std::string> actions = graph.action_names();
  return std::find(actions.begin(), actions.end(), action) != actions.end();
}

std::shared_ptr<const SensorSteps> StepsOf(const MotionGraph& graph, const std::vector<Placement>& placements, const SensorStepsSource& source) {
  try {
    if (source) return source(placements);
    const MotionSource recorded = SourceOf(graph);
    return std::make_shared<const SensorSteps>(recorded.clips, recorded.steps, graph.layout(), placements);
  } catch (const std::invalid_argument&) {  // placements have been checked
    throw UnsatisfiableRequest("/model", "its recordings hold no whole step that readings could be compared with");
  }
}

void Check(const MotionGraph& graph, const SynthesisRequest& request) {
  const SensorTerm& term = *request.control.sensors;
  if (graph.layout().rotation_form() != RotationForm::kLogMap) throw UnsatisfiableRequest("/model", "its poses are Euler angles, which cannot be steered");
  const double longest_s = kMostReadings / (3 + static_cast<double>(term.placements.size()));
  if (!term.readings.times_s.empty() && term.readings.times_s.back() - term.readings.times_s.front() > longest_s) {
    throw UnsatisfiableRequest("/sensors/readings", "of " + std::to_string(term.placements.size()) + " sensors at most " +
                                                        std::to_string(static_cast<int>(longest_s)) + " seconds can steer a clip");
  }
  if (request.start_from != WalkBoundary::kWalking) throw UnsatisfiableRequest("/start/from", "a clip that readings steer begins inside a walk");
  if (request.end != WalkBoundary::kWalking) throw UnsatisfiableRequest("/end", "a clip that readings steer ends inside a walk");
  for (std::size_t i = 0; i < term.placements.size(); ++i) {
    const int joint = graph.skeleton().FindRoleOrName(term.placements[i].joint);
    if (joint >= 0 && graph.skeleton().IsBody(joint)) continue;
    throw UnsatisfiableRequest("/sensors/placements/" + std::to_string(i) + "/joint", "the model's skeleton has no joint '" + term.placements[i].joint + "' that moves");
  }
}

}  // namespace

std::size_t SensorGuide::bytes() const {
  Eigen::Index values = readings.size() + repaired.readings.values.size();
  for (const DrawnStep& drawn : walk.steps) {
    values += drawn.shape.poses.size() + drawn.step.whitened.size() + drawn.step.latent.size();
    for (const auto* of_manner : {&drawn.step.manner.m, &drawn.step.manner.met, &drawn.step.manner.components}) {
      for (const Eigen::VectorXd& part : *of_manner) values += part.size() + 2;
    }
  }
  return sizeof(SensorGuide) + sizeof(double) * static_cast<std::size_t>(values);
}

std::shared_ptr<const SensorGuide> MakeSensorGuide(const MotionGraph& graph, const SynthesisRequest& request, const SensorStepsSource& source) {
  if (const auto problem = request.FirstProblem()) throw std::invalid_argument("MakeSensorGuide: " + problem->first + " " + problem->second);
  Check(graph, request);
  const SensorTerm& term = *request.control.sensors;
  auto guide = std::make_shared<SensorGuide>();
  const std::optional<int> style = StyleAskedFor(graph, request);
  const std::string action = ActionAskedFor(graph, request);
  if ((request.style && !style) || !HasAction(graph, action)) return guide;  // no such style or action, which Synthesize() says
  if (term.readings.sample_count() < kFewestSamples) {
    guide->placements = term.placements;
    guide->readings.resize(3 * static_cast<Eigen::Index>(term.placements.size()), 0);
    guide->repaired.notes.push_back("fewer than 3 readings say nothing of a motion: they steer nothing");
    return guide;
  }
  StreamRepairOptions options;
  options.rate_hz = kSensorRate_hz;
  try {
    guide->repaired = RepairStream(term.readings, options, "readings");
  } catch (const DatasetError& unfit) {
    throw UnsatisfiableRequest("/sensors/readings", unfit.what());
  }
  const Readings& readings = guide->repaired.readings;
  std::vector<Eigen::Index> rows;
  for (int s = 0; s < readings.sensor_count(); ++s) {
    if (std::binary_search(guide->repaired.dead_sensors.begin(), guide->repaired.dead_sensors.end(), s)) continue;
    guide->placements.push_back(term.placements[static_cast<std::size_t>(s)]);
    for (int axis = 0; axis < 3; ++axis) rows.push_back(3 * static_cast<Eigen::Index>(s) + axis);
  }
  guide->readings = readings.values(rows, Eigen::all);

  const std::shared_ptr<const SensorSteps> steps = StepsOf(graph, guide->placements, source);
  guide->walk = FindWalk(graph, *steps, guide->readings, style ? StyleChoice{*style} : StyleChoice{{}, action});
  for (std::size_t k = 1; k < guide->walk.steps.size(); ++k) {
    if (guide->walk.steps[k].step.edge >= 0) continue;
    throw UnsatisfiableRequest(request.style ? "/style" : "/model", "its left and right steps are not joined by transitions, which steering needs");
  }
  return guide;
}

void PrepareSensors(const MotionGraph& graph, SynthesisRequest* request, const SensorStepsSource& source) {
  auto& sensors = request->control.sensors;
  if (sensors && !sensors->guide) sensors->guide = MakeSensorGuide(graph, *request, source);
}

}  // namespace morphograph
