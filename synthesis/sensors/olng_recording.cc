#include "synthesis/sensors/olng_recording.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <stdexcept>
#include <string>

namespace morphograph {
namespace {

constexpr Eigen::Index kOlngBlock = 256;   // readings whose poses are made at a time
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
    for (std::size_t i = 0; i < onwards.size(); ++i) column.paths[i].cost += onwards[i].cost - std::sqrt(column.nearest[i].squared_distance);
  }
}

}  // namespace

std::vector<BasePose> ReconstructRecording(const std::shared_ptr<const OlngModel>& model, const Eigen::MatrixXd& readings) {
  const MotionBase& base = model->base();
  if (readings.rows() != base.accelerations().rows()) {
    throw std::invalid_argument("ReconstructRecording: expected " + std::to_string(base.accelerations().rows()) + " values a reading, got " + std::to_string(readings.rows()));
  }
  if (!readings.allFinite()) throw std::invalid_argument("ReconstructRecording: a reading is not finite");
  if (model->options().pose == OlngPose::kNearest) throw std::invalid_argument("ReconstructRecording: the nearest frame alone needs no paths");
  const std::vector<char> backwards = model->Follows(true);
  LazyNeighbourhoodGraph forward(model->Follows(false), model->options().graph);
  NeighbourStream neighbours(model);
  OlngEstimator estimator(model);
  const Eigen::Index ahead = kWindowsAhead * model->options().graph.window_frames;

  std::vector<BasePose> poses;
  std::deque<OlngColumn> columns;  // of the readings from the first whose pose is not made yet
  Eigen::Index read = 0;
  while (static_cast<Eigen::Index>(poses.size()) < readings.cols()) {
    const auto begin = static_cast<Eigen::Index>(poses.size());
    for (; read < std::min(readings.cols(), begin + kOlngBlock + ahead); ++read) {
      OlngColumn& column = columns.emplace_back();
      column.nearest = neighbours.Next(readings.col(read));
      column.paths = forward.Update(column.nearest);
    }
    const Eigen::Index count = std::min(kOlngBlock, readings.cols() - begin);
    AddWhatFollows(*model, backwards, count, &columns);
    for (Eigen::Index i = 0; i < count; ++i) {
      poses.push_back(estimator.Next(readings.col(begin + i), std::move(columns.front().paths)));
      columns.pop_front();
    }
  }
  return poses;
}

}  // namespace morphograph
