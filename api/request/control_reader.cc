#include "api/request/control_reader.h"

#include <algorithm>

#include "api/request/angles.h"
#include "api/request/readings_reader.h"
#include "synthesis/synthesis_types.h"

namespace morphograph {

using nlohmann::json;

void ReadTolerance(std::string_view name, const NumberBounds& bounds, ObjectReader* reader, double* value) {
  const auto number = reader->Finite(name);
  if (!number) return;
  if (!(*number > 0)) {
    reader->findings()->Malformed(reader->At(name), "must be above 0");
  } else if (*number < bounds.least || *number > bounds.most) {
    reader->findings()->Unmeetable(reader->At(name), *number < bounds.least ? "at least " + NumberText(bounds.least) + " " + bounds.unit
                                                                            : "at most " + NumberText(bounds.most) + " " + bounds.unit);
  } else {
    *value = *number;
  }
}

void ReadWeight(ObjectReader* reader, double* weight) { ReadTolerance("weight", {0.01, 100, "times"}, reader, weight); }

std::optional<double> ReadTime(const json& value, const std::string& pointer, Findings* findings) {
  if (value.is_number() && value.get<double>() < 0) {
    findings->Malformed(pointer, "must be 0 or more seconds");
    return std::nullopt;
  }
  return ReadBounded(value, pointer, {0, kMaxDuration_s, "seconds"}, findings);
}

std::optional<double> ReadTime(std::string_view name, ObjectReader* reader) {
  const json* value = reader->Take(name);
  return value ? ReadTime(*value, reader->At(name), reader->findings()) : std::nullopt;
}

std::optional<double> ReadAngle(std::string_view name, ObjectReader* reader) {
  const auto angle_deg = reader->Bounded(name, {-kMaxAngle_deg, kMaxAngle_deg, "degrees"});
  return angle_deg ? std::optional(RadiansFromDegrees(*angle_deg)) : std::nullopt;
}

namespace {

constexpr double kSamePoint_m = 1e-3;

void ReadPath(const json& object, Findings* findings, ControlTerms* terms) {
  ObjectReader reader(object, "/path", findings);
  PathTerm& path = terms->path.emplace();
  const json* points =
      reader.Required("points", reader.List("points", 2, kMaxPathPoints, "points"), "the line on the floor, [[x, z], …] in metres");
  for (std::size_t i = 0; points && i < points->size() && !findings->full(); ++i) {
    Eigen::Vector2d& point = path.points_m.emplace_back();
    ReadCoordinates((*points)[i], "/path/points/" + std::to_string(i), 2, "two numbers, [x, z] in metres", findings, point.data());
  }
  // A hand that draws stays where it is for a moment.
  const auto is_same = [](const Eigen::Vector2d& kept, const Eigen::Vector2d& next) { return (next - kept).norm() < kSamePoint_m; };
  path.points_m.erase(std::unique(path.points_m.begin(), path.points_m.end(), is_same), path.points_m.end());
  ReadTolerance("tolerance", kToleranceBounds_m, &reader, &path.tolerance_m);
  ReadWeight(&reader, &path.weight);
  if (const auto interpolation = reader.Text("interpolation")) {
    path.smooth = *interpolation == "spline";
    if (!path.smooth && *interpolation != "linear") findings->Malformed("/path/interpolation", "must be \"linear\" or \"spline\"");
  }
  reader.RefuseOthers();
}

void ReadGoal(const json& object, Findings* findings, ControlTerms* terms) {
  ObjectReader reader(object, "/goal", findings);
  GoalTerm& goal = terms->goal.emplace();
  if (const auto position = reader.Required("position", reader.FloorPoint("position"), "where the clip ends, [x, z] in metres"))
    goal.position_m = *position;
  goal.heading_rad = ReadAngle("heading", &reader);
  ReadTolerance("tolerance", kToleranceBounds_m, &reader, &goal.tolerance_m);
  ReadWeight(&reader, &goal.weight);
  double tolerance_deg = DegreesFromRadians(goal.heading_tolerance_rad);
  ReadTolerance("heading_tolerance", kToleranceBounds_deg, &reader, &tolerance_deg);
  goal.heading_tolerance_rad = RadiansFromDegrees(tolerance_deg);
  if (reader.Has("heading_tolerance") && !reader.Has("heading"))
    findings->Malformed("/goal/heading_tolerance", "there is no \"heading\" that it could belong to");
  goal.time_s = ReadTime("time", &reader);
  if (goal.time_s && !(*goal.time_s > 0)) findings->Malformed("/goal/time", "must be above 0 seconds");
  reader.RefuseOthers();
}

std::optional<double> ReadSpeedValue(const json& value, const std::string& pointer, Findings* findings) {
  if (value.is_number() && value.get<double>() < 0) {
    findings->Malformed(pointer, "must be 0 or more");
    return std::nullopt;
  }
  return ReadBounded(value, pointer, {0, kMaxSpeed_m_s, "m/s"}, findings);
}

void ReadSpeedProfile(const json& object, Findings* findings, SpeedTerm* speed) {
  ObjectReader reader(object, "/speed", findings);
  const json* profile = reader.Required("profile", reader.List("profile", 1, kMaxPathPoints, "knots"), "[[time, speed], …] in s and m/s");
  for (std::size_t i = 0; profile && i < profile->size() && !findings->full(); ++i) {
    const json& knot = (*profile)[i];
    const std::string pointer = "/speed/profile/" + std::to_string(i);
    if (!knot.is_array() || knot.size() != 2) {
      findings->Malformed(pointer, "must be two numbers, [time in seconds, speed in m/s]");
      continue;
    }
    const auto time_s = ReadTime(knot[0], pointer + "/0", findings);
    const auto speed_m_s = ReadSpeedValue(knot[1], pointer + "/1", findings);
    if (time_s && !speed->profile.empty() && !(*time_s > speed->profile.back().time_s))
      findings->Malformed(pointer + "/0", "times must rise");
    speed->profile.push_back({time_s.value_or(0), speed_m_s.value_or(0)});
  }
  ReadTolerance("tolerance", kToleranceBounds_m_s, &reader, &speed->tolerance_m_s);
  ReadWeight(&reader, &speed->weight);
  reader.RefuseOthers();
}

void ReadConstraints(const json& list, Findings* findings, ControlTerms* terms) {
  for (std::size_t i = 0; i < list.size() && !findings->full(); ++i) {
    const std::string pointer = "/constraints/" + std::to_string(i);
    Constraint& constraint = terms->constraints.emplace_back();
    if (!list[i].is_object()) {
      findings->Malformed(pointer, std::string("must be an object, not ") + list[i].type_name());
      continue;
    }
    ObjectReader reader(list[i], pointer, findings);
    const auto type = reader.Required("type", reader.Text("type"), ConstraintTypes());
    if (!type) continue;
    if (ReadConstraint(*type, &reader, &constraint)) {
      std::visit([&](auto& term) { ReadWeight(&reader, &term.weight); }, constraint);
      reader.RefuseOthers();
    } else {
      findings->Malformed(reader.At("type"), "must be one of " + ConstraintTypes());
    }
  }
}

}  // namespace

void ReadControlTerms(ObjectReader* request, ControlTerms* terms) {
  Findings* findings = request->findings();
  if (const json* path = request->Object("path")) ReadPath(*path, findings, terms);
  if (const json* goal = request->Object("goal")) ReadGoal(*goal, findings, terms);
  if (const json* sensors = request->Object("sensors")) {
    SensorTerm& term = terms->sensors.emplace();
    double tolerance_m_s2 = 0;
    PlacedReadings placed = ReadPlacedReadings(*sensors, "/sensors", findings, &tolerance_m_s2, &term.weight);
    term.readings = std::move(placed.readings);
    term.placements = std::move(placed.placements);
    if (tolerance_m_s2 > 0) term.tolerance_m_s2 = tolerance_m_s2;
  }
  if (const json* speed = request->Take("speed")) {
    SpeedTerm& term = terms->speed.emplace();
    if (speed->is_object()) {
      ReadSpeedProfile(*speed, findings, &term);
    } else if (speed->is_number()) {
      const auto value = ReadSpeedValue(*speed, "/speed", findings);
      term.profile.push_back({0, value.value_or(0)});
    } else {
      findings->Malformed("/speed", "must be a number in m/s or {\"profile\": [[time, speed], …]}");
    }
  }
  if (const json* constraints = request->List("constraints", 0, kMaxConstraints, "constraints"))
    ReadConstraints(*constraints, findings, terms);
}

}  // namespace morphograph
