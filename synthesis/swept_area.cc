#include "synthesis/swept_area.h"

#include <algorithm>
#include <boost/polygon/polygon.hpp>
#include <cmath>

#include "datasets/forward_kinematics.h"
#include "synthesis/floor_polygon.h"

namespace morphograph {
namespace {

namespace bp = boost::polygon;

constexpr std::int64_t kMaxCells = std::int64_t{1} << 24;
constexpr double kLeastHole_m2 = 0.05;
constexpr double kAlongBone_m = 2 * kSweptCell_m;  // between points taken of a bone

std::uint64_t Packed(std::int32_t column, std::int32_t row) {
  return (std::uint64_t{static_cast<std::uint32_t>(column)} << 32) | static_cast<std::uint32_t>(row);
}
std::int32_t ColumnOf(std::uint64_t cell) { return static_cast<std::int32_t>(cell >> 32); }
std::int32_t RowOf(std::uint64_t cell) { return static_cast<std::int32_t>(cell & 0xFFFF'FFFF); }

std::int32_t CellAt(double metres) { return static_cast<std::int32_t>(std::floor(metres / kSweptCell_m)); }

void SortUnique(FloorCells* cells) {
  std::sort(cells->begin(), cells->end());
  cells->erase(std::unique(cells->begin(), cells->end()), cells->end());
}

// Which cells are covered; row by row.
class Raster {
 public:
  Raster(int columns, int rows) : columns_(columns), rows_(rows), covered_(static_cast<std::size_t>(columns) * rows) {}
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  bool at(int column, int row) const { return covered_[static_cast<std::size_t>(row) * columns_ + column]; }
  void Cover(int column, int row) { covered_[static_cast<std::size_t>(row) * columns_ + column] = true; }

 private:
  int columns_, rows_;
  std::vector<bool> covered_;
};

// Covers all within `radius` cells of a cell of `marks`, which has that much room at its borders.
Raster Widened(const Raster& marks, double radius) {
  const int reach = static_cast<int>(std::ceil(radius));
  std::vector<int> half_widths;  // of the disc, by row
  for (int dy = -reach; dy <= reach; ++dy)
    half_widths.push_back(std::abs(dy) > radius ? -1 : static_cast<int>(std::floor(std::sqrt(radius * radius - dy * dy))));
  Raster wide = marks;
  for (int row = reach; row + reach < marks.rows(); ++row) {
    for (int column = reach; column + reach < marks.columns(); ++column) {
      if (!marks.at(column, row)) continue;
      // A cell among its like adds nothing that they do not.
      if (marks.at(column - 1, row) && marks.at(column + 1, row) && marks.at(column, row - 1) && marks.at(column, row + 1)) continue;
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -half_widths[dy + reach]; dx <= half_widths[dy + reach]; ++dx) wide.Cover(column + dx, row + dy);
      }
    }
  }
  return wide;
}

// Covers a cell wherever two touch at a corner only: an outline through there would touch itself.
void ClosePinches(Raster* raster) {
  for (bool changed = true; changed;) {
    changed = false;
    for (int row = 0; row + 1 < raster->rows(); ++row) {
      for (int column = 0; column + 1 < raster->columns(); ++column) {
        const bool a = raster->at(column, row), b = raster->at(column + 1, row);
        const bool c = raster->at(column, row + 1), d = raster->at(column + 1, row + 1);
        if (a != b && a == d && b == c) {
          raster->Cover(a ? column + 1 : column, row);
          changed = true;
        }
      }
    }
  }
}

}  // namespace

FloorCells CellsBelow(const MotionClip& clip) {
  const Skeleton& skeleton = clip.skeleton();
  std::vector<bool> moves(static_cast<std::size_t>(skeleton.joint_count()));
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    moves[j] = j == skeleton.moving_root() || (skeleton.parent(j) >= 0 && moves[skeleton.parent(j)]);
  }
  FloorCells cells;
  for (int f = 0; f < clip.frame_count(); ++f) {
    const Eigen::Matrix3Xd positions = ForwardKinematics(clip, f).positions;
    for (int j = 0; j < skeleton.joint_count(); ++j) {
      if (!moves[j]) continue;
      const int from = j == skeleton.moving_root() ? j : skeleton.parent(j);
      const Eigen::Vector2d begin(positions(0, from), positions(2, from)), end(positions(0, j), positions(2, j));
      const int pieces = std::max(1, static_cast<int>(std::ceil((end - begin).norm() / kAlongBone_m)));
      for (int k = 0; k <= pieces; ++k) {
        const Eigen::Vector2d point = begin + (end - begin) * (k / static_cast<double>(pieces));
        cells.push_back(Packed(CellAt(point.x()), CellAt(point.y())));
      }
    }
    if (cells.size() > 200'000) SortUnique(&cells);
  }
  SortUnique(&cells);
  return cells;
}

SweptArea OutlineOf(const std::vector<FloorCells>& clips, double margin_m) {
  SweptArea area;
  area.margin_m = margin_m;
  std::int64_t low[2] = {INT32_MAX, INT32_MAX}, high[2] = {INT32_MIN, INT32_MIN};
  for (const FloorCells& cells : clips) {
    for (const std::uint64_t cell : cells) {
      const std::int64_t at[2] = {ColumnOf(cell), RowOf(cell)};
      for (int i = 0; i < 2; ++i) low[i] = std::min(low[i], at[i]), high[i] = std::max(high[i], at[i]);
    }
  }
  if (low[0] > high[0]) return area;
  // One raster cell holds 2^coarser cells each way.
  int coarser = 0, border = 0;
  double radius = 0;  // in raster cells
  const auto extent = [&](int axis) { return (high[axis] >> coarser) - (low[axis] >> coarser) + 1 + 2 * border; };
  for (;; ++coarser) {
    area.resolution_m = kSweptCell_m * (1 << coarser);
    // A point lies up to 0.71 cells from its cell's middle, the outline is simplified by up to one cell, and between two points of a bone,
    // two cells apart, their discs reach less far, by 0.29 cells at most.
    radius = margin_m / area.resolution_m + 2;
    border = static_cast<int>(std::ceil(radius)) + 2;
    if (extent(0) * extent(1) <= kMaxCells) break;
  }
  Raster marks(static_cast<int>(extent(0)), static_cast<int>(extent(1)));
  for (const FloorCells& cells : clips) {
    for (const std::uint64_t cell : cells) {
      marks.Cover(static_cast<int>((ColumnOf(cell) >> coarser) - (low[0] >> coarser)) + border,
                  static_cast<int>((RowOf(cell) >> coarser) - (low[1] >> coarser)) + border);
    }
  }
  Raster wide = Widened(marks, radius);
  ClosePinches(&wide);

  bp::polygon_90_set_data<int> covered;
  for (int row = 0; row < wide.rows(); ++row) {
    for (int column = 0; column < wide.columns(); ++column) {
      if (!wide.at(column, row)) continue;
      const int first = column;
      while (wide.at(column, row)) ++column;  // ends: the border is not covered
      covered.insert(bp::rectangle_data<int>(first, row, column, row + 1));
    }
  }
  std::vector<bp::polygon_90_with_holes_data<int>> polygons;
  covered.get(polygons);

  const auto ring = [&](auto begin, auto end) {
    std::vector<Eigen::Vector2d> corners;
    for (auto at = begin; at != end; ++at) {
      corners.emplace_back((bp::x(*at) - border + static_cast<double>(low[0] >> coarser)) * area.resolution_m,
                           (bp::y(*at) - border + static_cast<double>(low[1] >> coarser)) * area.resolution_m);
    }
    if (corners.size() > 1 && corners.front() == corners.back()) corners.pop_back();
    return Simplified(corners, area.resolution_m);
  };
  for (const auto& polygon : polygons) {
    FloorRegion& region = area.regions.emplace_back();
    region.outline_m = ring(polygon.begin(), polygon.end());
    area.area_m2 += PolygonArea(region.outline_m);
    for (auto hole = polygon.begin_holes(); hole != polygon.end_holes(); ++hole) {
      std::vector<Eigen::Vector2d> corners = ring(hole->begin(), hole->end());
      const double hole_m2 = PolygonArea(corners);
      if (hole_m2 < kLeastHole_m2) continue;
      area.area_m2 -= hole_m2;
      region.holes_m.push_back(std::move(corners));
    }
  }
  return area;
}

}  // namespace morphograph
