#include "synthesis/swept_area.h"

#include <gtest/gtest.h>

#include <cmath>

#include "datasets/forward_kinematics.h"
#include "synthesis/control/floor_area.h"
#include "synthesis/floor_polygon.h"
#include "tests/synthesis/gait_clips.h"

namespace morphograph {
namespace {

// Cells on a line of points.
FloorCells CellsOf(const std::vector<Eigen::Vector2d>& points) {
  FloorCells cells;
  for (const Eigen::Vector2d& point : points) {
    const auto at = [](double metres) { return std::uint64_t{static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(metres / kSweptCell_m)))}; };
    cells.push_back((at(point.x()) << 32) | at(point.y()));
  }
  return cells;
}

bool Covers(const SweptArea& area, const Eigen::Vector2d& point) {
  for (const FloorRegion& region : area.regions) {
    if (DepthInside({.polygon_m = region.outline_m}, point) < -1e-9) continue;
    bool in_hole = false;
    for (const auto& hole : region.holes_m) in_hole = in_hole || DepthInside({.polygon_m = hole}, point) > 1e-9;
    if (!in_hole) return true;
  }
  return false;
}

void ExpectSimple(const SweptArea& area) {
  double area_m2 = 0;
  for (const FloorRegion& region : area.regions) {
    EXPECT_TRUE(IsSimplePolygon(region.outline_m));
    area_m2 += PolygonArea(region.outline_m);
    for (const auto& hole : region.holes_m) {
      EXPECT_TRUE(IsSimplePolygon(hole));
      area_m2 -= PolygonArea(hole);
      for (const Eigen::Vector2d& corner : hole) EXPECT_GT(DepthInside({.polygon_m = region.outline_m}, corner), 0);
    }
  }
  EXPECT_NEAR(area.area_m2, area_m2, 1e-9);
}

TEST(SweptArea, APointBecomesADiscOfTheMargin) {
  const SweptArea area = OutlineOf({CellsOf({{1.01, -2.03}})}, 0.3);
  ASSERT_EQ(area.regions.size(), 1u);
  ExpectSimple(area);
  EXPECT_EQ(area.resolution_m, kSweptCell_m);
  const double outer = 0.3 + 3.5 * kSweptCell_m;
  EXPECT_GT(area.area_m2, M_PI * 0.3 * 0.3);
  EXPECT_LT(area.area_m2, M_PI * outer * outer + 0.03);
  for (int i = 0; i < 60; ++i) {
    const double turn = 2 * M_PI * i / 60;
    const Eigen::Vector2d direction(std::sin(turn), std::cos(turn));
    EXPECT_TRUE(Covers(area, Eigen::Vector2d(1.01, -2.03) + 0.299 * direction));
    EXPECT_FALSE(Covers(area, Eigen::Vector2d(1.01, -2.03) + (outer + 0.01) * direction));
  }
}

TEST(SweptArea, NothingTakesNoFloor) {
  const SweptArea area = OutlineOf({{}, {}}, 0.3);
  EXPECT_TRUE(area.regions.empty());
  EXPECT_EQ(area.area_m2, 0);
}

TEST(SweptArea, AWalkInACircleKeepsItsMiddleFree) {
  std::vector<Eigen::Vector2d> circle, apart;
  for (int i = 0; i < 1000; ++i) circle.emplace_back(2 * std::sin(i * 0.01), 2 * std::cos(i * 0.01));
  for (int i = 0; i < 100; ++i) apart.emplace_back(10 + i * 0.01, i * 0.01);
  const SweptArea area = OutlineOf({CellsOf(circle), CellsOf(apart)}, 0.2);
  ASSERT_EQ(area.regions.size(), 2u);
  ExpectSimple(area);
  const bool first_is_circle = !area.regions[0].holes_m.empty();
  ASSERT_EQ(area.regions[first_is_circle ? 0 : 1].holes_m.size(), 1u);
  EXPECT_FALSE(Covers(area, {0, 0}));
  EXPECT_FALSE(Covers(area, {1.7, 0}));
  for (const Eigen::Vector2d& point : circle) EXPECT_TRUE(Covers(area, point * 1.09) && Covers(area, point * 0.91));
  const double bare_m2 = M_PI * (2.2 * 2.2 - 1.8 * 1.8) + M_PI * 0.04 + 0.4 * std::sqrt(2.0) * 0.99;
  EXPECT_GT(area.area_m2, bare_m2 - 1e-3);
  EXPECT_LT(area.area_m2, bare_m2 * 1.3);
}

TEST(SweptArea, FarApartPlacesAreTakenMoreCoarsely) {
  const SweptArea area = OutlineOf({CellsOf({{-300, -300}, {300, 300}})}, 0.5);
  EXPECT_EQ(area.regions.size(), 2u);
  EXPECT_GT(area.resolution_m, kSweptCell_m);
  EXPECT_LT(area.resolution_m, 0.2);
  EXPECT_TRUE(Covers(area, {-300, -299.51}));
  EXPECT_TRUE(Covers(area, {300.49, 300}));
  EXPECT_FALSE(Covers(area, {0, 0}));
}

TEST(SweptArea, OutlinesThatMeetAtACornerStaySimple) {
  std::vector<Eigen::Vector2d> points;  // sparse, so that discs touch in all ways
  for (int i = 0; i < 400; ++i) points.emplace_back(std::fmod(i * 0.6180339887, 1.0) * 4, std::fmod(i * 0.7548776662, 1.0) * 4);
  for (const double margin_m : {0.0, 0.03, 0.06, 0.09}) {
    SCOPED_TRACE(margin_m);
    const SweptArea area = OutlineOf({CellsOf(points)}, margin_m);
    ExpectSimple(area);
    for (const Eigen::Vector2d& point : points) EXPECT_TRUE(Covers(area, point));
  }
}

TEST(SweptArea, HoldsEveryJointOfAWalk) {
  const MotionClip clip = testing::GaitClip(3);
  const SweptArea area = OutlineOf({CellsBelow(clip)}, 0.1);
  ExpectSimple(area);
  ASSERT_EQ(area.regions.size(), 1u);
  for (int f = 0; f < clip.frame_count(); f += 7) {
    const Eigen::Matrix3Xd positions = ForwardKinematics(clip, f).positions;
    for (int j = clip.skeleton().moving_root(); j < clip.joint_count(); ++j) {
      const Eigen::Vector2d place(positions(0, j), positions(2, j));
      EXPECT_TRUE(Covers(area, place)) << f << " " << j;
      EXPECT_TRUE(Covers(area, place + Eigen::Vector2d(0.07, -0.07))) << f << " " << j;
    }
  }
}

}  // namespace
}  // namespace morphograph
