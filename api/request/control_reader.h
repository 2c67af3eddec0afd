#pragma once

#include "api/request/object_reader.h"
#include "synthesis/control/control_terms.h"

namespace morphograph {

inline constexpr std::size_t kMaxPathPoints = 1000;
inline constexpr std::size_t kMaxConstraints = 200;
inline constexpr std::size_t kMaxTrajectoryPoints = 1000;
inline constexpr std::size_t kMaxPolygonCorners = 200;
inline constexpr std::size_t kMaxPoseJoints = 100;
inline constexpr double kMaxSpeed_m_s = 12;  // nobody runs faster

/// Reads "path", "goal", "speed" and "constraints" of a clip request: every number bounded, every error with its pointer. A constraint that
/// is wrong takes its place in the list all the same, so that indices keep their meaning.
void ReadControlTerms(ObjectReader* request, ControlTerms* terms);

/// The fields of one constraint but for "type", which the reader has taken.
/// @return false when the type is unknown.
bool ReadConstraint(std::string_view type, ObjectReader* reader, Constraint* constraint);
/// The types that there are, for a message.
std::string ConstraintTypes();

// Pieces that both read.

/// A tolerance, which must be above 0; `*value` stays as it is where the field is absent.
void ReadTolerance(std::string_view name, const NumberBounds& bounds, ObjectReader* reader, double* value);
/// "weight": how much a term counts against others, above 0; `*weight` stays as it is where the field is absent.
void ReadWeight(ObjectReader* reader, double* weight);
inline constexpr NumberBounds kToleranceBounds_m{0.001, 1000, "m"};
inline constexpr NumberBounds kToleranceBounds_deg{0.1, 180, "degrees"};
inline constexpr NumberBounds kToleranceBounds_m_s{0.001, 100, "m/s"};

/// A time from the clip's start: 0 or more (400 below), no more than a clip may last (422).
std::optional<double> ReadTime(const nlohmann::json& value, const std::string& pointer, Findings* findings);
std::optional<double> ReadTime(std::string_view name, ObjectReader* reader);

/// Degrees in the request, radians here.
std::optional<double> ReadAngle(std::string_view name, ObjectReader* reader);

}  // namespace morphograph
