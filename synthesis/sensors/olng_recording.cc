#include "synthesis/sensors/olng_recording.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "synthesis/sensors/neighbour_stream.h"
#include "synthesis/sensors/path_poser.h"

namespace morphograph {
namespace {

constexpr Eigen::Index kOlngBlock = 256;   // readings whose paths are made whole at a time
constexpr Eigen::Index kWindowsAhead = 8;   // looked ahead: what is farther counts less than a thousandth

// A reading's neighbours and the paths that end in them, in the same order.
struct OlngColumn {
  std::vector<Neighbour> nearest;
  std::vector<NeighbourPath> paths;
};

// Adds what going on from each of the first `count` columns costs to the paths that end there.
void AddWhatFollows(const OlngModel& model, const std::vector<char>& follows, Eigen::Index count, std::deque<OlngColumn>* columns) {
  LazyNeighbourhoodGraph graph(follows, model.options().graph);
  const int last = static_cast<int>(follows.size()) - 1;
  for (std::size_t t = columns->size(); t-- > 0;) {
    OlngColumn& column = (*columns)[t];
    std::vector<Neighbour> mirrored = column.nearest;
    for (Neighbour& neighbour : mirrored) neighbour.index = last - neighbour.index;
    const std::vector<NeighbourPath>& onwards = graph.Update(mirrored);
    if (static_cast<Eigen::Index>(t) >= count) continue;
    for (std::size_t i = 0; i < onwards.size(); ++i) {
      column.paths[i].cost += onwards[i].cost - std::sqrt(column.nearest[i].squared_distance);
      column.paths[i].tempo = 0.5F * (column.paths[i].tempo + onwards[i].tempo);
    }
  }
}

// Paths that can come into a pose: the I of least cost and the next, which their weights are measured from.
void KeepCheapest(const OlngModel& model, std::vector<NeighbourPath>* paths) {
  const auto count = static_cast<std::size_t>(model.options().paths) + 1;
  if (paths->size() <= count) return;
  std::nth_element(paths->begin(), paths->begin() + static_cast<std::ptrdiff_t>(count), paths->end(), IsCheaper);
  paths->resize(count);
  paths->shrink_to_fit();
}

// The best paths of every reading, each counted whole: what comes before its frame and what comes after.
std::vector<std::vector<NeighbourPath>> PathsOf(const std::shared_ptr<const OlngModel>& model, const Eigen::MatrixXd& readings) {
  const std::vector<char> backwards = model->Follows(TimeDirection::kBackwards);
  LazyNeighbourhoodGraph forward(model->Follows(TimeDirection::kForwards), model->options().graph);
  NeighbourStream neighbours(model);
  const Eigen::Index ahead = kWindowsAhead * model->options().graph.window_frames;

  std::vector<std::vector<NeighbourPath>> paths;
  std::deque<OlngColumn> columns;  // of the readings from the first whose paths are not whole yet
  Eigen::Index read = 0;
  while (static_cast<Eigen::Index>(paths.size()) < readings.cols()) {
    const auto begin = static_cast<Eigen::Index>(paths.size());
    for (; read < std::min(readings.cols(), begin + kOlngBlock + ahead); ++read) {
      OlngColumn& column = columns.emplace_back();
      column.nearest = neighbours.Next(readings.col(read));
      column.paths = forward.Update(column.nearest);
    }
    const Eigen::Index count = std::min(kOlngBlock, readings.cols() - begin);
    AddWhatFollows(*model, backwards, count, &columns);
    for (Eigen::Index i = 0; i < count; ++i) {
      KeepCheapest(*model, &columns.front().paths);
      paths.push_back(std::move(columns.front().paths));
      columns.pop_front();
    }
  }
  return paths;
}

// `share` of the way from one pose to the other.
BasePose Between(const BasePose& a, const BasePose& b, double share) {
  return {.rotations = a.rotations + share * (b.rotations - a.rotations), .step = a.step + share * (b.step - a.step), .height_m = a.height_m + share * (b.height_m - a.height_m)};
}

}  // namespace

std::vector<BasePose> ReconstructRecording(const std::shared_ptr<const OlngModel>& model, const Eigen::MatrixXd& readings) {
  for (Eigen::Index t = 0; t < readings.cols(); ++t) model->Check(readings.col(t));
  PathPoser forwards(model, TimeDirection::kForwards), backwards(model, TimeDirection::kBackwards);
  const std::vector<std::vector<NeighbourPath>> paths = PathsOf(model, readings);
  std::vector<BasePose> poses(paths.size());
  // Each direction counts as far as its pose before was trusted: not at all where it begins.
  std::vector<double> trusts(paths.size());
  for (std::size_t t = 0; t < paths.size(); ++t) {
    trusts[t] = forwards.trust();
    poses[t] = forwards.Next(readings.col(static_cast<Eigen::Index>(t)), paths[t]);
  }
  for (std::size_t t = paths.size(); t-- > 0;) {
    const double trust = backwards.trust(), both = trusts[t] + trust;
    poses[t] = Between(poses[t], backwards.Next(readings.col(static_cast<Eigen::Index>(t)), paths[t]), both > 0 ? trust / both : 0.5);
  }
  return poses;
}

}  // namespace morphograph
