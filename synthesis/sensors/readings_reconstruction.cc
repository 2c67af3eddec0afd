#include "synthesis/sensors/readings_reconstruction.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "datasets/error_reason.h"
#include "datasets/errors.h"
#include "datasets/marker_units.h"
#include "datasets/quantile.h"
#include "datasets/virtual_sensors.h"
#include "synthesis/sensors/marker_selection.h"
#include "synthesis/sensors/marker_tracks.h"
#include "synthesis/unsatisfiable_request.h"

namespace morphograph {
namespace {

// Gravity is as long for every sensor at every time: medians over windows differ by less than this, runs included, and walks out of a stand, in whose first window feet lie still.
constexpr double kAlike = 3.5;
constexpr double kLeastGravity_m_s2 = 6, kMostGravity_m_s2 = 22;  // medians over windows, of sensors that are shaken too
constexpr Eigen::Index kWindows = 8;
constexpr double kTallest_m = 2.6, kDeepest_m = -0.5;
// Of more markers the principal ones are taken: time and memory of learning grow with the square of their number, and the others add little.
constexpr std::size_t kMostMarkers = 12;

// What a sensor or marker says on the whole, in the readings' own unit.
struct TypicalReading {
  double least = 0, most = 0;  // median lengths, over windows of time
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
};

// Of those that move and point somewhere.
std::vector<TypicalReading> TypicalReadings(const Readings& readings) {
  std::vector<TypicalReading> typical;
  for (int s = 0; s < readings.sensor_count(); ++s) {
    std::vector<Eigen::Vector3d> values;
    bool moves = false;
    TypicalReading reading;
    double lengths = 0;
    for (Eigen::Index i = 0; i < readings.values.cols(); ++i) {
      const Eigen::Vector3d value = readings.values.col(i).segment<3>(3 * static_cast<Eigen::Index>(s));
      if (!value.allFinite()) continue;
      values.push_back(value);
      moves = moves || value != values.front();
      reading.mean += value;
      lengths += value.norm();
    }
    if (!moves || reading.mean.norm() < 0.2 * lengths) continue;
    const auto count = static_cast<Eigen::Index>(values.size());
    reading.mean /= static_cast<double>(count);
    for (Eigen::Index w = 0; w < std::min(kWindows, count); ++w) {
      const Eigen::Index windows = std::min(kWindows, count);
      std::vector<double> of_window;
      for (Eigen::Index i = w * count / windows; i < (w + 1) * count / windows; ++i) of_window.push_back(values[static_cast<std::size_t>(i)].norm());
      const double length = Median(of_window);
      reading.least = w == 0 ? length : std::min(reading.least, length);
      reading.most = std::max(reading.most, length);
    }
    typical.push_back(reading);
  }
  return typical;
}

// Whether points that lie so on the average may be markers on a body on the floor, with `metres` a unit.
bool MayBeABody(const std::vector<TypicalReading>& points, double metres) {
  for (const TypicalReading& a : points) {
    if (metres * a.mean.y() > kTallest_m || metres * a.mean.y() < kDeepest_m) return false;
    for (const TypicalReading& b : points) {
      if (metres * (a.mean - b.mean).norm() > kTallest_m) return false;
    }
  }
  return true;
}

// Our CSV does not say whether it holds accelerations or markers, but gravity is as long for every sensor, and a body is not 9.81 m up in the air.
void CheckKind(const Readings& readings, bool markers, const std::string& source) {
  const std::vector<TypicalReading> typical = TypicalReadings(readings);
  if (typical.size() < 2) return;
  double least = typical.front().least, most = 0;
  for (const TypicalReading& reading : typical) {
    least = std::min(least, reading.least);
    most = std::max(most, reading.most);
  }
  if (markers && least > kLeastGravity_m_s2 && most < kMostGravity_m_s2 && !MayBeABody(typical, 1))
    throw DatasetError(source, "the values look like accelerations (every sensor says about 9.81), not like positions in metres, which the method 'markers' takes");
  if (!markers && most > kAlike * least && MayBeABody(typical, MetresPerMarkerUnit(readings)))
    throw DatasetError(source, "the values look like positions of markers, not like accelerations, which all hold gravity and are about 9.81 m/s^2 long; the method 'markers' takes positions");
}

// Positions among `living` (3 * markers x frames) of the markers that say most of the others, seen from the frame that all define.
std::vector<int> PrincipalOf(const Eigen::MatrixXd& living) {
  const Eigen::Index markers = living.rows() / 3;
  Eigen::Matrix3Xd usual(3, markers);
  for (Eigen::Index m = 0; m < markers; ++m) usual.col(m) = living.col(0).segment<3>(3 * m);
  const MarkerFrame frame(usual);
  Eigen::MatrixXf tracks(living.rows(), living.cols());
  for (Eigen::Index f = 0; f < living.cols(); ++f) {
    const MarkerFrame::Place place = frame.Fit(living.col(f));
    for (Eigen::Index m = 0; m < markers; ++m) tracks.col(f).segment<3>(3 * m) = place.Into(living.col(f).segment<3>(3 * m)).cast<float>();
  }
  MarkerSelectionOptions options;
  options.count = static_cast<int>(kMostMarkers);
  return PrincipalMarkers(tracks, options);
}

std::string Decimal(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

StandingPhase StandingOf(const AlignmentRequest& request, const Eigen::MatrixXd& readings, const std::vector<std::string>& sensors) {
  const std::string pointer = "/alignment/standing";
  if (!request.standing) {
    const auto found = FindStanding(readings, kReconstructionRate_hz);
    if (!found) throw UnsatisfiableRequest(pointer, "there is no second in which all sensors lie still: stand for a while before or after the motion, or leave the alignment out");
    return *found;
  }
  Eigen::VectorXd unrest;
  try {
    unrest = UnrestOf(readings, kReconstructionRate_hz, *request.standing);
  } catch (const std::invalid_argument& unfit) {
    throw UnsatisfiableRequest(pointer, ReasonOf(unfit));
  }
  Eigen::Index worst = 0;
  if (unrest.maxCoeff(&worst) > kMostUnrest_m_s2) {
    throw UnsatisfiableRequest(pointer, "nobody stands there: sensor '" + sensors[static_cast<std::size_t>(worst)] + "' moves by " + Decimal(unrest[worst]) + " m/s^2, at most " +
                                            Decimal(kMostUnrest_m_s2) + " is taken for lying still");
  }
  return *request.standing;
}

// Tilt from gravity while standing, then by turns a reconstruction and what it says of the sensors.
SensorTurns Align(const Reconstructor& reconstructor, const Eigen::MatrixXd& readings, const StandingPhase& standing) {
  SensorTurns turns = AlignByStanding(reconstructor.worn(), readings, kReconstructionRate_hz, standing);
  for (int round = 0; round < kAlignmentRounds; ++round) {
    const Reconstruction made = reconstructor.Run(AlignedReadings(readings, kReconstructionRate_hz, turns));
    const Readings expected = VirtualAccelerations(made.clip, reconstructor.sensors(), kReconstructionRate_hz);
    AlignByMotion(reconstructor.worn(), readings, expected.values, kReconstructionRate_hz, &turns);
  }
  return turns;
}

}  // namespace

ReconstructedReadings ReconstructReadings(const MotionGraph& graph, const ReconstructionRequest& request, const ReconstructorSource& make) {
  // What cannot be placed is said before any work is done.
  PlacesOf(request.readings.names, request.placements, graph, request.method);
  if (request.alignment && request.method == ReconstructionMethod::kMarkers)
    throw UnsatisfiableRequest("/alignment", "markers have no axes that could be askew; only accelerometers are aligned");
  CheckKind(request.readings, request.method == ReconstructionMethod::kMarkers, request.source);
  StreamRepairOptions options;
  options.kind = request.method == ReconstructionMethod::kMarkers ? ReadingsKind::kMarkers : ReadingsKind::kAccelerations;
  options.rate_hz = kReconstructionRate_hz;
  options.cutoff_hz = request.low_pass_hz;
  ReconstructedReadings result;
  result.repaired = RepairStream(request.readings, options, request.source);
  const Readings& readings = result.repaired.readings;
  const std::vector<int>& dead = result.repaired.dead_sensors;
  std::vector<Eigen::Index> rows;
  for (int s = 0; s < readings.sensor_count(); ++s) {
    if (std::binary_search(dead.begin(), dead.end(), s)) continue;
    result.sensors.push_back(readings.names[static_cast<std::size_t>(s)]);
    for (int axis = 0; axis < 3; ++axis) rows.push_back(3 * static_cast<Eigen::Index>(s) + axis);
  }
  Eigen::MatrixXd living = readings.values(rows, Eigen::all);
  if (request.method == ReconstructionMethod::kMarkers && result.sensors.size() > kMostMarkers) {
    std::vector<std::string> names;
    std::vector<Eigen::Index> kept;
    std::string told;
    for (const int m : PrincipalOf(living)) {
      names.push_back(result.sensors[static_cast<std::size_t>(m)]);
      told += (told.empty() ? "" : ", ") + names.back();
      for (int axis = 0; axis < 3; ++axis) kept.push_back(3 * static_cast<Eigen::Index>(m) + axis);
    }
    result.repaired.notes.push_back("of " + std::to_string(result.sensors.size()) + " markers the " + std::to_string(kMostMarkers) + " that say most of the others are used: " + told);
    result.sensors = std::move(names);
    living = Eigen::MatrixXd(living(kept, Eigen::all));
  }
  const double begin_s = readings.times_s.front();
  StandingPhase standing;
  if (request.alignment) {
    AlignmentRequest asked = *request.alignment;
    if (asked.standing) asked.standing = StandingPhase{asked.standing->from_s - begin_s, asked.standing->to_s - begin_s};
    standing = StandingOf(asked, living, result.sensors);
  }
  const std::shared_ptr<const Reconstructor> reconstructor = make(PlacesOf(result.sensors, request.placements, graph, request.method));
  try {
    if (request.alignment) {
      result.alignment = Align(*reconstructor, living, standing);
      result.alignment->told = request.alignment->standing.has_value();
      living = AlignedReadings(living, kReconstructionRate_hz, *result.alignment);
      result.alignment->standing.from_s += begin_s;
      result.alignment->standing.to_s += begin_s;
    }
    result.reconstruction = reconstructor->Run(living);
  } catch (const std::invalid_argument& unfit) {
    throw DatasetError(request.source, ReasonOf(unfit));
  }
  return result;
}

}  // namespace morphograph
