#include "synthesis/control/sensor_guide.h"

#include <algorithm>
#include <stdexcept>

#include "datasets/errors.h"
#include "synthesis/sensors/motion_source.h"
#include "synthesis/unsatisfiable_request.h"

namespace morphograph {
namespace {

constexpr int kFewestSamples = 3;
constexpr double kLongestReadings_s = kMaxDuration_s;

// The style that a request names; empty where readings are to say it.
std::optional<int> StyleAskedFor(const MotionGraph& graph, const SynthesisRequest& request) {
  const std::string action = request.action.value_or(graph.action_names().front());
  if (!request.style && action == graph.action_names().front()) return std::nullopt;
  for (std::size_t s = 0; s < graph.styles().size(); ++s) {
    const GraphStyle& style = graph.styles()[s];
    if (graph.action_of(style) == action && (!request.style || style.name == *request.style)) return static_cast<int>(s);
  }
  return std::nullopt;  // which Synthesize() refuses
}

void Check(const MotionGraph& graph, const SynthesisRequest& request) {
  const SensorTerm& term = *request.control.sensors;
  if (request.start_from != WalkBoundary::kWalking) throw UnsatisfiableRequest("/start/from", "a clip that readings steer begins inside a walk");
  if (request.end != WalkBoundary::kWalking) throw UnsatisfiableRequest("/end", "a clip that readings steer ends inside a walk");
  for (std::size_t i = 0; i < term.placements.size(); ++i) {
    const int joint = graph.skeleton().FindRoleOrName(term.placements[i].joint);
    if (joint >= 0 && graph.skeleton().IsBody(joint)) continue;
    throw UnsatisfiableRequest("/sensors/placements/" + std::to_string(i) + "/joint", "the model's skeleton has no joint '" + term.placements[i].joint + "' that moves");
  }
}

}  // namespace

std::shared_ptr<const SensorGuide> MakeSensorGuide(const MotionGraph& graph, const SynthesisRequest& request, const SensorStepsSource& source) {
  if (const auto problem = request.FirstProblem()) throw std::invalid_argument("MakeSensorGuide: " + problem->first + " " + problem->second);
  Check(graph, request);
  const SensorTerm& term = *request.control.sensors;
  auto guide = std::make_shared<SensorGuide>();
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
  if (guide->duration_s() > kLongestReadings_s) throw UnsatisfiableRequest("/sensors/readings", "at most " + std::to_string(static_cast<int>(kLongestReadings_s)) + " seconds at a time");

  std::shared_ptr<const SensorSteps> steps;
  if (source) {
    steps = source(guide->placements);
  } else {
    const MotionSource recorded = SourceOf(graph);
    steps = std::make_shared<const SensorSteps>(recorded.clips, recorded.steps, graph.layout(), guide->placements);
  }
  guide->walk = FindWalk(graph, *steps, guide->readings, StyleAskedFor(graph, request));
  return guide;
}

void PrepareSensors(const MotionGraph& graph, SynthesisRequest* request, const SensorStepsSource& source) {
  auto& sensors = request->control.sensors;
  if (sensors && !sensors->guide) sensors->guide = MakeSensorGuide(graph, *request, source);
}

}  // namespace morphograph
