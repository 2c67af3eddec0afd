#include "api/request/control_checks.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "api/request/control_reader.h"
#include "synthesis/control/floor_area.h"
#include "synthesis/floor_polygon.h"
#include "synthesis/synthesis_types.h"

namespace morphograph {
namespace {

constexpr double kSameTime_s = 0.1;  // arrival times that say the same

double Rounded(double value) { return std::round(value * 1000) / 1000 + 0.0; }

std::string Shortened(double value) { return NumberText(Rounded(value)); }

std::string PlaceText(const Eigen::Vector2d& point_m) { return nlohmann::json({Rounded(point_m.x()), Rounded(point_m.y())}).dump(); }

std::string ConstraintPointer(std::size_t index) { return "/constraints/" + std::to_string(index); }

class ControlChecker {
 public:
  ControlChecker(const ControlTerms& terms, const ClipExtent& clip, Findings* findings)
      : terms_(terms), clip_(clip), findings_(findings) {
    if (clip.duration_s) {
      end_s_ = *clip.duration_s;
    } else if (terms.goal && terms.goal->time_s) {
      end_s_ = *terms.goal->time_s;
    }
  }

  void Run() {
    if (terms_.path) CheckPath(*terms_.path);
    if (terms_.goal) CheckGoal(*terms_.goal);
    if (terms_.speed) CheckSpeed(*terms_.speed);
    for (at_ = 0; at_ < terms_.constraints.size() && !findings_->full(); ++at_) {
      std::visit([this](const auto& term) { Check(term); }, terms_.constraints[at_]);
    }
    if (!findings_->any()) CheckPlaces();  // areas are known to be sound then
    CheckContradictions();
  }

 private:
  void CheckPath(const PathTerm& path) {
    const double length_m = LineLength(path.points_m);
    constexpr double kLongest_m = kMaxSpeed_m_s * kMaxDuration_s;
    if (path.points_m.size() < 2) {
      findings_->Unmeetable("/path/points", "the path has no length: all its points are one");
      return;
    }
    if (length_m > kLongest_m)
      findings_->Unmeetable("/path/points", "the path is " + Shortened(length_m) + " m long; at most " + Shortened(kLongest_m) + " m");
    if (clip_.start_m) {
      const double apart_m = (*clip_.start_m - path.points_m.front()).norm();
      if (apart_m > path.tolerance_m) {
        findings_->Unmeetable("/start/position", "the path begins at " + PlaceText(path.points_m.front()) + ", " + Shortened(apart_m) +
                                                     " m away; start there, leave the start out, or begin the path here");
      }
    }
    if (terms_.goal) {
      const double apart_m = (terms_.goal->position_m - path.points_m.back()).norm();
      if (apart_m > path.tolerance_m + terms_.goal->tolerance_m) {
        findings_->Unmeetable("/goal/position", "the path ends at " + PlaceText(path.points_m.back()) + ", " + Shortened(apart_m) +
                                                    " m away; put the goal there or lead the path here");
      }
    }
  }

  void CheckGoal(const GoalTerm& goal) {
    if (!goal.time_s || !clip_.duration_s || std::abs(*goal.time_s - *clip_.duration_s) <= kSameTime_s) return;
    findings_->Unmeetable("/goal/time", "the clip ends at the goal, after " + Shortened(*clip_.duration_s) + " s (\"duration\"); give one of them");
  }

  void CheckSpeed(const SpeedTerm& speed) {
    const bool moves = std::any_of(speed.profile.begin(), speed.profile.end(), [](const SpeedTerm::Knot& knot) { return knot.speed_m_s > 0; });
    if (!moves && (terms_.path || terms_.goal)) findings_->Unmeetable("/speed", "a way is not walked at 0 m/s; it must be above 0");
  }

  void CheckTime(const char* field, double time_s) {
    if (end_s_ && time_s > *end_s_)
      findings_->Unmeetable(ConstraintPointer(at_) + "/" + field, "the clip ends at " + Shortened(*end_s_) + " s; at most that");
  }

  void CheckMoment(const ControlMoment& moment) {
    if (moment.time_s) CheckTime("time", *moment.time_s);
    if (moment.keyframe && clip_.steps && *moment.keyframe > *clip_.steps) {
      findings_->Unmeetable(ConstraintPointer(at_) + "/keyframe",
                            "a clip of " + std::to_string(*clip_.steps) + " steps ends at key frame " + std::to_string(*clip_.steps));
    }
  }

  void Check(const PositionTerm& term) { CheckMoment(term.at); }
  void Check(const OrientationTerm& term) { CheckMoment(term.at); }
  void Check(const HeadingTerm& term) { CheckMoment(term.at); }
  void Check(const PoseTerm& term) { CheckMoment(term.at); }
  void Check(const LookAtTerm& term) { CheckTime("to", term.to_s); }
  void Check(const TrajectoryTerm& term) {
    const std::size_t last = term.times_s.size() - 1;
    CheckTime(("points/" + std::to_string(last) + "/0").c_str(), term.times_s[last]);
  }
  void Check(const FootstepTerm& term) {
    // Feet take turns, and either may stand at both ends of the clip.
    if (const int last = clip_.steps.value_or(0) / 2 + 1; clip_.steps && term.index > last) {
      findings_->Unmeetable(ConstraintPointer(at_) + "/index", "in " + std::to_string(*clip_.steps) + " steps a foot is put down " +
                                                                   std::to_string(last + 1) + " times at most: 0 to " + std::to_string(last));
    }
  }
  void Check(const KeepOutTerm& term) {
    if (term.polygon_m.empty()) return;
    const std::string pointer = ConstraintPointer(at_) + "/polygon";
    if (!IsSimplePolygon(term.polygon_m)) {
      findings_->Unmeetable(pointer, "its outline crosses or touches itself; it must enclose one area");
    } else if (PolygonArea(term.polygon_m) < 1e-6) {
      findings_->Unmeetable(pointer, "it encloses no area");
    }
  }

  // Places where the body is asked to be, against areas that it is kept out of.
  void CheckPlaces() {
    for (std::size_t i = 0; i < terms_.constraints.size() && !findings_->full(); ++i) {
      const auto* area = std::get_if<KeepOutTerm>(&terms_.constraints[i]);
      if (!area) continue;
      const auto check = [&](const std::string& pointer, const Eigen::Vector2d& place_m, double tolerance_m) {
        const double depth_m = DepthInside(*area, place_m);
        if (depth_m <= tolerance_m) return;
        findings_->Unmeetable(pointer, "lies " + Shortened(depth_m) + " m inside of " + ConstraintPointer(i) +
                                           ", which is kept out of; it must move at least so far");
      };
      if (clip_.start_m) check("/start/position", *clip_.start_m, 0);
      if (terms_.goal) check("/goal/position", terms_.goal->position_m, terms_.goal->tolerance_m);
      if (const auto& path = terms_.path) {
        if (!clip_.start_m) check("/path/points/0", path->points_m.front(), path->tolerance_m);
        if (!terms_.goal) check("/path/points/" + std::to_string(path->points_m.size() - 1), path->points_m.back(), path->tolerance_m);
      }
      for (std::size_t k = 0; k < terms_.constraints.size(); ++k) {
        if (const auto* step = std::get_if<FootstepTerm>(&terms_.constraints[k]))
          check(ConstraintPointer(k) + "/value", step->value_m, step->tolerance_m);
      }
    }
  }

  // Two places for one thing at one moment.
  void CheckContradictions() {
    const auto same = [](const ControlMoment& a, const ControlMoment& b) { return a.time_s == b.time_s && a.keyframe == b.keyframe; };
    for (std::size_t k = 1; k < terms_.constraints.size() && !findings_->full(); ++k) {
      for (std::size_t i = 0; i < k; ++i) {
        const Constraint &one = terms_.constraints[i], &two = terms_.constraints[k];
        if (one.index() != two.index()) continue;
        double apart = 0, allowed = 0;
        if (const auto* a = std::get_if<PositionTerm>(&one)) {
          const auto& b = std::get<PositionTerm>(two);
          if (a->joint != b.joint || !same(a->at, b.at)) continue;
          Eigen::Vector3d difference = a->value_m - b.value_m;
          for (int axis = 0; axis < 3; ++axis) {
            if (!a->use[axis] || !b.use[axis]) difference[axis] = 0;
          }
          apart = difference.norm(), allowed = a->tolerance_m + b.tolerance_m;
        } else if (const auto* step = std::get_if<FootstepTerm>(&one)) {
          const auto& b = std::get<FootstepTerm>(two);
          if (step->left != b.left || step->index != b.index) continue;
          apart = (step->value_m - b.value_m).norm(), allowed = step->tolerance_m + b.tolerance_m;
        } else if (const auto* heading = std::get_if<HeadingTerm>(&one)) {
          const auto& b = std::get<HeadingTerm>(two);
          if (!same(heading->at, b.at)) continue;
          apart = std::abs(std::remainder(heading->value_rad - b.value_rad, 2 * EIGEN_PI)), allowed = heading->tolerance_rad + b.tolerance_rad;
        }
        if (apart > allowed) {
          findings_->Unmeetable(ConstraintPointer(k) + "/value", "contradicts " + ConstraintPointer(i) + ", which asks for something else of the same at the same moment");
          break;
        }
      }
    }
  }

  const ControlTerms& terms_;
  const ClipExtent& clip_;
  Findings* findings_;
  std::optional<double> end_s_;
  std::size_t at_ = 0;  // the constraint being checked
};

}  // namespace

double LineLength(const std::vector<Eigen::Vector2d>& points_m) {
  double length_m = 0;
  for (std::size_t i = 1; i < points_m.size(); ++i) length_m += (points_m[i] - points_m[i - 1]).norm();
  return length_m;
}

void CheckControlTerms(const ControlTerms& terms, const ClipExtent& clip, Findings* findings) { ControlChecker(terms, clip, findings).Run(); }

}  // namespace morphograph
