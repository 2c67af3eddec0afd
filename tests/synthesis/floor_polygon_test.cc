#include "synthesis/floor_polygon.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "synthesis/control/floor_area.h"

namespace morphograph {
namespace {

using Corners = std::vector<Eigen::Vector2d>;

const Corners kSquare = {{0, 0}, {2, 0}, {2, 2}, {0, 2}};
const Corners kArrow = {{0, 0}, {2, 0}, {2, 2}, {1, 1}};  // not convex

TEST(FloorPolygon, TellsOutlinesThatCrossOrTouchThemselves) {
  for (Corners simple : {kSquare, kArrow, Corners{{0, 0}, {1, 0}, {0, 1}}, Corners{{0, 0}, {1, 0}, {2, 0}, {2, 2}}}) {
    EXPECT_TRUE(IsSimplePolygon(simple));
    std::reverse(simple.begin(), simple.end());
    EXPECT_TRUE(IsSimplePolygon(simple));
  }
  for (const Corners& not_simple : {Corners{}, Corners{{0, 0}, {1, 1}}, Corners{{0, 0}, {2, 2}, {2, 0}, {0, 2}},  // an hourglass
                                    Corners{{0, 0}, {1, 0}, {2, 0}},                                              // a line
                                    Corners{{0, 0}, {2, 0}, {2, 0}, {2, 2}},                                      // a corner twice
                                    Corners{{0, 0}, {2, 0}, {2, 2}, {1, 0}},                                      // a corner on an edge
                                    Corners{{0, 0}, {2, 0}, {3, 0}, {2, 0}, {2, 2}}}) {                           // a spike
    EXPECT_FALSE(IsSimplePolygon(not_simple)) << not_simple.size();
  }
}

TEST(FloorPolygon, MeasuresAreaWhicheverWayItTurns) {
  for (const bool reversed : {false, true}) {
    Corners square = kSquare, arrow = kArrow;
    if (reversed) std::reverse(square.begin(), square.end()), std::reverse(arrow.begin(), arrow.end());
    EXPECT_NEAR(PolygonArea(square), 4, 1e-12);
    EXPECT_NEAR(PolygonArea(arrow), 2, 1e-12);
  }
}

TEST(FloorPolygon, SimplifiedOutlinesStayNearAndSimple) {
  Corners stairs;  // along a circle
  for (int i = 0; i < 400; ++i) {
    const double turn = 2 * M_PI * i / 400;
    stairs.emplace_back(std::round(100 * std::sin(turn)) / 50, std::round(100 * std::cos(turn)) / 50);
  }
  stairs.erase(std::unique(stairs.begin(), stairs.end()), stairs.end());
  const Corners fewer = Simplified(stairs, 0.03);
  EXPECT_TRUE(IsSimplePolygon(fewer));
  EXPECT_LT(fewer.size(), 60u);
  for (const Eigen::Vector2d& corner : stairs) EXPECT_LE(std::abs(DepthInside({.polygon_m = fewer}, corner)), 0.03 + 1e-9);
  EXPECT_NEAR(PolygonArea(fewer), 4 * M_PI, 0.2);
}

}  // namespace
}  // namespace morphograph
