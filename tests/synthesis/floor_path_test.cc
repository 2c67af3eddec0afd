#include "synthesis/control/floor_path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "synthesis/control/floor_area.h"

namespace morphograph {
namespace {

TEST(FloorPath, RunsAlongStraightPieces) {
  const FloorPath path({{0, 0}, {2, 0}, {2, 0}, {2, 3}});
  EXPECT_DOUBLE_EQ(path.length_m(), 5);
  EXPECT_TRUE(path.At(1).isApprox(Eigen::Vector2d(1, 0)));
  EXPECT_TRUE(path.At(3).isApprox(Eigen::Vector2d(2, 1)));
  EXPECT_TRUE(path.At(6).isApprox(Eigen::Vector2d(2, 4))) << "straight on past its end";
  EXPECT_NEAR(path.Heading(1), M_PI / 2, 1e-12) << "along +X";
  EXPECT_NEAR(path.Heading(4), 0, 1e-12) << "along +Z";
}

TEST(FloorPath, FindsTheNearestPointWithinAPart) {
  const FloorPath path({{0, 0}, {4, 0}, {4, 1}, {0, 1}});
  const Eigen::Vector2d point(1, 0.6);
  EXPECT_NEAR(path.NearestTo(point).distance_m, 0.4, 1e-12);
  EXPECT_NEAR(path.NearestTo(point).along_m, 8, 1e-12);
  EXPECT_NEAR(path.NearestTo(point, 0, 3).along_m, 1, 1e-12) << "on the way there, not on the way back";
  EXPECT_NEAR(path.NearestTo(point, 2, 3).along_m, 2, 1e-12) << "the part's end";
  EXPECT_NEAR(path.NearestTo({5, -1}).distance_m, std::sqrt(2.0), 1e-12) << "a corner";
}

TEST(FloorPath, SplineGoesThroughItsPointsWithoutCorners) {
  const std::vector<Eigen::Vector2d> points = {{0, 0}, {1, 0}, {2, 1}, {2, 2.5}};
  const FloorPath path(points, true);
  for (const Eigen::Vector2d& point : points) EXPECT_LT(path.NearestTo(point).distance_m, 1e-9);
  double sharpest = 0;
  for (double along = 0.05; along < path.length_m(); along += 0.01)
    sharpest = std::max(sharpest, std::abs(std::remainder(path.Heading(along) - path.Heading(along - 0.01), 2 * M_PI)));
  EXPECT_LT(sharpest, 0.1);
}

TEST(FloorPath, NeedsTwoPoints) {
  EXPECT_THROW(FloorPath({{1, 1}}), std::invalid_argument);
  EXPECT_THROW(FloorPath({{1, 1}, {1, 1.0001}}), std::invalid_argument);
  EXPECT_THROW(FloorPath({{1, 1}, {1, NAN}}), std::invalid_argument);
}

TEST(FloorArea, SaysHowDeepAPointLies) {
  KeepOutTerm circle;
  circle.center_m = {1, 1};
  circle.radius_m = 2;
  EXPECT_NEAR(DepthInside(circle, {1, 2}), 1, 1e-12);
  EXPECT_NEAR(DepthInside(circle, {1, 4}), -1, 1e-12);
  KeepOutTerm notched;  // a square with a notch from its right side
  notched.polygon_m = {{0, 0}, {4, 0}, {4, 1}, {2, 2}, {4, 3}, {4, 4}, {0, 4}};
  EXPECT_NEAR(DepthInside(notched, {1, 2}), 1, 1e-12);
  EXPECT_LT(DepthInside(notched, {3.5, 2}), 0);
  EXPECT_NEAR(DepthInside(notched, {-1.5, 2}), -1.5, 1e-12);
  EXPECT_LT(DepthInside(notched, {-30, 2}), -2) << "far away a bound is enough";
  EXPECT_GE(DepthInside(notched, {-30, 2}), -30);
}

}  // namespace
}  // namespace morphograph
