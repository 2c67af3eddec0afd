#include "synthesis/sensors/marker_estimator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "datasets/marker_set.h"
#include "datasets/virtual_sensors.h"
#include "synthesis/sensors/reconstruction_quality.h"
#include "tests/support/random_matrix.h"
#include "tests/synthesis/small_base.h"

namespace morphograph {
namespace {

using ::testing::ElementsAre;
using testing::SmallBase;

const std::vector<Placement>& Markers() {
  static const std::vector<Placement> markers = FullBodyMarkers(testing::WalksOnOneSkeleton(5));
  return markers;
}

std::shared_ptr<const MarkerModel> SmallMarkerModel() {
  static const auto model = std::make_shared<const MarkerModel>(SmallBase(), Markers(), MarkerOptions());
  return model;
}

TEST(MarkerFrame, FollowsItsMarkersOverTheFloor) {
  std::mt19937_64 rng(3);
  const Eigen::Matrix3Xd usual = testing::RandomNormal(3, 5, rng);
  const MarkerFrame frame(usual);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY()));
  Eigen::VectorXd here(15), there(15);
  for (int m = 0; m < 5; ++m) {
    here.segment<3>(3 * m) = usual.col(m);
    there.segment<3>(3 * m) = turn * usual.col(m) + Eigen::Vector3d(3, 0, -2);
  }
  const MarkerFrame::Place place = frame.Fit(there), origin = frame.Fit(here);
  EXPECT_NEAR(place.heading_rad(), 0.7, 1e-9);
  EXPECT_NEAR(origin.heading_rad(), 0, 1e-9);
  for (int m = 0; m < 5; ++m) {
    EXPECT_TRUE(place.Into(there.segment<3>(3 * m)).isApprox(origin.Into(here.segment<3>(3 * m)), 1e-9));
    EXPECT_TRUE(place.OutOf(place.Into(there.segment<3>(3 * m))).isApprox(there.segment<3>(3 * m), 1e-9));
  }
}

TEST(PrincipalMarkers, TakeOneOfEachGroupThatGoesTogether) {
  // Three groups of three markers, each moving on its own; in a group the markers move alike.
  std::mt19937_64 rng(5);
  const Eigen::MatrixXd ways = testing::RandomNormal(9, 400, rng);
  Eigen::MatrixXf tracks(27, 400);
  for (int m = 0; m < 9; ++m) tracks.middleRows(3 * m, 3) = (ways.middleRows(3 * (m / 3), 3) + 0.01 * testing::RandomNormal(3, 400, rng)).cast<float>();
  MarkerSelectionOptions options;
  options.count = 3;
  options.variance_kept = 0.99;
  const std::vector<int> picked = PrincipalMarkers(tracks, options);
  ASSERT_EQ(picked.size(), 3u);
  EXPECT_EQ(picked[0] / 3, 0);
  EXPECT_EQ(picked[1] / 3, 1);
  EXPECT_EQ(picked[2] / 3, 2);
  options.count = 10;
  EXPECT_THROW(PrincipalMarkers(tracks, options), std::invalid_argument);
}

TEST(SegmentMotion, CutsWhereThePosesBeginToVaryOtherwise) {
  std::mt19937_64 rng(7);
  Eigen::MatrixXd poses = 0.01 * testing::RandomNormal(4, 300, rng);
  for (int f = 0; f < 300; ++f) {
    const double t = 0.3 * f;
    if (f < 160) poses.col(f).head<2>() += Eigen::Vector2d(std::sin(t), std::cos(t));
    else poses.col(f).tail<2>() += Eigen::Vector2d(std::sin(t), std::cos(t));
  }
  SegmentationOptions options;
  options.first_s = 1;
  options.rise = 20;  // the second kind moves where the first only trembles
  const std::vector<Eigen::Index> firsts = CutMotion(poses, 30, options);
  ASSERT_GE(firsts.size(), 2u);
  EXPECT_NEAR(static_cast<double>(firsts[1]), 160, 32);
  EXPECT_THAT(CutMotion(poses.leftCols(150), 30, options), ElementsAre(0));
  EXPECT_THAT(CutMotion(poses.leftCols(3), 30, options), ElementsAre(0));
}

TEST(ClusterSegments, BringsSegmentsOfOneKindTogether) {
  std::mt19937_64 rng(9);
  const Eigen::MatrixXd first = testing::RandomNormal(3, 3, rng), second = testing::RandomNormal(3, 3, rng);
  std::vector<Eigen::MatrixXd> segments;
  for (int i = 0; i < 8; ++i) segments.push_back((i % 2 == 0 ? first : second) * testing::RandomNormal(3, 600, rng));
  EXPECT_THAT(ClusterSegments(segments, {}), ElementsAre(0, 1, 0, 1, 0, 1, 0, 1));
  SegmentClusterOptions loose;
  loose.tolerance = 10;
  EXPECT_THAT(ClusterSegments(segments, loose), ElementsAre(0, 0, 0, 0, 0, 0, 0, 0));
  EXPECT_TRUE(ClusterSegments({}, {}).empty());
}

TEST(ClassForest, TellsClassesApartAndIsSureWhereTheyAre) {
  std::mt19937_64 rng(11);
  Eigen::MatrixXf samples = testing::RandomNormal(4, 3000, rng).cast<float>();
  std::vector<int> labels;
  for (int i = 0; i < 3000; ++i) {
    labels.push_back(i % 5);
    samples(0, i) += 8 * static_cast<float>(i % 5);
  }
  const ClassForest forest(samples, labels, 5, {});
  Eigen::VectorXf sample = Eigen::VectorXf::Zero(4);
  for (int k = 0; k < 5; ++k) {
    sample[0] = 8 * static_cast<float>(k);
    const Eigen::VectorXf probabilities = forest.Probabilities(sample);
    Eigen::Index most = 0;
    EXPECT_NEAR(probabilities.sum(), 1, 1e-4);
    EXPECT_GT(probabilities.maxCoeff(&most), 0.45f);  // a tree tells halves of the classes apart
    EXPECT_EQ(most, k);
  }
  EXPECT_THROW(ClassForest(samples, labels, 4, {}), std::invalid_argument);
  EXPECT_THROW(ClassForest(samples, {}, 4, {}), std::invalid_argument);
}

TEST(ClassForest, LeavesRareClassesOutOfALeafButNotAllOfThem) {
  // Nothing to tell classes by: every tree is one leaf with all samples.
  const auto probabilities = [](const std::vector<int>& labels, int classes) {
    const Eigen::MatrixXf same = Eigen::MatrixXf::Zero(2, static_cast<Eigen::Index>(labels.size()));
    return ClassForest(same, labels, classes, {.trees = 3, .depth = 2}).Probabilities(Eigen::VectorXf::Zero(2));
  };
  std::vector<int> labels(300, 0);
  labels[0] = 1;  // a third of a percent
  for (int i = 1; i <= 30; ++i) labels[static_cast<std::size_t>(i)] = 2;  // a tenth
  const Eigen::VectorXf uneven = probabilities(labels, 3);
  EXPECT_EQ(uneven[1], 0);
  EXPECT_NEAR(uneven[2], 30.0 / 299, 1e-4);
  EXPECT_NEAR(uneven.sum(), 1, 1e-4);
  // None comes to 2 %, though one is met more often than the others.
  for (int i = 0; i < 300; ++i) labels[static_cast<std::size_t>(i)] = i % 100;
  labels[1] = labels[101] = 0;
  const Eigen::VectorXf even = probabilities(labels, 100);
  EXPECT_NEAR(even[0], 5.0 / 300, 1e-4);
  EXPECT_NEAR(even[1], 1.0 / 300, 1e-4);
  EXPECT_NEAR(even.tail(98).minCoeff(), 0.01, 1e-4);
}

TEST(MarkerEstimator, FindsAllMarkersAndThePoseOfAWalkThatItHasNotSeen) {
  const auto model = SmallMarkerModel();
  ASSERT_EQ(model->given.size(), 6u);
  ASSERT_EQ(model->reading_size(), 18);
  const MotionClip walk = testing::UnseenWalk();
  const Readings truth = VirtualMarkers(walk, Markers()), reading = VirtualMarkers(walk, model->ReadingMarkers());
  MarkerEstimator estimator(model), poser(model);
  std::vector<BasePose> poses;
  double squared = 0;
  for (int f = 0; f < walk.frame_count(); ++f) {
    const Eigen::Matrix3Xd found = estimator.NextMarkers(reading.values.col(f));
    const Eigen::VectorXd there = truth.values.col(f);
    squared += (found - there.reshaped(3, found.cols())).squaredNorm() / static_cast<double>(found.cols());
    poses.push_back(poser.Next(reading.values.col(f)));
  }
  EXPECT_LT(std::sqrt(squared / walk.frame_count()), 0.02);
  EXPECT_LT(CompareWithTruth(SmallBase(), poses, walk).position_rms_cm, 2);
  // The way over the floor is the walk's own: no drift of added steps.
  const MotionClip made = SmallBase().Assemble(poses);
  const auto way = [](const MotionClip& clip) {
    const Eigen::Vector3d moved = clip.root_positions().rightCols<1>() - clip.root_positions().col(0);
    return std::hypot(moved.x(), moved.z());
  };
  EXPECT_NEAR(way(made), way(walk), 0.05);
}

TEST(MarkerEstimator, WhereTheBodyStandsAndFacesDoesNotMatter) {
  const auto model = SmallMarkerModel();
  const MotionClip walk = testing::UnseenWalk(), moved = Moved(walk, 1.1, 4, -3);
  const Readings here = VirtualMarkers(walk, model->ReadingMarkers()), there = VirtualMarkers(moved, model->ReadingMarkers());
  MarkerEstimator one(model), two(model);
  for (int f = 0; f < 20; ++f) {
    const BasePose a = one.Next(here.values.col(f)), b = two.Next(there.values.col(f));
    EXPECT_LT((a.rotations - b.rotations).norm(), 1e-3) << f;
    EXPECT_LT((a.step - b.step).norm(), 1e-3) << f;
  }
}

TEST(MarkerEstimator, TakesMarkersByNameAndSaysWhatIsWrong) {
  MarkerOptions options;
  options.given = {"left_wrist_front", "right_wrist_front", "left_ankle", "right_ankle"};
  options.frame = {"clavicle", "left_shoulder", "right_shoulder"};
  options.forest.trees = 8;
  const auto model = std::make_shared<const MarkerModel>(SmallBase(), Markers(), options);
  EXPECT_EQ(model->reading_size(), 21);
  EXPECT_EQ(model->ReadingMarkers().back().name, "right_shoulder");
  MarkerEstimator estimator(model);
  EXPECT_THROW(estimator.Next(Eigen::VectorXd::Zero(12)), std::invalid_argument);
  EXPECT_TRUE(estimator.Next(Eigen::VectorXd::Zero(21)).rotations.allFinite());  // all markers at one point
  options.given = {"tail"};
  EXPECT_THROW(MarkerModel(SmallBase(), Markers(), options), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
