#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "datasets/forward_kinematics.h"
#include "datasets/motion_clip.h"
#include "datasets/placements.h"

namespace morphograph {

/// Channels of a pose as methods that look motion up know it, whatever way the body faces and wherever it stands. Rotation vectors (rad) are about the
/// base's mean rotation of each joint; the moving root's is of its rotation with the heading taken out (its tilt).
struct BasePose {
  Eigen::VectorXd rotations;  // (3 * active joints), the moving root first
  /// How the body came here from the frame before, seen from that frame's heading: metres to the left and forwards, and the turn (rad, positive turns
  /// forwards to the left, as HeadingRad counts).
  Eigen::Vector3d step = Eigen::Vector3d::Zero();
  double height_m = 0;  // of the moving root
};

struct MotionBaseOptions {
  double frame_rate_hz = 30;
  bool mirrored = true;        // a mirrored copy of every clip as well
  bool time_reversed = false;  // and all of it backwards
  std::vector<double> tempos = {};  // more copies, this many times as fast
  int jobs = 1;
};

/// Recordings frame by frame, as reconstruction from sensors looks them up (Tautges 3, "knowledge base"): poses, joint positions, and what virtual
/// sensors on the body would read. One skeleton, one frame rate. Immutable; single precision, 0.6 kB a frame at 22 joints.
class MotionBase {
 public:
  /// @param clips  on one skeleton. Of other rates they are resampled; those shorter than 5 frames are left out.
  /// @throws std::invalid_argument for no usable clip, clips on different skeletons, a joint of `sensors` that does not exist.
  MotionBase(const std::vector<MotionClip>& clips, std::vector<Placement> sensors, const MotionBaseOptions& options);

  const Skeleton& skeleton() const { return *skeleton_; }
  const std::shared_ptr<const Skeleton>& shared_skeleton() const { return skeleton_; }
  double frame_rate_hz() const { return frame_rate_hz_; }
  const std::vector<Placement>& sensors() const { return sensors_; }
  Eigen::Index frame_count() const { return rotations_.cols(); }
  /// Frames at the recordings' own tempo, mirrored ones included: frame_count() without the copies of other tempos.
  Eigen::Index own_tempo_frames() const { return own_tempo_frames_; }

  /// Modelled joints, the moving root first; others keep their mean.
  const std::vector<int>& active_joints() const { return active_joints_; }
  /// The joints that errors are measured over: those of the body whose place can differ from their parent's, the moving root left out.
  const std::vector<int>& measured_joints() const { return measured_joints_; }
  const std::vector<Eigen::Quaterniond>& mean_rotations() const { return mean_rotations_; }  // of every joint of the skeleton

  /// Frames follow each other clip by clip; of which clip a frame is, and whether the frame before it is of the same.
  int clip_of(Eigen::Index frame) const { return clip_of_[static_cast<std::size_t>(frame)]; }
  bool follows(Eigen::Index frame) const { return frame > 0 && clip_of(frame) == clip_of(frame - 1); }

  /// (3 * active joints x frames), BasePose::rotations.
  const Eigen::MatrixXf& rotations() const { return rotations_; }
  /// (3 * measured joints x frames): from the moving root, in its own axes (the pelvis frame).
  const Eigen::MatrixXf& positions() const { return positions_; }
  /// (3 * sensors x frames): m/s^2, as VirtualAccelerations() of a clip at the base's rate.
  const Eigen::MatrixXf& accelerations() const { return accelerations_; }
  /// (4 x frames): BasePose::step and height_m.
  const Eigen::MatrixXf& travel() const { return travel_; }

  BasePose Pose(Eigen::Index frame) const;
  /// The pose of a frame of some clip on this skeleton, at this rate. @param frame  1 or more for a step that is not 0.
  BasePose PoseOf(const MotionClip& clip, int frame) const;
  /// Local rotations of every joint of the skeleton; the moving root's with heading 0.
  std::vector<Eigen::Quaterniond> LocalRotations(const Eigen::VectorXd& rotations) const;
  /// Every joint of the skeleton seen from the moving root, in its own axes (the pelvis frame).
  void PelvisPose(const Eigen::VectorXd& rotations, WorldPose* pose) const;

  /// Poses as a clip, put together by PoseAssembler.
  MotionClip Assemble(const std::vector<BasePose>& poses) const;

 private:
  void AddClip(const MotionClip& clip, Eigen::Index first);

  std::shared_ptr<const Skeleton> skeleton_;
  double frame_rate_hz_;
  std::vector<Placement> sensors_;
  std::vector<int> active_joints_, measured_joints_;
  std::vector<Eigen::Quaterniond> mean_rotations_;
  std::vector<int> clip_of_;
  Eigen::Index own_tempo_frames_ = 0;
  Eigen::MatrixXf rotations_, positions_, accelerations_, travel_;
};

/// A pose where it stands in the world.
struct PlacedPose {
  std::vector<Eigen::Quaterniond> rotations;  // of every joint of the skeleton: local, the moving root's in the world
  Eigen::Vector3d root_m;
};

/// Puts poses one after the other, from the origin facing +Z: steps are added up, heights are kept.
class PoseAssembler {
 public:
  /// @param base  must outlive the assembler.
  explicit PoseAssembler(const MotionBase& base) : base_(base) {}
  PlacedPose Add(const BasePose& pose);

 private:
  const MotionBase& base_;
  bool first_ = true;
  double heading_ = 0;
  Eigen::Vector3d place_ = Eigen::Vector3d::Zero();
};

}  // namespace morphograph
