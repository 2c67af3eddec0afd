#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "primitives/gaussian_mixture.h"
#include "primitives/keyframe.h"
#include "primitives/manner_model.h"
#include "primitives/pose_layout.h"

namespace morphograph {

/// Knots of a step's time warp (log-slopes, see TimeWarp).
inline constexpr int kWarpKnots = 5;
/// Timing part of a step's vector: log duration in seconds, then the log-slopes of the warp.
inline constexpr int kTimingValues = 1 + kWarpKnots;

/// Parts of the feet: left heel, left ball, right heel, right ball (as ContactTrack).
inline constexpr int kFootParts = 4;
/// What is known of the parts of the feet at one time, kFootParts rows each: the chance of being planted, and while planted the
/// height over the floor (m) and the velocity to the left and forwards of the pelvis' heading (m/s).
enum ContactRow { kPlantedChance = 0, kPlantedHeight = kFootParts, kSlideLeft = 2 * kFootParts, kSlideForward = 3 * kFootParts };
inline constexpr int kContactRows = 4 * kFootParts;
using ContactProfile = Eigen::Matrix<double, kContactRows, Eigen::Dynamic>;

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
  MannerModel manner;         // of the whitened latents
  double latent_radius = 0;  // largest norm of a whitened training latent
  ContactProfile contacts = ContactProfile::Zero(kContactRows, kPhaseSamples);  // on the canonical timeline, learned: at latent 0
  /// What a latent adds to that: the kContactRows rows, sample after sample, x components. Empty: nothing.
  Eigen::MatrixXf contact_map;

  /// The step that a latent vector stands for. @throws std::invalid_argument if its size is not `components()`.
  StepShape Shape(const Eigen::VectorXd& latent) const;
  /// What its feet are meant to do, chances between 0 and 1; `contacts` for an empty latent or map. @throws std::invalid_argument as Shape, where there is a map.
  ContactProfile Contacts(const Eigen::VectorXd& latent) const;
};

}  // namespace morphograph
