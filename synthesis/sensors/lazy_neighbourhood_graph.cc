#include "synthesis/sensors/lazy_neighbourhood_graph.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace morphograph {
namespace {

// Readings over which a path's tempo is averaged; single steps are 1/2, 1 or 2 and would jitter.
constexpr float kTempoWindow = 10;

}  // namespace

LazyNeighbourhoodGraph::LazyNeighbourhoodGraph(std::vector<char> follows, const LazyNeighbourhoodOptions& options)
    : follows_(std::move(follows)),
      forgetting_(static_cast<float>(1 - 1.0 / options.window_frames)),
      step_penalty_(static_cast<float>(options.step_penalty)),
      miss_penalty_(static_cast<float>(options.miss_penalty)) {
  if (options.window_frames < 1) throw std::invalid_argument("LazyNeighbourhoodGraph: window_frames must be 1 or more");
  if (!(options.step_penalty >= 0 && options.miss_penalty >= 1))
    throw std::invalid_argument("LazyNeighbourhoodGraph: step_penalty must be 0 or more, miss_penalty 1 or more");
  if (!follows_.empty()) follows_.front() = 0;  // nothing comes before it
  for (Column* column : {&newest_, &before_, &older_}) column->slot_of.assign(follows_.size(), -1);
}

const NeighbourPath* LazyNeighbourhoodGraph::Find(const Column& column, int frame) {
  const int slot = column.slot_of[static_cast<std::size_t>(frame)];
  return slot < 0 ? nullptr : &column.paths[static_cast<std::size_t>(slot)];
}

const std::vector<NeighbourPath>& LazyNeighbourhoodGraph::Update(const std::vector<Neighbour>& nearest) {
  if (nearest.empty()) throw std::invalid_argument("LazyNeighbourhoodGraph: a reading has no neighbours");
  float farthest = 0;
  for (const Neighbour& neighbour : nearest) {
    if (neighbour.index < 0 || neighbour.index >= static_cast<int>(follows_.size()))
      throw std::invalid_argument("LazyNeighbourhoodGraph: frame " + std::to_string(neighbour.index) + " is not of the base");
    farthest = std::max(farthest, neighbour.squared_distance);
  }
  // The oldest column goes and its memory becomes the newest.
  std::swap(older_, before_);
  std::swap(before_, newest_);
  for (const NeighbourPath& path : newest_.paths) newest_.slot_of[static_cast<std::size_t>(path.frame)] = -1;
  newest_.paths.clear();

  newest_.gap = miss_penalty_ * std::sqrt(farthest);
  const float step_cost = step_penalty_ * std::sqrt(farthest);
  for (const Neighbour& neighbour : nearest) {
    const int frame = neighbour.index;
    NeighbourPath path{.frame = frame, .cost = before_.missed};
    const auto consider = [&](const NeighbourPath* from, float extra, float step) {
      if (!from || !(forgetting_ > 0)) return;
      const float cost = step == 0.5F ? before_.gap + forgetting_ * from->cost + extra : from->cost + extra;
      // A path that is as dear as no past at all is still the better guess of the tempo and the frame before.
      if (cost > path.cost || (cost == path.cost && path.previous >= 0)) return;
      path.cost = cost;
      path.previous = from->frame;
      path.tempo = from->tempo + (step - from->tempo) / kTempoWindow;
    };
    if (follows_[static_cast<std::size_t>(frame)]) {
      consider(Find(before_, frame - 1), 0, 1);
      if (follows_[static_cast<std::size_t>(frame - 1)]) consider(Find(before_, frame - 2), step_cost, 2);
      consider(Find(older_, frame - 1), step_cost, 0.5F);
    }
    path.cost = std::sqrt(neighbour.squared_distance) + forgetting_ * path.cost;
    newest_.slot_of[static_cast<std::size_t>(frame)] = static_cast<int>(newest_.paths.size());
    newest_.paths.push_back(path);
  }
  newest_.missed = newest_.gap + forgetting_ * before_.missed;
  return newest_.paths;
}

}  // namespace morphograph
