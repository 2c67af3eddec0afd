#pragma once

#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <memory>

#include "synthesis/control/control_terms.h"
#include "synthesis/control/floor_area.h"
#include "synthesis/control/floor_path.h"
#include "synthesis/control/joint_chain.h"
#include "synthesis/control/step_kinematics.h"
#include "synthesis/control/walk_prior.h"

namespace morphograph {

/// The terms of the optimisation (METHODS section 4), each divided by its standard deviation. Unknowns are the whitened latents of the
/// steps and the places of their first key frames (KeyframePlace). All derivatives are analytic.

/// Prior of a step after another: its innovation, less the one that was drawn for it. So without control terms the walk stays the one that
/// was drawn, and with them it is a draw from what is left possible (randomised maximum likelihood; Oliver 1996).
class InnovationResidual : public ceres::CostFunction {
 public:
  InnovationResidual(StepInnovation innovation, Eigen::VectorXd drawn);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  StepInnovation innovation_;
  Eigen::VectorXd drawn_;
};

/// Prior of a walk's first step: its latent within the walk, less the drawn one.
class FirstStepResidual : public ceres::CostFunction {
 public:
  FirstStepResidual(Eigen::VectorXd drawn, Eigen::VectorXd scale);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  Eigen::VectorXd drawn_, scale_;
};

/// How far a latent lies outside of a radius, that of what was captured; 0 inside.
class RadiusResidual : public ceres::CostFunction {
 public:
  RadiusResidual(int dimension, double radius, double deviation);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  double radius_, deviation_;
};

/// A step begins where the one before it ends. `offset` is what a clip's joins add to that: (x, z) in the heading frame of the step's place, heading.
class NextPlaceResidual : public ceres::CostFunction {
 public:
  /// @param looseness  of the joint, against a millimetre and two milliradians; small in long walks, where what is loose adds up.
  NextPlaceResidual(std::shared_ptr<const StepKinematics> step, const Eigen::Vector3d* offset, double looseness);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  std::shared_ptr<const StepKinematics> step_;
  const Eigen::Vector3d* offset_;
  double looseness_;
};

/// Where a walk begins: its first place, held or only likely.
class StartResidual : public ceres::CostFunction {
 public:
  StartResidual(const KeyframePlace& place, const Eigen::Vector4d& deviation);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  KeyframePlace place_;
  Eigen::Vector4d deviation_;
};

/// When a place is come to.
class ArrivalResidual : public ceres::CostFunction {
 public:
  ArrivalResidual(double time_s, double deviation_s);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  double time_s_, deviation_s_;
};

/// A residual of one step: parameters are its latent and its place. Value and derivatives come together; those of the latest place are kept, since solvers
/// ask for the value first and, where they stay there, for the derivatives then. For one thread.
class StepResidual : public ceres::CostFunction {
 public:
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const final;
  /// The derivative by the latent, (residuals x D).
  const Eigen::MatrixXd& ByLatent(const Eigen::VectorXd& w, const KeyframePlace& place) const { return At(w, place).by_latent; }

 protected:
  struct Linear {
    Eigen::VectorXd value;
    Eigen::MatrixXd by_latent;
    Eigen::Matrix<double, Eigen::Dynamic, 4> by_place;
  };
  StepResidual(std::shared_ptr<const StepKinematics> step, int residuals);
  virtual Linear Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const = 0;
  const StepKinematics& step() const { return *step_; }

 private:
  const Linear& At(const Eigen::VectorXd& w, const KeyframePlace& place) const;

  std::shared_ptr<const StepKinematics> step_;
  mutable Eigen::VectorXd latest_w_;  // nothing before there was one
  mutable KeyframePlace latest_place_ = KeyframePlace::Zero();
  mutable Linear latest_;
};

/// Distance of the root from a path, to its left, at a moment of a step.
class PathResidual : public StepResidual {
 public:
  /// @param from_m, to_m  part of the path that the moment belongs to.
  PathResidual(std::shared_ptr<const StepKinematics> step, const StepMoment& moment, const FloorPath& path, double from_m, double to_m, double deviation_m);

 protected:
  Linear Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const override;

 private:
  StepMoment moment_;
  const FloorPath& path_;
  double from_m_, to_m_, deviation_m_;
};

/// Root on the floor and heading at a moment; deviations of infinity leave a value free. `offset` is added to what the steps alone give.
class RootResidual : public StepResidual {
 public:
  RootResidual(std::shared_ptr<const StepKinematics> step, const StepMoment& moment, const Eigen::Vector3d& target, const Eigen::Vector3d& deviation,
               const Eigen::Vector3d* offset);

 protected:
  Linear Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const override;

 private:
  StepMoment moment_;
  Eigen::Vector3d target_, deviation_;
  const Eigen::Vector3d* offset_;
};

/// A joint's position at a moment; deviations and offset as above.
class JointPositionResidual : public StepResidual {
 public:
  JointPositionResidual(std::shared_ptr<const StepKinematics> step, std::shared_ptr<const JointChain> chain, const StepMoment& moment,
                        const Eigen::Vector3d& target_m, const Eigen::Vector3d& deviation_m, const Eigen::Vector3d* offset);

 protected:
  Linear Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const override;

 private:
  std::shared_ptr<const JointChain> chain_;
  StepMoment moment_;
  Eigen::Vector3d target_m_, deviation_m_;
  const Eigen::Vector3d* offset_;
};

/// A joint's world orientation at a moment: rotation vector from the target to it, in the target's frame.
class JointOrientationResidual : public StepResidual {
 public:
  JointOrientationResidual(std::shared_ptr<const StepKinematics> step, std::shared_ptr<const JointChain> chain, const StepMoment& moment,
                           const Eigen::Quaterniond& target, double deviation_rad);

 protected:
  Linear Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const override;

 private:
  std::shared_ptr<const JointChain> chain_;
  StepMoment moment_;
  Eigen::Quaterniond target_;
  double deviation_rad_;
};

/// A joint looks at a point at a moment: difference of the unit vectors along its `forward` and to the point.
class LookAtResidual : public StepResidual {
 public:
  /// @param forward  in the joint's frame, a unit vector.
  LookAtResidual(std::shared_ptr<const StepKinematics> step, std::shared_ptr<const JointChain> chain, const StepMoment& moment,
                 const Eigen::Vector3d& forward, const Eigen::Vector3d& point_m, double deviation_rad);

 protected:
  Linear Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const override;

 private:
  std::shared_ptr<const JointChain> chain_;
  StepMoment moment_;
  Eigen::Vector3d forward_, point_m_;
  double deviation_rad_;
};

/// Root speed of a step over the floor, key frame to key frame.
class SpeedResidual : public StepResidual {
 public:
  SpeedResidual(std::shared_ptr<const StepKinematics> step, double speed_m_s, double deviation_m_s);

 protected:
  Linear Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const override;

 private:
  double speed_m_s_, deviation_m_s_;
};

/// How deep the root (no chain) or a joint comes into an area, and into a margin around it; 0 outside of both.
class KeepOutResidual : public StepResidual {
 public:
  KeepOutResidual(std::shared_ptr<const StepKinematics> step, std::shared_ptr<const JointChain> chain, const StepMoment& moment, const KeepOutTerm& area,
                  double margin_m, double deviation_m);

 protected:
  Linear Linearise(const Eigen::VectorXd& w, const KeyframePlace& place) const override;

 private:
  std::shared_ptr<const JointChain> chain_;
  StepMoment moment_;
  FloorArea area_;
  double margin_m_, deviation_m_;
};

}  // namespace morphograph
