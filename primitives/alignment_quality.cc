#include "primitives/alignment_quality.h"

#include <stdexcept>
#include <string>

#include "primitives/frame_distance.h"

namespace morphograph {
namespace {

Eigen::Vector2d FloorPoint(const Eigen::Vector3d& point) { return {point.x(), point.z()}; }

// One transform for all cells of the warp: the poses of all cells are one cloud of points.
PlanarTransform SegmentTransform(const std::vector<Eigen::Matrix3Xd>& reference, const std::vector<Eigen::Matrix3Xd>& test,
                                 const Eigen::VectorXd& weights, const WarpPath& warp) {
  const Eigen::Index joints = weights.size(), cells = static_cast<Eigen::Index>(warp.cells.size());
  Eigen::Matrix3Xd a(3, joints * cells), b(3, joints * cells);
  for (Eigen::Index i = 0; i < cells; ++i) {
    a.middleCols(i * joints, joints) = reference[warp.cells[i].reference];
    b.middleCols(i * joints, joints) = test[warp.cells[i].test];
  }
  PlanarTransform best;
  FrameDistance(a, b, weights.replicate(cells, 1), &best);
  return best;
}

}  // namespace

SegmentAlignment AlignSegment(const std::vector<Eigen::Matrix3Xd>& reference, const std::vector<Eigen::Matrix3Xd>& test,
                              const Eigen::VectorXd& weights, int root, AlignmentTransform transform) {
  if (root < 0 || root >= weights.size())
    throw std::invalid_argument("AlignSegment: root " + std::to_string(root) + " of " + std::to_string(weights.size()) + " joints");
  SegmentAlignment aligned;
  aligned.distances = FrameDistanceMatrix(reference, test, weights);
  aligned.warp = DynamicTimeWarp(aligned.distances);
  aligned.matched.assign(reference.size(), -1);
  for (const WarpCell& cell : aligned.warp.cells) {
    int& best = aligned.matched[cell.reference];
    if (best < 0 || aligned.distances(cell.reference, cell.test) < aligned.distances(cell.reference, best)) best = cell.test;
  }
  PlanarTransform move;
  if (transform == AlignmentTransform::kSegment) move = SegmentTransform(reference, test, weights, aligned.warp);
  aligned.root.resize(2, static_cast<Eigen::Index>(reference.size()));
  for (size_t i = 0; i < reference.size(); ++i) {
    const Eigen::Matrix3Xd& pose = test[aligned.matched[i]];
    if (transform == AlignmentTransform::kEachFrame) FrameDistance(reference[i], pose, weights, &move);
    aligned.root.col(static_cast<Eigen::Index>(i)) = FloorPoint(move * pose.col(root));
  }
  return aligned;
}

Eigen::Matrix2Xd FloorPath(const std::vector<Eigen::Matrix3Xd>& frames, int joint) {
  Eigen::Matrix2Xd path(2, static_cast<Eigen::Index>(frames.size()));
  for (size_t f = 0; f < frames.size(); ++f) path.col(static_cast<Eigen::Index>(f)) = FloorPoint(frames[f].col(joint));
  return path;
}

double PathDifference(const Eigen::Matrix2Xd& a, const Eigen::Matrix2Xd& b) {
  if (a.cols() != b.cols() || a.cols() == 0)
    throw std::invalid_argument("PathDifference: paths of " + std::to_string(a.cols()) + " and " + std::to_string(b.cols()) + " frames");
  return (a - b).colwise().norm().mean();
}

std::vector<double> PathSpeeds(const Eigen::Matrix2Xd& path, double frame_rate_hz) {
  std::vector<double> speeds;
  for (Eigen::Index f = 1; f < path.cols(); ++f) speeds.push_back((path.col(f) - path.col(f - 1)).norm() * frame_rate_hz);
  return speeds;
}

double SpeedVariance(const Eigen::Matrix2Xd& path, double frame_rate_hz) {
  const std::vector<double> speeds = PathSpeeds(path, frame_rate_hz);
  if (speeds.size() < 2) return 0;
  const Eigen::Map<const Eigen::ArrayXd> s(speeds.data(), static_cast<Eigen::Index>(speeds.size()));
  return (s - s.mean()).square().mean();
}

}  // namespace morphograph
