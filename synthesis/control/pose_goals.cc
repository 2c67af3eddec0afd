#include "synthesis/control/pose_goals.h"

#include <algorithm>
#include <cmath>

#include "primitives/rotation_math.h"
#include "synthesis/control/pose_layer.h"

namespace morphograph {
namespace {

constexpr int kSweeps = 4;

class Goals {
 public:
  Goals(const ControlProblem& problem, const std::vector<double>& keyframe_times_s, MotionClip* clip)
      : problem_(problem), times_(keyframe_times_s), before_(*clip), clip_(*clip) {}

  int Apply() {
    const auto& constraints = problem_.request.control.constraints;
    // What one goal does eases into the frames of the next: once more, so that neither order nor nearness decides.
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      for (size_t i = 0; i < constraints.size(); ++i) {
        std::visit([&](const auto& term) { Of(term, problem_.joints[i]); }, constraints[i]);
      }
      if (goals_ <= 1) break;
      goals_ = 0;
    }
    return poses_;
  }

 private:
  int Frame(const ControlMoment& at) const { return FrameOf(at, times_, {clip_, {}}); }
  int Frame(double time_s) const { return MeasuredClip{clip_, {}}.FrameAt(time_s); }

  void Apply(const PoseGoal& goal) {
    poses_ += ApplyPoseGoal(goal, before_, &clip_);
    ++goals_;
  }

  void Point(const ResolvedJoint& joint, int frame, const std::function<Eigen::Vector3d(int, const WorldPose&)>& position) {
    if (joint.finishes) Apply({joint.joint, frame, frame, position, nullptr});
  }

  void Of(const PositionTerm& term, const std::vector<ResolvedJoint>& joints) {
    Point(joints[0], Frame(term.at), [&](int, const WorldPose& pose) {
      Eigen::Vector3d target = pose.positions.col(joints[0].joint);
      for (int axis = 0; axis < 3; ++axis) {
        if (term.use[axis]) target[axis] = term.value_m[axis];
      }
      return target;
    });
  }

  void Of(const TrajectoryTerm& term, const std::vector<ResolvedJoint>& joints) {
    if (!joints[0].finishes || term.times_s.empty()) return;
    const double rate = clip_.frame_rate_hz();
    const auto along = [&](int frame, const WorldPose&) -> Eigen::Vector3d {
      const double time = frame / rate;
      size_t k = 0;
      while (k + 1 < term.times_s.size() && term.times_s[k + 1] < time) ++k;
      if (k + 1 == term.times_s.size()) return term.points_m[k];
      const double t = std::clamp((time - term.times_s[k]) / (term.times_s[k + 1] - term.times_s[k]), 0.0, 1.0);
      return term.points_m[k] + t * (term.points_m[k + 1] - term.points_m[k]);
    };
    Apply({joints[0].joint, Frame(term.times_s.front()), Frame(term.times_s.back()), along, nullptr});
  }

  void Of(const PoseTerm& term, const std::vector<ResolvedJoint>& joints) {
    const int frame = Frame(term.at);
    const Eigen::AngleAxisd turn(HeadingRad(clip_, frame), Eigen::Vector3d::UnitY());
    const Eigen::Vector3d root(clip_.root_positions()(0, frame), 0, clip_.root_positions()(2, frame));
    for (size_t k = 0; k < joints.size(); ++k) {
      const Eigen::Vector3d target = turn * term.values_m[k] + root;
      Point(joints[k], frame, [target](int, const WorldPose&) { return target; });
    }
  }

  void Of(const OrientationTerm& term, const std::vector<ResolvedJoint>& joints) {
    if (!joints[0].finishes) return;
    const int frame = Frame(term.at);
    const auto turn = [&](int, const WorldPose& pose) {
      return LogMap(term.value * pose.rotations[static_cast<size_t>(joints[0].joint)].conjugate());
    };
    Apply({joints[0].joint, frame, frame, nullptr, turn});
  }

  void Of(const LookAtTerm& term, const std::vector<ResolvedJoint>&) {
    if (!problem_.head.finishes) return;
    const auto turn = [&](int, const WorldPose& pose) -> Eigen::Vector3d {
      const Eigen::Vector3d facing = pose.rotations[static_cast<size_t>(problem_.head.joint)] * problem_.head_forward;
      const Eigen::Vector3d wanted = (term.value_m - pose.positions.col(problem_.head.joint)).normalized();
      return LogMap(Eigen::Quaterniond::FromTwoVectors(facing, wanted));
    };
    Apply({problem_.head.joint, Frame(term.from_s), Frame(term.to_s), nullptr, turn, problem_.graph.styles()[static_cast<size_t>(problem_.style)].mean_rotations});
  }

  void Of(const HeadingTerm&, const std::vector<ResolvedJoint>&) {}
  void Of(const FootstepTerm&, const std::vector<ResolvedJoint>&) {}
  void Of(const KeepOutTerm&, const std::vector<ResolvedJoint>&) {}

  const ControlProblem& problem_;
  const std::vector<double>& times_;
  const MotionClip before_;
  MotionClip& clip_;
  int goals_ = 0;  // of a sweep
  int poses_ = 0;
};

}  // namespace

int ApplyPoseGoals(const ControlProblem& problem, const std::vector<double>& keyframe_times_s, MotionClip* clip) {
  return Goals(problem, keyframe_times_s, clip).Apply();
}

}  // namespace morphograph
