#include "synthesis/ground_plane.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "datasets/quantile.h"

namespace morphograph {
namespace {

// Spread of stance heights on a flat floor and of floor slopes; their ratio is the ridge.
constexpr double kStanceSigma_m = 0.005;
constexpr double kSlopeSigma = 0.01;
constexpr double kStillSpeed_m_s = 0.3;
constexpr int kReweightings = 4;

// The smaller of backward and forward difference, as in contact detection: a frame next to a still one is
// still.
bool IsStill(const Eigen::Matrix3Xd& path, int frame, double frame_rate_hz) {
  const double limit = kStillSpeed_m_s / frame_rate_hz;
  const auto step_is_short = [&](int from) {
    return from >= 0 && from + 1 < path.cols() && (path.col(from + 1) - path.col(from)).norm() < limit;
  };
  return step_is_short(frame - 1) || step_is_short(frame);
}

std::vector<Eigen::Vector3d> StancePoints(const ContactTrack& contacts, double frame_rate_hz) {
  std::vector<Eigen::Vector3d> points;
  std::vector<double> x, y, z;
  for (const ContactInterval& interval : contacts.intervals) {
    const Eigen::Matrix3Xd& ball = contacts.balls[interval.foot == Foot::kLeft ? 0 : 1];
    x.clear(), y.clear(), z.clear();
    for (int f = interval.first; f <= interval.last; ++f) {
      if (!IsStill(ball, f, frame_rate_hz)) continue;
      x.push_back(ball(0, f)), y.push_back(ball(1, f)), z.push_back(ball(2, f));
    }
    if (!y.empty()) points.emplace_back(Median(x), Median(y), Median(z));
  }
  return points;
}

}  // namespace

GroundPlane FitGroundPlane(const ContactTrack& contacts, double frame_rate_hz) {
  const Eigen::Index frames = contacts.balls[0].cols();
  if (frames == 0 || contacts.balls[1].cols() != frames) {
    throw std::invalid_argument("FitGroundPlane: contacts of at least one frame are needed, both feet alike");
  }
  if (!(frame_rate_hz > 0)) throw std::invalid_argument("FitGroundPlane: the frame rate must be positive");
  const std::vector<Eigen::Vector3d> points = StancePoints(contacts, frame_rate_hz);
  GroundPlane plane;
  if (points.empty()) {
    std::vector<double> lower(static_cast<size_t>(frames));
    for (Eigen::Index f = 0; f < frames; ++f) {
      lower[static_cast<size_t>(f)] = std::min(contacts.balls[0](1, f), contacts.balls[1](1, f));
    }
    plane.height_m = Quantile(lower, 0.05);
    return plane;
  }

  // Centred, so that the ridge pulls the slopes alone and the answer does not depend on where the clip is.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) centre += point / static_cast<double>(points.size());
  const double ridge = std::pow(kStanceSigma_m / kSlopeSigma, 2);
  std::vector<double> weights(points.size(), 1.0);
  Eigen::Vector3d fit(centre.y(), 0, 0);  // height at the centre, slope x, slope z
  for (int round = 0; round < kReweightings; ++round) {
    Eigen::Matrix3d normal = Eigen::Vector3d(0, ridge, ridge).asDiagonal();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d row(1, points[i].x() - centre.x(), points[i].z() - centre.z());
      normal += weights[i] * row * row.transpose();
      right += weights[i] * points[i].y() * row;
    }
    fit = normal.ldlt().solve(right);
    for (size_t i = 0; i < points.size(); ++i) {
      const double residual = std::abs(points[i].y() - fit.dot(Eigen::Vector3d(1, points[i].x() - centre.x(),
                                                                               points[i].z() - centre.z())));
      weights[i] = residual <= kStanceSigma_m ? 1.0 : kStanceSigma_m / residual;
    }
  }
  plane.slope_x = fit[1];
  plane.slope_z = fit[2];
  plane.height_m = fit[0] - fit[1] * centre.x() - fit[2] * centre.z();
  return plane;
}

}  // namespace morphograph
