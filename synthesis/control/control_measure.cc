#include "synthesis/control/control_measure.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "datasets/virtual_sensors.h"
#include "synthesis/control/floor_area.h"

namespace morphograph {
namespace {

// Readings at kSensorRate_hz as they would be at a lower rate: averaged under a triangle of half width 1 / rate, as the second difference of positions at that rate
// averages the accelerations at a higher one.
Eigen::MatrixXd AtLowerRate(const Eigen::MatrixXd& readings, double rate_hz) {
  const double ratio = kSensorRate_hz / rate_hz;
  const auto samples = static_cast<Eigen::Index>(static_cast<double>(readings.cols() - 1) / ratio + 1e-9) + 1;
  Eigen::MatrixXd averaged = Eigen::MatrixXd::Zero(readings.rows(), samples);
  for (Eigen::Index n = 0; n < samples; ++n) {
    const double at = static_cast<double>(n) * ratio;
    double sum = 0;
    for (auto i = std::max<Eigen::Index>(0, static_cast<Eigen::Index>(std::ceil(at - ratio))); i < readings.cols() && static_cast<double>(i) < at + ratio; ++i) {
      const double weight = 1 - std::abs(static_cast<double>(i) - at) / ratio;
      averaged.col(n) += weight * readings.col(i);
      sum += weight;
    }
    averaged.col(n) /= sum;
  }
  return averaged;
}

double Apart(double a, double b) { return std::abs(std::remainder(a - b, 2 * M_PI)); }

class Measurer {
 public:
  Measurer(const ControlProblem& problem, const std::vector<double>& keyframe_times_s, const MeasuredClip& clip)
      : problem_(problem), times_(keyframe_times_s), measured_(clip) {}

  std::vector<ControlOutcome> All() {
    const ControlTerms& control = problem_.request.control;
    const int last = measured_.clip.frame_count() - 1;
    if (control.path) Add("/path", PathMiss(), control.path->tolerance_m, "m", true);
    if (control.goal) {
      Add("/goal", (measured_.RootAt(last) - control.goal->position_m).norm(), control.goal->tolerance_m, "m", false, List(measured_.RootAt(last)));
      if (control.goal->heading_rad)
        Add("/goal/heading", Apart(measured_.HeadingAt(last), *control.goal->heading_rad), control.goal->heading_tolerance_rad, "rad", false,
            {measured_.HeadingAt(last)});
      if (control.goal->time_s) Add("/goal/time", std::abs(last / measured_.clip.frame_rate_hz() - *control.goal->time_s), kTimeTolerance_s, "s", false,
            {last / measured_.clip.frame_rate_hz()});
    } else if (control.path) {
      Add("/path/points/" + std::to_string(control.path->points_m.size() - 1), (measured_.RootAt(last) - *problem_.goal_m).norm(), control.path->tolerance_m, "m", false, List(measured_.RootAt(last)));
    }
    if (problem_.request.duration_s && problem_.guide.to != WalkBoundary::kWalking)
      Add("/duration", std::abs(measured_.clip.duration_s() - *problem_.request.duration_s), kTimeTolerance_s, "s", false, {measured_.clip.duration_s()});
    if (control.speed) Add("/speed", SpeedMiss(*control.speed), control.speed->tolerance_m_s, "m/s", true);
    if (control.sensors) Add("/sensors", SensorMiss(), control.sensors->tolerance_m_s2.value_or(std::numeric_limits<double>::infinity()), "m/s2", true);
    for (size_t i = 0; i < control.constraints.size(); ++i) {
      index_ = static_cast<int>(i);
      std::visit([&](const auto& term) { Of(term); }, control.constraints[i]);
    }
    return std::move(outcomes_);
  }

 private:
  static constexpr double kTimeTolerance_s = 0.1;
  static constexpr double kBack_m = 0.3, kAhead_m = 0.3;  // of the place on a path that the frame before was nearest to

  using Values = std::vector<double>;
  static Values List(const Eigen::Vector2d& v) { return {v.x(), v.y()}; }
  static Values List(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

  void Add(std::string pointer, double residual, double tolerance, const char* unit, bool is_mean = false, Values reached = {}) {
    outcomes_.push_back({std::move(pointer), index_, residual <= tolerance, residual, tolerance, unit, is_mean, std::move(reached)});
  }
  void AddConstraint(double residual, double tolerance, const char* unit, bool is_mean = false, Values reached = {}) {
    Add("/constraints/" + std::to_string(*index_), residual, tolerance, unit, is_mean, std::move(reached));
  }

  // Frames go along the path as the body does: a loop or a spike that the walk left out counts as a miss, however near its ends are.
  double PathMiss() const {
    std::vector<double> distances;
    double along = 0;
    for (int f = 0; f < measured_.clip.frame_count(); ++f) {
      const double moved = f > 0 ? (measured_.RootAt(f) - measured_.RootAt(f - 1)).norm() : 0;
      const FloorPath::Nearest nearest = problem_.guide.path->NearestTo(measured_.RootAt(f), along - kBack_m, along + kAhead_m + 2 * moved);
      along = nearest.along_m;
      distances.push_back(nearest.distance_m);
    }
    const auto at = distances.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(distances.size() - 1));
    std::nth_element(distances.begin(), at, distances.end());
    return *at;
  }

  double SpeedMiss(const SpeedTerm& term) const {
    double sum = 0;
    int steps = 0;
    for (size_t k = 0; k + 1 < times_.size(); ++k) {
      // The last step may be cut off by the clip's end.
      const int from = measured_.FrameAt(times_[k]), to = measured_.FrameAt(times_[k + 1]);
      if (from >= to) continue;
      const double speed = (measured_.RootAt(to) - measured_.RootAt(from)).norm() * measured_.clip.frame_rate_hz() / (to - from);
      sum += std::abs(speed - SpeedAt(term.profile, (times_[k] + times_[k + 1]) / 2));
      ++steps;
    }
    return steps > 0 ? sum / steps : std::numeric_limits<double>::infinity();
  }

  // Of all readings but the first and the last, whose second differences would take a sample outside. Where a clip has fewer frames than that, at its own rate:
  // between them it says nothing of accelerations.
  double SensorMiss() const {
    const bool is_slow = measured_.clip.frame_rate_hz() < kSensorRate_hz;
    const double rate_hz = is_slow ? measured_.clip.frame_rate_hz() : kSensorRate_hz;
    if (problem_.sensors->readings.cols() < 3) return 0;
    const Eigen::MatrixXd wanted = is_slow ? AtLowerRate(problem_.sensors->readings, rate_hz) : problem_.sensors->readings;
    const Eigen::Index samples = std::min<Eigen::Index>(wanted.cols(), static_cast<Eigen::Index>(measured_.clip.duration_s() * rate_hz + 1e-6) + 1);
    if (samples < 3) return 0;
    const Eigen::MatrixXd there = VirtualAccelerations(measured_.clip, problem_.sensors->placements, rate_hz).values;
    const Eigen::Index inner = std::min(samples, there.cols()) - 2;
    return std::sqrt((there.middleCols(1, inner) - wanted.middleCols(1, inner)).squaredNorm() / static_cast<double>(inner * wanted.rows()));
  }

  const WorldPose& PoseAt(int frame) {
    if (poses_.empty()) poses_ = WorldPoses(measured_.clip);
    return poses_[static_cast<size_t>(frame)];
  }

  void Of(const PositionTerm& term) {
    const Eigen::Vector3d there = PoseAt(FrameOf(term.at, times_, measured_)).positions.col(problem_.joints[static_cast<size_t>(*index_)][0].joint);
    Eigen::Vector3d miss = there - term.value_m;
    for (int axis = 0; axis < 3; ++axis) miss[axis] *= term.use[axis];
    AddConstraint(miss.norm(), term.tolerance_m, "m", false, List(there));
  }

  void Of(const OrientationTerm& term) {
    const Eigen::Quaterniond there = PoseAt(FrameOf(term.at, times_, measured_)).rotations[static_cast<size_t>(problem_.joints[static_cast<size_t>(*index_)][0].joint)];
    AddConstraint(there.angularDistance(term.value), term.tolerance_rad, "rad", false, {there.w(), there.x(), there.y(), there.z()});
  }

  void Of(const TrajectoryTerm& term) {
    double worst = 0;
    for (size_t k = 0; k < term.times_s.size(); ++k) {
      const Eigen::Vector3d there = PoseAt(measured_.FrameAt(term.times_s[k])).positions.col(problem_.joints[static_cast<size_t>(*index_)][0].joint);
      worst = std::max(worst, (there - term.points_m[k]).norm());
    }
    AddConstraint(worst, term.tolerance_m, "m");
  }

  void Of(const HeadingTerm& term) {
    const double there = measured_.HeadingAt(FrameOf(term.at, times_, measured_));
    AddConstraint(Apart(there, term.value_rad), term.tolerance_rad, "rad", false, {there});
  }

  void Of(const FootstepTerm& term) {
    const PlantedFoot* foot = FootstepOf(term, measured_.contacts);
    if (!foot) return AddConstraint(std::numeric_limits<double>::infinity(), term.tolerance_m, "m");
    AddConstraint((foot->position_m - term.value_m).norm(), term.tolerance_m, "m", false, List(foot->position_m));
  }

  // How deep a point comes that goes straight from one place to another.
  static double Deepest(const FloorArea& area, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    constexpr double kSpacing_m = 0.01;
    const double way = (to - from).norm();
    double deepest = std::max(area.Depth(from), area.Depth(to));
    if (deepest > -way) {
      const int pieces = static_cast<int>(std::ceil(way / kSpacing_m));
      for (int i = 1; i < pieces; ++i) deepest = std::max(deepest, area.Depth(from + (to - from) * i / pieces));
    }
    return deepest;
  }

  void Of(const KeepOutTerm& term) {
    // Between the frames of a slow film points do not go straight.
    const bool between = measured_.clip.frame_rate_hz() >= 10;
    double deepest = 0;
    const FloorArea area(term);
    std::vector<Eigen::Vector2d> before;
    for (int f = 0; f < measured_.clip.frame_count(); ++f) {
      const WorldPose& pose = PoseAt(f);
      std::vector<Eigen::Vector2d> now;
      const auto look = [&](const Eigen::Vector3d& point) { now.emplace_back(point.x(), point.z()); };
      look(pose.positions.col(measured_.clip.skeleton().moving_root()));
      for (int side = 0; side < 2; ++side) {
        look(pose.positions.col(problem_.ball[side].joint));
        look(pose.positions.col(problem_.heel[side].joint));
        look(pose.positions.col(problem_.ball[side].joint) + pose.rotations[static_cast<size_t>(problem_.ball[side].joint)] * problem_.toes_m[side]);
      }
      for (size_t k = 0; k < now.size(); ++k) deepest = std::max(deepest, between && f > 0 ? Deepest(area, before[k], now[k]) : area.Depth(now[k]));
      before = std::move(now);
    }
    AddConstraint(deepest, 0, "m");
  }

  void Of(const LookAtTerm& term) {
    double sum = 0;
    const int from = measured_.FrameAt(term.from_s), to = std::max(from, measured_.FrameAt(term.to_s));
    for (int f = from; f <= to; ++f) {
      const WorldPose& pose = PoseAt(f);
      const Eigen::Vector3d facing = pose.rotations[static_cast<size_t>(problem_.head.joint)] * problem_.head_forward;
      const Eigen::Vector3d wanted = (term.value_m - pose.positions.col(problem_.head.joint)).normalized();
      sum += std::acos(std::clamp(facing.dot(wanted), -1.0, 1.0));
    }
    AddConstraint(sum / (to - from + 1), term.tolerance_rad, "rad", true);
  }

  void Of(const PoseTerm& term) {
    const int frame = FrameOf(term.at, times_, measured_);
    const WorldPose& pose = PoseAt(frame);
    const Eigen::Vector2d root = measured_.RootAt(frame);
    const Eigen::AngleAxisd turn(measured_.HeadingAt(frame), Eigen::Vector3d::UnitY());
    double sum = 0;
    for (size_t k = 0; k < term.joints.size(); ++k) {
      const Eigen::Vector3d wanted = turn * term.values_m[k] + Eigen::Vector3d(root.x(), 0, root.y());
      sum += (pose.positions.col(problem_.joints[static_cast<size_t>(*index_)][k].joint) - wanted).squaredNorm();
    }
    AddConstraint(std::sqrt(sum / static_cast<double>(std::max<size_t>(1, term.joints.size()))), term.tolerance_m, "m");
  }

  const ControlProblem& problem_;
  const std::vector<double>& times_;
  const MeasuredClip& measured_;
  std::vector<WorldPose> poses_;  // of all frames, once they are asked for
  std::optional<int> index_;
  std::vector<ControlOutcome> outcomes_;
};

}  // namespace

int MeasuredClip::FrameAt(double time_s) const {
  return std::clamp(static_cast<int>(std::lround(time_s * clip.frame_rate_hz())), 0, clip.frame_count() - 1);
}

Eigen::Vector2d MeasuredClip::RootAt(int frame) const { return {clip.root_positions()(0, frame), clip.root_positions()(2, frame)}; }

double MeasuredClip::HeadingAt(int frame) const { return HeadingRad(clip, frame); }

int FrameOf(const ControlMoment& moment, const std::vector<double>& keyframe_times_s, const MeasuredClip& clip) {
  if (moment.time_s) return clip.FrameAt(*moment.time_s);
  const auto keyframe = static_cast<size_t>(std::clamp(*moment.keyframe, 0, static_cast<int>(keyframe_times_s.size()) - 1));
  return clip.FrameAt(keyframe_times_s[keyframe]);
}

const PlantedFoot* FootstepOf(const FootstepTerm& term, const std::vector<PlantedFoot>& contacts) {
  int left = term.index;
  for (const PlantedFoot& foot : contacts) {
    if ((foot.interval.foot == Foot::kLeft) != term.left) continue;
    if (left-- == 0) return &foot;
  }
  return nullptr;
}

std::vector<ControlOutcome> MeasureControls(const ControlProblem& problem, const std::vector<double>& keyframe_times_s, const MeasuredClip& clip) {
  return Measurer(problem, keyframe_times_s, clip).All();
}

}  // namespace morphograph
