#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "datasets/joint_roles.h"
#include "datasets/motion_clip.h"

namespace morphograph {

using LegJoints = Eigen::Matrix<double, 3, 6>;   // hips, knees, ankles, left before right
using LegPlaces = Eigen::Matrix<double, 3, 4>;   // knees and ankles from the middle of the hips: left, up, forwards of the hips

inline constexpr JointRole kLegRoles[] = {JointRole::kLeftHip, JointRole::kRightHip, JointRole::kLeftKnee, JointRole::kRightKnee, JointRole::kLeftAnkle, JointRole::kRightAnkle};

/// Thigh and shank, mean of both sides, metres.
double LegLength(const LegJoints& joints);

/// Seen from the hips, for legs of `length_m`.
LegPlaces PlacesOfLegs(const LegJoints& joints, double length_m);
std::vector<LegPlaces> PlacesOfLegs(const MotionClip& clip, double length_m);

LegPlaces MeanOf(const std::vector<LegPlaces>& places);

/// Of every true pose the pose of the clips that is nearest: what no choice of one can better.
std::vector<LegPlaces> NearestPoses(const std::vector<MotionClip>& clips, const std::vector<LegPlaces>& truth, double length_m);

/// Prints a line: mean and 95th percentile over frames of the root mean square distance, cm, as it is and less the mean difference.
void PrintErrors(const std::string& name, const std::vector<LegPlaces>& found, const std::vector<LegPlaces>& truth);

}  // namespace morphograph
