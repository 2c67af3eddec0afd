#include "primitives/alignment_quality.h"

#include <gmock/gmock.h>

#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <random>

#include "primitives/frame_distance.h"

namespace morphograph {
namespace {

using Frames = std::vector<Eigen::Matrix3Xd>;
constexpr int kJoints = 6;

// A body that goes forward, its joints swinging each in its own way; joint 0 is the root.
Frames StraightPath(int frames, double speed_m) {
  Frames walk;
  for (int f = 0; f < frames; ++f) {
    const double phase = static_cast<double>(f) / (frames - 1);
    Eigen::Matrix3Xd pose(3, kJoints);
    for (int j = 0; j < kJoints; ++j) {
      pose.col(j) << 0.2 * j * std::cos(1.0 + j), 0.3 * j, speed_m * phase + 0.3 * j * std::sin(2 * phase + j);
    }
    walk.push_back(pose);
  }
  return walk;
}

Frames AllMoved(Frames frames, const PlanarTransform& move) {
  for (Eigen::Matrix3Xd& pose : frames) {
    for (int j = 0; j < kJoints; ++j) pose.col(j) = (move * Eigen::Vector3d(pose.col(j))).eval();
  }
  return frames;
}

const Eigen::VectorXd kEven = Eigen::VectorXd::Constant(kJoints, 1.0 / kJoints);

TEST(AlignmentQuality, AMovedCopyComesBackOntoItsReference) {
  const Frames reference = StraightPath(18, 0.7), test = AllMoved(reference, {.yaw_rad = 2, .x_m = 3, .z_m = -1});
  for (const AlignmentTransform transform : {AlignmentTransform::kEachFrame, AlignmentTransform::kSegment}) {
    const SegmentAlignment aligned = AlignSegment(reference, test, kEven, 0, transform);
    EXPECT_LT(PathDifference(aligned.root, FloorPath(reference, 0)), 1e-9);
    EXPECT_NEAR(SpeedVariance(aligned.root, 30), SpeedVariance(FloorPath(reference, 0), 30), 1e-9);
    for (int f = 0; f < 18; ++f) EXPECT_EQ(aligned.matched[f], f);
  }
}

TEST(AlignmentQuality, HasAPlaceForEveryReferenceFrame) {
  for (const int frames : {12, 30}) {
    const SegmentAlignment aligned = AlignSegment(StraightPath(18, 0.7), StraightPath(frames, 0.7), kEven, 0);
    ASSERT_EQ(aligned.root.cols(), 18);
    EXPECT_EQ(aligned.matched.front(), 0);
    EXPECT_EQ(aligned.matched.back(), frames - 1);
    EXPECT_TRUE(std::is_sorted(aligned.matched.begin(), aligned.matched.end()));
    for (int r = 0; r < 18; ++r) {  // the best of those that the warp allows
      for (const WarpCell& cell : aligned.warp.cells) {
        if (cell.reference != r) continue;
        EXPECT_LE(aligned.distances(r, aligned.matched[r]), aligned.distances(r, cell.test));
      }
    }
  }
}

// What Du's weights are for: noise of the last joint pulls the alignment, the less so the less it weighs.
TEST(AlignmentQuality, NoiseOfAJointThatWeighsLittleMovesTheRootLess) {
  std::mt19937_64 rng(3);
  boost::random::normal_distribution<double> noise(0, 0.2);
  const Frames reference = StraightPath(18, 0.7);
  Frames test = reference;
  for (Eigen::Matrix3Xd& pose : test) {
    for (int d = 0; d < 3; ++d) pose(d, kJoints - 1) += noise(rng);
  }
  Eigen::VectorXd falling(kJoints);
  for (int j = 0; j < kJoints; ++j) falling[j] = 1.0 / (1 + j);
  falling /= falling.sum();
  const Eigen::Matrix2Xd path = FloorPath(reference, 0);
  const double even = PathDifference(AlignSegment(reference, test, kEven, 0).root, path);
  const double weighted = PathDifference(AlignSegment(reference, test, falling, 0).root, path);
  EXPECT_GT(even, 0.01);
  EXPECT_LT(weighted, 0.7 * even);
  // One transform for all frames averages the noise away, and cannot follow it.
  EXPECT_LT(PathDifference(AlignSegment(reference, test, kEven, 0, AlignmentTransform::kSegment).root, path), 0.9 * even);
}

TEST(AlignmentQuality, PathDifferenceIsTheMeanDistance) {
  Eigen::Matrix2Xd a(2, 2), b(2, 2);
  a << 0, 1, 0, 1;
  b << 3, 1, 4, 2;
  EXPECT_DOUBLE_EQ(PathDifference(a, b), 3);  // (5 + 1) / 2
  EXPECT_THROW(PathDifference(a, b.leftCols(1)), std::invalid_argument);
  EXPECT_THROW(PathDifference(Eigen::Matrix2Xd(2, 0), Eigen::Matrix2Xd(2, 0)), std::invalid_argument);
}

TEST(AlignmentQuality, SpeedVarianceIsThatOfTheSpeed) {
  Eigen::Matrix2Xd path(2, 3);
  path << 0, 3, 3, 0, 4, 5;  // steps of 5 and 1, whatever their direction
  EXPECT_THAT(PathSpeeds(path, 2), ::testing::ElementsAre(10, 2));
  EXPECT_DOUBLE_EQ(SpeedVariance(path, 2), 16);
  EXPECT_EQ(SpeedVariance(path.leftCols(2), 2), 0);
}

TEST(AlignmentQuality, RefusesARootThatIsNoJoint) {
  EXPECT_THROW(AlignSegment(StraightPath(10, 1), StraightPath(10, 1), kEven, kJoints), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
