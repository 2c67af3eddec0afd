#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "primitives/gaussian_mixture.h"
#include "primitives/keyframe.h"
#include "primitives/pose_layout.h"

namespace morphograph {

/// Knots of a step's time warp (log-slopes, see TimeWarp).
inline constexpr int kWarpKnots = 5;
/// Timing part of a step's vector: log duration in seconds, then the log-slopes of the warp.
inline constexpr int kTimingValues = 1 + kWarpKnots;

/// Learned contact labels on the canonical timeline: chance that a part of a foot is planted.
/// Rows: left heel, left ball, right heel, right ball (as ContactTrack). (4 x kPhaseSamples)
using ContactChances = Eigen::Matrix<double, 4, kPhaseSamples>;

/// A step drawn or projected: geometry on the canonical timeline and its timing.
struct StepShape {
  Eigen::MatrixXd poses;       // (channels x kPhaseSamples), see PoseLayout
  double duration_s = 0;       // from the first key frame to the second
  Eigen::VectorXd log_slopes;  // (kWarpKnots) of the time warp inside the step
};

/// The linear reduction of a step: vector = mean + basis * latent. A vector holds `channels * kPhaseSamples` pose values,
/// sample after sample, then kTimingValues of timing.
struct StepReduction {
  Eigen::VectorXd mean;          // (values)
  Eigen::MatrixXf basis;         // (values x components); single precision, as the model file keeps it
  double variance_kept = 0;

  int components() const { return static_cast<int>(basis.cols()); }
};

/// Statistical model of one kind of step in one style (Du 3.3-3.4): reduction, mixture over the latent vectors, contacts.
struct MotionPrimitive {
  std::string name;
  std::string style;
  KeyframeLabel start = KeyframeLabel::kRightStance;
  KeyframeLabel end = KeyframeLabel::kLeftStance;
  int style_index = 0;     // of the graph's styles; picks the mean rotations
  int examples = 0;
  int made_examples = 0;
  double initial_weight = 0;  // how often a clip's steady walking began here
  StepReduction reduction;
  GaussianMixture mixture;
  CovarianceForm covariance_form = CovarianceForm::kFull;
  double latent_radius = 0;  // largest norm of a whitened training latent
  ContactChances contacts = ContactChances::Zero();

  /// The step that a latent vector stands for. @throws std::invalid_argument if its size is not `components()`.
  StepShape Shape(const Eigen::VectorXd& latent) const;
};

}  // namespace morphograph
