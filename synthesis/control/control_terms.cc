#include "synthesis/control/control_terms.h"

#include <type_traits>

namespace morphograph {
namespace {

using Problem = std::optional<std::pair<std::string, std::string>>;

// Of a constraint: the field below it, and the reason.
struct FormOf {
  Problem Moment(const ControlMoment& at) const {
    if (at.time_s.has_value() == at.keyframe.has_value()) return Problem({"", "needs either a time or a key frame"});
    return std::nullopt;
  }
  Problem operator()(const PositionTerm& term) const { return Moment(term.at); }
  Problem operator()(const OrientationTerm& term) const { return Moment(term.at); }
  Problem operator()(const HeadingTerm& term) const { return Moment(term.at); }
  Problem operator()(const PoseTerm& term) const {
    if (term.joints.empty() || term.joints.size() != term.values_m.size()) return Problem({"/joints", "needs a value for each of one or more joints"});
    return Moment(term.at);
  }
  Problem operator()(const TrajectoryTerm& term) const {
    if (term.times_s.empty() || term.times_s.size() != term.points_m.size()) return Problem({"/points", "needs a time for each of one or more points"});
    for (size_t k = 1; k < term.times_s.size(); ++k) {
      if (!(term.times_s[k] > term.times_s[k - 1])) return Problem({"/points", "times must rise"});
    }
    return std::nullopt;
  }
  Problem operator()(const FootstepTerm& term) const {
    return term.index < 0 ? Problem({"/index", "must be 0 or more"}) : std::nullopt;
  }
  Problem operator()(const KeepOutTerm& term) const {
    if (!term.polygon_m.empty() && term.polygon_m.size() < 3) return Problem({"/polygon", "needs three corners"});
    return std::nullopt;
  }
  Problem operator()(const LookAtTerm& term) const {
    return term.to_s < term.from_s ? Problem({"/to", "must not be before \"from\""}) : std::nullopt;
  }
};

}  // namespace

Problem ControlTerms::FirstProblem() const {
  if (path && path->points_m.size() < 2) return Problem({"/path/points", "needs two points"});
  if (speed && speed->profile.empty()) return Problem({"/speed", "needs a value"});
  if (sensors && (sensors->readings.names.size() != sensors->placements.size() || sensors->readings.values.rows() != 3 * static_cast<Eigen::Index>(sensors->placements.size())))
    return Problem({"/sensors/placements", "must be as many as the sensors of the readings"});
  for (size_t i = 0; i < constraints.size(); ++i) {
    if (const Problem problem = std::visit(FormOf(), constraints[i])) return Problem({"/constraints/" + std::to_string(i) + problem->first, problem->second});
  }
  return std::nullopt;
}

}  // namespace morphograph
