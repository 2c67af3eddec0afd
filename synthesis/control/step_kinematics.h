#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "primitives/pose_layout.h"
#include "synthesis/control/joint_chain.h"
#include "synthesis/control/step_model.h"

namespace morphograph {

/// Where and when a step begins in the world: root on the floor (x, z; m), heading (rad), time (s) at its first key frame.
using KeyframePlace = Eigen::Vector4d;
enum KeyframePlaceRow { kPlaceX = 0, kPlaceZ, kPlaceHeading, kPlaceTime };

/// A moment of a step: a phase (0 = its first key frame, 1 = its second), or a time of the clip, whose phase follows from place and warp.
struct StepMoment {
  bool is_time = false;
  double value = 0;
};

/// What is known of a step at a moment as a function of its whitened latent w (D) and its place, with exact derivatives.
struct FloorState {
  Eigen::Vector3d value;        // x, z, heading
  Eigen::MatrixXd by_latent;    // (3 x D)
  Eigen::Matrix<double, 3, 4> by_place;
};
struct PointState {
  Eigen::Vector3d position_m;
  Eigen::Matrix3d rotation;     // world_from_joint
  Eigen::MatrixXd position_by_latent, turn_by_latent;  // (3 x D); turns about the world's axes, see JointState
  Eigen::Matrix<double, 3, 4> position_by_place, turn_by_place;
};
struct PlaceState {
  KeyframePlace value;
  Eigen::MatrixXd by_latent;    // (4 x D)
  Eigen::Matrix4d by_place;
};

/// One step of a walk set down on the floor.
///
/// The world is that of the drawn steps alone, set end to end at key frames; a clip's cross-fades, foot lock and arm reach move it by
/// millimetres, which the optimiser measures and takes into account (see WalkOptimizer).
class StepKinematics {
 public:
  /// @param model  shared by steps of one primitive and component. @param mean_root  of the style.
  StepKinematics(std::shared_ptr<const StepModel> model, const PoseLayout& layout, const Eigen::Quaterniond& mean_root);

  int dimension() const { return model_->dimension(); }
  const StepModel& model() const { return *model_; }

  /// Phase of a moment, with derivatives by w and by the time of the place.
  struct Phase {
    double value = 0;
    Eigen::RowVectorXd by_latent;
    double by_time = 0;
  };
  Phase PhaseAt(const StepMoment& moment, const Eigen::VectorXd& w, const KeyframePlace& place) const;

  FloorState Root(const StepMoment& moment, const Eigen::VectorXd& w, const KeyframePlace& place) const;
  PointState Joint(const JointChain& chain, const StepMoment& moment, const Eigen::VectorXd& w, const KeyframePlace& place) const;
  /// Several joints at one moment, which costs little more than one.
  std::vector<PointState> Joints(const std::vector<const JointChain*>& chains, const StepMoment& moment, const Eigen::VectorXd& w, const KeyframePlace& place) const;
  /// Where the next step begins.
  PlaceState Next(const Eigen::VectorXd& w, const KeyframePlace& place) const;

  /// Where the next step begins, and the root half way there (x, z), without derivatives.
  struct Way {
    KeyframePlace next;
    Eigen::Vector2d middle_m;
  };
  Way WayOf(const Eigen::VectorXd& w, const KeyframePlace& place) const;

 private:
  struct Heading {
    double value = 0;
    Eigen::RowVector3d by_channels;
  };
  Heading HeadingOf(const Eigen::Vector3d& channels) const;
  // How the step's own frame lies in the world: turned by `yaw` about the root of its first key frame.
  struct Frame {
    double yaw = 0;
    Eigen::RowVectorXd yaw_by_latent;
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // that root on the floor, in the step's frame
    Eigen::MatrixXd origin_by_latent;                  // (3 x D)
  };
  Frame FrameOf(const Eigen::VectorXd& w, const KeyframePlace& place) const;

  std::shared_ptr<const StepModel> model_;
  Eigen::Quaterniond mean_root_;
  Eigen::Vector3d across_;
  StepModel::Map first_, middle_, second_;  // root at the key frames and half way
};

/// Where a step has begun that has its root at a place at that place's time.
KeyframePlace PlaceBefore(const StepKinematics& step, const Eigen::VectorXd& whitened, const KeyframePlace& root, double begins_s);

}  // namespace morphograph
