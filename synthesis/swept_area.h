#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "datasets/motion_clip.h"

namespace morphograph {

/// A part of the floor: what lies inside `outline` and outside of all `holes`. Simple polygons, (x, z) in metres.
struct FloorRegion {
  std::vector<Eigen::Vector2d> outline_m;
  std::vector<std::vector<Eigen::Vector2d>> holes_m;
};

/// Floor that a body may be above at some time: what a planner keeps free.
struct SweptArea {
  std::vector<FloorRegion> regions;  // apart from each other
  double area_m2 = 0;
  double margin_m = 0;      // around the middle of every bone, as asked for
  double resolution_m = 0;  // the outline lies up to about four times this further out, never further in
};

/// Cells of a floor raster of kSweptCell_m, by (column << 32 | row) of signed numbers; sorted, each once.
using FloorCells = std::vector<std::uint64_t>;
inline constexpr double kSweptCell_m = 0.02;

/// The cells that the bones of a clip are above in any frame, each bone as a line between its joints. Joints above the moving root have no
/// place in the world and are left out.
FloorCells CellsBelow(const MotionClip& clip);

/// The outline of all cells together, widened by the margin. Where the raster would have more than 2^24 cells, a coarser one is taken.
/// Holes below 0.05 m^2 are closed: nothing fits in.
SweptArea OutlineOf(const std::vector<FloorCells>& clips, double margin_m);

/// Half of a body's breadth, and the length of a hand, which few skeletons have.
inline constexpr double kBodyMargin_m = 0.2;

}  // namespace morphograph
