#pragma once

#include <Eigen/Core>
#include <vector>

#include "primitives/time_warp.h"

namespace morphograph {

/// What moves a test segment over the floor onto its reference.
enum class AlignmentTransform {
  kEachFrame,  // every frame by its own best turn and move (Du 3.2)
  kSegment,    // the whole segment by one
};

/// A segment of motion brought onto a reference in time and place (Du 3.2).
struct SegmentAlignment {
  Eigen::MatrixXd distances;  // (reference frames x test frames), Du Eq. 3.1, m^2
  WarpPath warp;
  std::vector<int> matched;   // for every reference frame the test frame, of those that the warp gives it, that is most like it
  Eigen::Matrix2Xd root;      // (x, z) of the matched test frames' root where the alignment puts it, a reference frame a column
};

/// Aligns by DTW under the frame distance, then by the planar transforms that go with that distance (Du Eq. 3.5-3.7).
///
/// @param reference, test  joint positions (3 x joints) a frame, metres. @param weights  (joints), see FrameDistance.
/// @param root  the joint whose path is taken.
/// @throws std::invalid_argument as FrameDistance and DynamicTimeWarp do, and for a root that is no joint.
SegmentAlignment AlignSegment(const std::vector<Eigen::Matrix3Xd>& reference, const std::vector<Eigen::Matrix3Xd>& test,
                              const Eigen::VectorXd& weights, int root, AlignmentTransform transform = AlignmentTransform::kEachFrame);

/// The floor path (x, z) of a joint, a frame a column.
Eigen::Matrix2Xd FloorPath(const std::vector<Eigen::Matrix3Xd>& frames, int joint);

/// Mean distance of two paths, frame by frame, metres (Du Eq. 4.4). @throws std::invalid_argument for lengths that differ or are 0.
double PathDifference(const Eigen::Matrix2Xd& a, const Eigen::Matrix2Xd& b);

/// Speeds along a path, m/s, one fewer than its frames.
std::vector<double> PathSpeeds(const Eigen::Matrix2Xd& path, double frame_rate_hz);

/// Variance of the speed along a path, m^2/s^2 (Du 4.3.1: sharp changes of speed look unnatural); 0 for fewer than three frames.
double SpeedVariance(const Eigen::Matrix2Xd& path, double frame_rate_hz);

}  // namespace morphograph
