#include "synthesis/sensors/lazy_neighbourhood_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/random/uniform_int_distribution.hpp>
#include <cmath>
#include <numeric>
#include <random>

#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

constexpr int kBaseFrames = 24;
// Clips of 9, 8 and 7 frames.
std::vector<char> ThreeClips() {
  std::vector<char> follows(kBaseFrames, 1);
  follows[0] = follows[9] = follows[17] = 0;
  return follows;
}

int ClipOf(int frame) { return frame < 9 ? 0 : frame < 17 ? 1 : 2; }

using Columns = std::vector<std::vector<Neighbour>>;

Columns RandomColumns(int readings, int neighbours, std::mt19937_64& rng) {
  Columns columns;
  for (int t = 0; t < readings; ++t) {
    std::vector<int> frames(kBaseFrames);
    std::iota(frames.begin(), frames.end(), 0);
    std::vector<Neighbour> column;
    for (int k = 0; k < neighbours; ++k) {
      const int at = boost::random::uniform_int_distribution<int>(k, kBaseFrames - 1)(rng);
      std::swap(frames[static_cast<std::size_t>(k)], frames[static_cast<std::size_t>(at)]);
      const double distance = testing::RandomUniform(0, 3, rng);
      column.push_back({static_cast<float>(distance * distance), frames[static_cast<std::size_t>(k)]});
    }
    columns.push_back(column);
  }
  return columns;
}

// The cost of the best of all paths that end in a node, each written out and summed up reading by reading.
class AllPaths {
 public:
  AllPaths(const Columns& columns, const LazyNeighbourhoodOptions& options) : columns_(columns), options_(options) {}

  double LeastCost(int reading, int frame) {
    last_ = reading;
    best_ = 1e30;
    const Neighbour* node = Find(reading, frame);
    Walk(reading, frame, std::sqrt(node->squared_distance));
    return best_;
  }

 private:
  const Neighbour* Find(int reading, int frame) const {
    if (reading < 0) return nullptr;
    for (const Neighbour& neighbour : columns_[static_cast<std::size_t>(reading)]) {
      if (neighbour.index == frame) return &neighbour;
    }
    return nullptr;
  }
  double Farthest(int reading) const {
    const auto& column = columns_[static_cast<std::size_t>(reading)];
    return std::sqrt(std::max_element(column.begin(), column.end())->squared_distance);
  }
  double Share(int reading) const { return std::pow(1 - 1.0 / options_.window_frames, last_ - reading); }
  double Missing(int reading) const { return Share(reading) * options_.miss_penalty * Farthest(reading); }

  void Walk(int reading, int frame, double cost) {
    double as_it_begins_here = cost;
    for (int r = 0; r < reading; ++r) as_it_begins_here += Missing(r);
    best_ = std::min(best_, as_it_begins_here);
    const double odd_step = Share(reading - 1) * options_.step_penalty * Farthest(reading);
    const struct { int readings, frames; double extra; } steps[] = {{1, 1, 0}, {1, 2, odd_step}, {2, 1, odd_step}};
    for (const auto& step : steps) {
      const int from = frame - step.frames;
      if (from < 0 || ClipOf(from) != ClipOf(frame)) continue;
      const Neighbour* node = Find(reading - step.readings, from);
      if (!node) continue;
      double total = cost + step.extra + Share(reading - step.readings) * std::sqrt(node->squared_distance);
      if (step.readings == 2) total += Missing(reading - 1);
      Walk(reading - step.readings, from, total);
    }
  }

  const Columns& columns_;
  const LazyNeighbourhoodOptions& options_;
  int last_ = 0;
  double best_ = 0;
};

TEST(LazyNeighbourhoodGraph, CostsAreThoseOfTheBestOfAllPaths) {
  std::mt19937_64 rng(11);
  for (const LazyNeighbourhoodOptions& options : {LazyNeighbourhoodOptions{4, 0.1, 1}, LazyNeighbourhoodOptions{32, 0.5, 1.5}, LazyNeighbourhoodOptions{2, 0, 1}}) {
    const Columns columns = RandomColumns(9, 12, rng);
    LazyNeighbourhoodGraph graph(ThreeClips(), options);
    AllPaths all(columns, options);
    int joined = 0;
    for (int t = 0; t < 9; ++t) {
      const std::vector<NeighbourPath>& paths = graph.Update(columns[static_cast<std::size_t>(t)]);
      ASSERT_EQ(paths.size(), 12U);
      for (std::size_t k = 0; k < paths.size(); ++k) {
        EXPECT_EQ(paths[k].frame, columns[static_cast<std::size_t>(t)][k].index);
        EXPECT_NEAR(paths[k].cost, all.LeastCost(t, paths[k].frame), 1e-4) << "reading " << t << ", frame " << paths[k].frame;
        if (paths[k].previous < 0) continue;
        ++joined;
        EXPECT_EQ(ClipOf(paths[k].previous), ClipOf(paths[k].frame));
        EXPECT_GE(paths[k].frame - paths[k].previous, 1);
        EXPECT_LE(paths[k].frame - paths[k].previous, 2);
      }
    }
    EXPECT_GT(joined, 20);
  }
}

TEST(LazyNeighbourhoodGraph, PathsNeverCrossTheBordersOfClips) {
  LazyNeighbourhoodGraph graph(ThreeClips(), {});
  // From the last frames of one clip to the first of the next.
  for (int frame = 6; frame < 12; ++frame) {
    const std::vector<NeighbourPath> paths = graph.Update({{0, frame}, {9, 20}});
    if (frame == 6 || frame == 9) {
      EXPECT_EQ(paths[0].previous, -1) << frame;
    } else {
      EXPECT_EQ(paths[0].previous, frame - 1);
    }
  }
}

TEST(LazyNeighbourhoodGraph, LongPathsArePreferredToNearFrames) {
  LazyNeighbourhoodGraph graph(ThreeClips(), {});
  for (int frame = 0; frame < 5; ++frame) graph.Update({{1, frame}, {4, 20}});
  // Frame 12 is nearer, and nothing led there.
  const std::vector<NeighbourPath>& paths = graph.Update({{1, 5}, {0.5, 12}, {4, 20}});
  EXPECT_LT(paths[0].cost, paths[1].cost);
}

TEST(LazyNeighbourhoodGraph, TempoIsThatOfTheSteps) {
  std::vector<char> follows(400, 1);
  for (const auto& [tempo, steps] : {std::pair(2.0, std::vector<int>{2}), std::pair(1.0, std::vector<int>{1}), std::pair(1.5, std::vector<int>{1, 2})}) {
    LazyNeighbourhoodGraph graph(follows, {});
    int frame = 0;
    for (std::size_t t = 0; t < 80; ++t) {
      graph.Update({{0, frame}, {1, 399}});
      frame += steps[t % steps.size()];
    }
    EXPECT_NEAR(graph.paths()[0].tempo, tempo, 0.06);
  }
  // One frame every second reading.
  LazyNeighbourhoodGraph graph(follows, {});
  for (int t = 0; t < 80; ++t) graph.Update({{0, t % 2 == 0 ? t / 2 : 398}, {1, 200}});
  graph.Update({{0, 40}, {1, 200}});
  EXPECT_NEAR(graph.paths()[0].tempo, 0.5, 0.01);
}

TEST(LazyNeighbourhoodGraph, RefusesWhatIsNotOfTheBase) {
  LazyNeighbourhoodGraph graph(ThreeClips(), {});
  EXPECT_THROW(graph.Update({}), std::invalid_argument);
  EXPECT_THROW(graph.Update({{0, kBaseFrames}}), std::invalid_argument);
  EXPECT_THROW(graph.Update({{0, -1}}), std::invalid_argument);
  EXPECT_THROW(LazyNeighbourhoodGraph(ThreeClips(), {.window_frames = 0}), std::invalid_argument);
  EXPECT_THROW(LazyNeighbourhoodGraph(ThreeClips(), {.miss_penalty = 0.5}), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
