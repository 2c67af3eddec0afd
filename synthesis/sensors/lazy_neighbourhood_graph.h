#pragma once

#include <vector>

#include "synthesis/sensors/neighbour_search.h"

namespace morphograph {

struct LazyNeighbourhoodOptions {
  int window_frames = 16;    // M: how far back the past counts
  double step_penalty = 0.3;  // of a step other than one frame of the base a reading, in distances of the column's farthest neighbour
  double miss_penalty = 1.0;  // of a reading that a path has no neighbour for, in the same distances; 1 or more
};

/// A way through the base that was like the readings, seen from its last frame.
struct NeighbourPath {
  int frame = 0;      // of the base, where it ends
  int previous = -1;  // its frame before that; -1: it begins here
  float tempo = 1;    // frames of the base that it went on by a reading, of late; 1 where it begins
  float cost = 0;
};

/// Order of paths by cost, and by frame where costs are the same.
inline bool IsCheaper(const NeighbourPath& a, const NeighbourPath& b) { return a.cost != b.cost ? a.cost < b.cost : a.frame < b.frame; }

/// Online lazy neighbourhood graph (Tautges et al. 2011, section 4): joins nearest neighbours of one reading after the other to paths through the base.
///
/// Nodes are the K nearest frames of a reading. A path goes on from (reading, frame) to (+1, +1), (+1, +2) or (+2, +1): forwards in time, never more than twice
/// as fast or slow, never from one clip to another. The least cost of a path that ends in node n of reading t is
///
///   c_t(n) = d_t(n) + a min( c_{t-1}(n-1), c_{t-1}(n-2) + s_t, g_{t-1} + a c_{t-2}(n-1) + s_t, m_{t-1} ),    m_t = g_t + a m_{t-1},
///
/// with the distance d of reading and frame, forgetting a = 1 - 1/M, and g_t = miss_penalty * the distance of the farthest of the K, which is the
/// least that a frame not among them can have: a skipped reading costs that, and m is the cost of a past that has no neighbours at all, which is where
/// paths begin. So long paths are preferred, and short ones are there when there is nothing better.
///
/// Differs from the source, which keeps M columns and gives no formula for the cost: with an exponential window two columns are enough, and a path may become as
/// old as it likes while what is older than M readings counts ever less. A table of all frames says where in a column a frame is, so that an update costs O(K).
class LazyNeighbourhoodGraph {
 public:
  /// @param follows  for every frame of the base: whether the frame before it is of the same clip.
  /// @throws std::invalid_argument for a window below 1, or penalties that are negative or miss_penalty below 1.
  LazyNeighbourhoodGraph(std::vector<char> follows, const LazyNeighbourhoodOptions& options);

  /// Takes the nearest frames of the next reading in any order, each once. @return a path that ends in each, in the same order; valid until the next call.
  /// @throws std::invalid_argument for no neighbours or frames that are not of the base.
  const std::vector<NeighbourPath>& Update(const std::vector<Neighbour>& nearest);

  const std::vector<NeighbourPath>& paths() const { return newest_.paths; }

 private:
  struct Column {
    std::vector<NeighbourPath> paths;
    std::vector<int> slot_of;  // by frame of the base: its place in `paths`, or -1
    float gap = 0;             // g
    float missed = 0;          // m
  };
  static const NeighbourPath* Find(const Column& column, int frame);

  std::vector<char> follows_;
  float forgetting_, step_penalty_, miss_penalty_;
  Column newest_, before_, older_;
};

}  // namespace morphograph
