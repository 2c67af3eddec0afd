#include <array>
#include <cmath>

#include "api/request/angles.h"
#include "api/request/control_reader.h"
#include "synthesis/synthesis_types.h"

namespace morphograph {
namespace {

using nlohmann::json;

void ReadMoment(ObjectReader* reader, ControlMoment* moment) {
  moment->time_s = ReadTime("time", reader);
  moment->keyframe = reader->Whole("keyframe", 0, kMaxSteps);
  // Asked of the object: a member that is there but wrong has its own finding.
  const bool has_time = reader->Has("time"), has_keyframe = reader->Has("keyframe");
  if (has_time && has_keyframe) {
    reader->findings()->Malformed(reader->At("keyframe"), "give either \"time\" or \"keyframe\"");
  } else if (!has_time && !has_keyframe) {
    reader->findings()->Malformed(reader->pointer(), "required: \"time\" in seconds, or \"keyframe\", counted from 0");
  }
}

void ReadJoint(ObjectReader* reader, std::string* joint) {
  if (auto name = reader->Required("joint", reader->Text("joint"), "a role (\"left_wrist\") or a joint's own name")) *joint = std::move(*name);
}

void ReadDegreesTolerance(ObjectReader* reader, double* tolerance_rad) {
  double tolerance_deg = DegreesFromRadians(*tolerance_rad);
  ReadTolerance("tolerance", kToleranceBounds_deg, reader, &tolerance_deg);
  *tolerance_rad = RadiansFromDegrees(tolerance_deg);
}

void ReadPosition(ObjectReader* reader, PositionTerm* term) {
  ReadJoint(reader, &term->joint);
  ReadMoment(reader, &term->at);
  ReadTolerance("tolerance", kToleranceBounds_m, reader, &term->tolerance_m);
  const json* value = reader->Required("value", reader->Take("value"), "where the joint shall be, [x, y, z] in metres");
  if (!value) return;
  constexpr const char* kForm = "three numbers, [x, y, z] in metres, null for one that does not count";
  if (!value->is_array() || value->size() != 3) {
    reader->findings()->Malformed(reader->At("value"), std::string("must be ") + kForm);
    return;
  }
  json counted = *value;
  for (std::size_t i = 0; i < 3; ++i) {
    term->use[i] = !counted[i].is_null();
    if (!term->use[i]) counted[i] = 0;
  }
  if (!term->use[0] && !term->use[1] && !term->use[2]) {
    reader->findings()->Malformed(reader->At("value"), "at least one coordinate must be a number");
    return;
  }
  ReadCoordinates(counted, reader->At("value"), 3, kForm, reader->findings(), term->value_m.data());
}

void ReadOrientation(ObjectReader* reader, OrientationTerm* term) {
  ReadJoint(reader, &term->joint);
  ReadMoment(reader, &term->at);
  ReadDegreesTolerance(reader, &term->tolerance_rad);
  const json* value = reader->Required("value", reader->Take("value"), "a unit quaternion, [w, x, y, z]");
  if (!value) return;
  Eigen::Vector4d wxyz;
  if (!ReadCoordinates(*value, reader->At("value"), 4, "a unit quaternion, [w, x, y, z]", reader->findings(), wxyz.data())) return;
  if (!(std::abs(wxyz.norm() - 1) <= 0.01)) {
    reader->findings()->Malformed(reader->At("value"), "must be a unit quaternion; this one has length " + NumberText(wxyz.norm()));
    return;
  }
  // Left alone where it is normal already, so that its canonical form reads back the same.
  if (std::abs(wxyz.squaredNorm() - 1) > 1e-14) wxyz.normalize();
  term->value = Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
}

void ReadTrajectory(ObjectReader* reader, TrajectoryTerm* term) {
  ReadJoint(reader, &term->joint);
  ReadTolerance("tolerance", kToleranceBounds_m, reader, &term->tolerance_m);
  const json* points =
      reader->Required("points", reader->List("points", 1, kMaxTrajectoryPoints, "points"), "[[time, x, y, z], …] in s and metres");
  Findings* findings = reader->findings();
  for (std::size_t i = 0; points && i < points->size() && !findings->full(); ++i) {
    const std::string pointer = reader->At("points") + "/" + std::to_string(i);
    double numbers[4];
    if (!ReadCoordinates((*points)[i], pointer, 4, "four numbers, [time in seconds, x, y, z in metres]", findings, numbers)) continue;
    const auto time_s = ReadTime((*points)[i][0], pointer + "/0", findings);
    if (time_s && !term->times_s.empty() && !(*time_s > term->times_s.back())) findings->Malformed(pointer + "/0", "times must rise");
    term->times_s.push_back(time_s.value_or(0));
    term->points_m.emplace_back(numbers[1], numbers[2], numbers[3]);
  }
}

void ReadHeading(ObjectReader* reader, HeadingTerm* term) {
  ReadMoment(reader, &term->at);
  ReadDegreesTolerance(reader, &term->tolerance_rad);
  if (const auto value = reader->Required("value", ReadAngle("value", reader), "degrees; 0 faces +Z, 90 faces +X")) term->value_rad = *value;
}

void ReadFootstep(ObjectReader* reader, FootstepTerm* term) {
  if (const auto foot = reader->Required("foot", reader->Text("foot"), "\"left\" or \"right\"")) {
    term->left = *foot == "left";
    if (!term->left && *foot != "right") reader->findings()->Malformed(reader->At("foot"), "must be \"left\" or \"right\"");
  }
  if (const auto index = reader->Required("index", reader->Whole("index", 0, kMaxSteps), "which of the foot's contacts, from 0"))
    term->index = *index;
  if (const auto value = reader->Required("value", reader->FloorPoint("value"), "where the foot is put, [x, z] in metres")) term->value_m = *value;
  ReadTolerance("tolerance", kToleranceBounds_m, reader, &term->tolerance_m);
}

void ReadCircle(const json& object, ObjectReader* reader, KeepOutTerm* term) {
  ObjectReader circle(object, reader->At("circle"), reader->findings());
  if (const auto center = circle.Required("center", circle.FloorPoint("center"), "[x, z] in metres")) term->center_m = *center;
  const auto radius = circle.Required("radius", circle.Finite("radius"), "metres");
  if (radius && !(*radius > 0)) {
    reader->findings()->Malformed(circle.At("radius"), "must be above 0 m");
  } else if (radius && *radius > kMaxStartDistance_m) {
    reader->findings()->Unmeetable(circle.At("radius"), "at most " + NumberText(kMaxStartDistance_m) + " m");
  }
  term->radius_m = radius.value_or(1);
  circle.RefuseOthers();
}

void ReadKeepOut(ObjectReader* reader, KeepOutTerm* term) {
  const json* circle = reader->Object("circle");
  const json* polygon = reader->List("polygon", 3, kMaxPolygonCorners, "corners");
  Findings* findings = reader->findings();
  if (reader->Has("circle") && reader->Has("polygon")) {
    findings->Malformed(reader->At("polygon"), "give either \"circle\" or \"polygon\"");
  } else if (!reader->Has("circle") && !reader->Has("polygon")) {
    findings->Malformed(reader->pointer(), "required: \"circle\" or \"polygon\"");
  }
  if (circle) ReadCircle(*circle, reader, term);
  for (std::size_t i = 0; polygon && i < polygon->size() && !findings->full(); ++i) {
    ReadCoordinates((*polygon)[i], reader->At("polygon") + "/" + std::to_string(i), 2, "two numbers, [x, z] in metres", findings,
                    term->polygon_m.emplace_back().data());
  }
  // Some writers close a polygon by repeating its first corner.
  if (term->polygon_m.size() > 3 && term->polygon_m.front() == term->polygon_m.back()) term->polygon_m.pop_back();
}

void ReadLookAt(ObjectReader* reader, LookAtTerm* term) {
  const auto from = reader->Required("from", ReadTime("from", reader), "seconds");
  const auto to = reader->Required("to", ReadTime("to", reader), "seconds");
  if (from && to && !(*from < *to)) reader->findings()->Malformed(reader->At("to"), "must be later than \"from\"");
  term->from_s = from.value_or(0);
  term->to_s = to.value_or(0);
  if (const auto value = reader->Required("value", reader->SpacePoint("value"), "what is looked at, [x, y, z] in metres"))
    term->value_m = *value;
  ReadDegreesTolerance(reader, &term->tolerance_rad);
}

void ReadPose(ObjectReader* reader, PoseTerm* term) {
  ReadMoment(reader, &term->at);
  ReadTolerance("tolerance", kToleranceBounds_m, reader, &term->tolerance_m);
  const json* joints = reader->Required("joints", reader->Object("joints"), "{\"left_wrist\": [x, y, z], …} in the pelvis's frame");
  if (!joints) return;
  Findings* findings = reader->findings();
  if (joints->empty()) findings->Malformed(reader->At("joints"), "must name at least one joint");
  if (joints->size() > kMaxPoseJoints) {
    findings->Unmeetable(reader->At("joints"), "at most " + std::to_string(kMaxPoseJoints) + " joints");
    return;
  }
  for (const auto& [joint, value] : joints->items()) {
    if (findings->full()) return;
    const std::string pointer = PointerTo(reader->At("joints"), joint);
    if (joint.empty() || joint.size() > 200) findings->Malformed(pointer, "a joint's name has 1 to 200 bytes");
    term->joints.push_back(joint);
    ReadCoordinates(value, pointer, 3, "three numbers, [x, y, z] in metres", findings, term->values_m.emplace_back().data());
  }
}

template <typename Term, void (*Read)(ObjectReader*, Term*)>
void ReadAs(ObjectReader* reader, Constraint* constraint) {
  Read(reader, &constraint->emplace<Term>());
}

struct ConstraintType {
  std::string_view name;
  void (*read)(ObjectReader*, Constraint*);
};

constexpr std::array<ConstraintType, 8> kConstraintTypes = {{
    {"position", ReadAs<PositionTerm, ReadPosition>},
    {"orientation", ReadAs<OrientationTerm, ReadOrientation>},
    {"trajectory", ReadAs<TrajectoryTerm, ReadTrajectory>},
    {"heading", ReadAs<HeadingTerm, ReadHeading>},
    {"footstep", ReadAs<FootstepTerm, ReadFootstep>},
    {"keep_out", ReadAs<KeepOutTerm, ReadKeepOut>},
    {"look_at", ReadAs<LookAtTerm, ReadLookAt>},
    {"pose", ReadAs<PoseTerm, ReadPose>},
}};

}  // namespace

bool ReadConstraint(std::string_view type, ObjectReader* reader, Constraint* constraint) {
  for (const ConstraintType& known : kConstraintTypes) {
    if (known.name != type) continue;
    known.read(reader, constraint);
    return true;
  }
  return false;
}

std::string ConstraintTypes() {
  std::string names;
  for (const ConstraintType& type : kConstraintTypes) names += (names.empty() ? "" : ", ") + std::string(type.name);
  return names;
}

}  // namespace morphograph
