#include "api/request/control_writer.h"

#include <cmath>

#include "api/request/angles.h"

namespace morphograph {
namespace {

using nlohmann::ordered_json;

ordered_json PointJson(const Eigen::Vector2d& point) { return ordered_json::array({point.x(), point.y()}); }
ordered_json PointJson(const Eigen::Vector3d& point) { return ordered_json::array({point.x(), point.y(), point.z()}); }

ordered_json PointsJson(const std::vector<Eigen::Vector2d>& points) {
  ordered_json list = ordered_json::array();
  for (const Eigen::Vector2d& point : points) list.push_back(PointJson(point));
  return list;
}

void PutUnless(double usual, const char* name, double value, ordered_json* json) {
  if (value != usual) (*json)[name] = value;
}

void PutMoment(const ControlMoment& moment, ordered_json* json) {
  if (moment.time_s) (*json)["time"] = *moment.time_s;
  if (moment.keyframe) (*json)["keyframe"] = *moment.keyframe;
}

template <typename Term>
void PutTolerance_m(const Term& term, ordered_json* json) {
  PutUnless(Term().tolerance_m, "tolerance", term.tolerance_m, json);
}

template <typename Term>
void PutTolerance_deg(const Term& term, ordered_json* json) {
  PutUnless(DegreesFromRadians(Term().tolerance_rad), "tolerance", DegreesFromRadians(term.tolerance_rad), json);
}

ordered_json SensorsJson(const SensorTerm& term) {
  ordered_json json = {{"times", term.readings.times_s}, {"placements", ordered_json::parse(PlacementsJson(term.placements)).at("placements")}};
  ordered_json& rows = json["readings"] = ordered_json::array();
  for (Eigen::Index n = 0; n < term.readings.values.cols(); ++n) {
    ordered_json& row = rows.emplace_back(ordered_json::array());
    for (Eigen::Index v = 0; v < term.readings.values.rows(); ++v) {
      const double value = term.readings.values(v, n);
      row.push_back(std::isfinite(value) ? ordered_json(value) : ordered_json());
    }
  }
  if (term.tolerance_m_s2) json["tolerance"] = *term.tolerance_m_s2;
  PutUnless(1, "weight", term.weight, &json);
  return json;
}

// One overload a kind of constraint.
struct ConstraintWriter {
  ordered_json operator()(const PositionTerm& term) const {
    ordered_json json = {{"type", "position"}, {"joint", term.joint}};
    PutMoment(term.at, &json);
    ordered_json& value = json["value"] = PointJson(term.value_m);
    for (std::size_t i = 0; i < 3; ++i) {
      if (!term.use[i]) value[i] = nullptr;
    }
    PutTolerance_m(term, &json);
    return json;
  }
  ordered_json operator()(const OrientationTerm& term) const {
    ordered_json json = {{"type", "orientation"}, {"joint", term.joint}};
    PutMoment(term.at, &json);
    json["value"] = {term.value.w(), term.value.x(), term.value.y(), term.value.z()};
    PutTolerance_deg(term, &json);
    return json;
  }
  ordered_json operator()(const TrajectoryTerm& term) const {
    ordered_json json = {{"type", "trajectory"}, {"joint", term.joint}};
    ordered_json& points = json["points"] = ordered_json::array();
    for (std::size_t i = 0; i < term.times_s.size(); ++i) {
      const Eigen::Vector3d& point = term.points_m[i];
      points.push_back({term.times_s[i], point.x(), point.y(), point.z()});
    }
    PutTolerance_m(term, &json);
    return json;
  }
  ordered_json operator()(const HeadingTerm& term) const {
    ordered_json json = {{"type", "heading"}};
    PutMoment(term.at, &json);
    json["value"] = DegreesFromRadians(term.value_rad);
    PutTolerance_deg(term, &json);
    return json;
  }
  ordered_json operator()(const FootstepTerm& term) const {
    ordered_json json = {{"type", "footstep"}, {"foot", term.left ? "left" : "right"}, {"index", term.index}};
    json["value"] = PointJson(term.value_m);
    PutTolerance_m(term, &json);
    return json;
  }
  ordered_json operator()(const KeepOutTerm& term) const {
    ordered_json json = {{"type", "keep_out"}};
    if (term.polygon_m.empty()) {
      json["circle"] = {{"center", PointJson(term.center_m)}, {"radius", term.radius_m}};
    } else {
      json["polygon"] = PointsJson(term.polygon_m);
    }
    return json;
  }
  ordered_json operator()(const LookAtTerm& term) const {
    ordered_json json = {{"type", "look_at"}, {"from", term.from_s}, {"to", term.to_s}, {"value", PointJson(term.value_m)}};
    PutTolerance_deg(term, &json);
    return json;
  }
  ordered_json operator()(const PoseTerm& term) const {
    ordered_json json = {{"type", "pose"}};
    PutMoment(term.at, &json);
    ordered_json& joints = json["joints"] = ordered_json::object();
    for (std::size_t i = 0; i < term.joints.size(); ++i) joints[term.joints[i]] = PointJson(term.values_m[i]);
    PutTolerance_m(term, &json);
    return json;
  }
};

}  // namespace

void WriteControlTerms(const ControlTerms& terms, ordered_json* request) {
  if (const auto& path = terms.path) {
    ordered_json& json = (*request)["path"] = {{"points", PointsJson(path->points_m)}};
    if (path->smooth) json["interpolation"] = "spline";
    PutTolerance_m(*path, &json);
    PutUnless(1, "weight", path->weight, &json);
  }
  if (const auto& goal = terms.goal) {
    ordered_json& json = (*request)["goal"] = {{"position", PointJson(goal->position_m)}};
    if (goal->heading_rad) json["heading"] = DegreesFromRadians(*goal->heading_rad);
    PutTolerance_m(*goal, &json);
    PutUnless(DegreesFromRadians(GoalTerm().heading_tolerance_rad), "heading_tolerance", DegreesFromRadians(goal->heading_tolerance_rad), &json);
    if (goal->time_s) json["time"] = *goal->time_s;
    PutUnless(1, "weight", goal->weight, &json);
  }
  if (const auto& speed = terms.speed) {
    const bool is_plain = speed->profile.size() == 1 && speed->profile[0].time_s == 0 && speed->tolerance_m_s == SpeedTerm().tolerance_m_s && speed->weight == 1;
    if (is_plain) {
      (*request)["speed"] = speed->profile[0].speed_m_s;
    } else {
      ordered_json& json = (*request)["speed"] = ordered_json::object();
      ordered_json& profile = json["profile"] = ordered_json::array();
      for (const SpeedTerm::Knot& knot : speed->profile) profile.push_back({knot.time_s, knot.speed_m_s});
      PutUnless(SpeedTerm().tolerance_m_s, "tolerance", speed->tolerance_m_s, &json);
      PutUnless(1, "weight", speed->weight, &json);
    }
  }
  if (terms.sensors) (*request)["sensors"] = SensorsJson(*terms.sensors);
  if (terms.constraints.empty()) return;
  ordered_json& constraints = (*request)["constraints"] = ordered_json::array();
  for (const Constraint& constraint : terms.constraints) {
    constraints.push_back(std::visit(ConstraintWriter(), constraint));
    std::visit([&](const auto& term) { PutUnless(1, "weight", term.weight, &constraints.back()); }, constraint);
  }
}

}  // namespace morphograph
