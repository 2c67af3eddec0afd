#include "tests/benchmarks/leg_poses.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "datasets/forward_kinematics.h"
#include "datasets/quantile.h"

namespace morphograph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

double Rms_cm(const LegPlaces& off) { return 100 * std::sqrt(off.colwise().squaredNorm().mean()); }

}  // namespace

double LegLength(const LegJoints& joints) {
  double length = 0;
  for (int side = 0; side < 2; ++side) length += ((joints.col(side) - joints.col(2 + side)).norm() + (joints.col(2 + side) - joints.col(4 + side)).norm()) / 2;
  return length;
}

LegPlaces PlacesOfLegs(const LegJoints& joints, double length_m) {
  const Vector3d middle = (joints.col(0) + joints.col(1)) / 2;
  Vector3d left = joints.col(0) - joints.col(1);
  left.y() = 0;
  left.normalize();
  Matrix3d axes;
  axes << left, Vector3d::UnitY(), left.cross(Vector3d::UnitY());
  return length_m / LegLength(joints) * (axes.transpose() * (joints.rightCols<4>().colwise() - middle));
}

std::vector<LegPlaces> PlacesOfLegs(const MotionClip& clip, double length_m) {
  std::vector<LegPlaces> places;
  for (int f = 0; f < clip.frame_count(); ++f) {
    const WorldPose pose = ForwardKinematics(clip, f);
    LegJoints joints;
    for (int j = 0; j < 6; ++j) joints.col(j) = pose.positions.col(clip.skeleton().roles()[kLegRoles[j]]);
    places.push_back(PlacesOfLegs(joints, length_m));
  }
  return places;
}

LegPlaces MeanOf(const std::vector<LegPlaces>& places) {
  LegPlaces mean = LegPlaces::Zero();
  for (const LegPlaces& place : places) mean += place / static_cast<double>(places.size());
  return mean;
}

void PrintErrors(const std::string& name, const std::vector<LegPlaces>& found, const std::vector<LegPlaces>& truth) {
  const std::size_t frames = std::min(found.size(), truth.size());
  std::vector<LegPlaces> off;
  for (std::size_t f = 0; f < frames; ++f) off.push_back(found[f] - truth[f]);
  const LegPlaces constant = MeanOf(off);
  std::vector<double> errors, moving;
  double mean = 0, moving_mean = 0;
  for (const LegPlaces& o : off) {
    errors.push_back(Rms_cm(o));
    moving.push_back(Rms_cm(o - constant));
    mean += errors.back() / static_cast<double>(frames);
    moving_mean += moving.back() / static_cast<double>(frames);
  }
  std::printf("  %-56s %6.2f %6.2f %10.2f %6.2f\n", name.c_str(), mean, Quantile(errors, 0.95), moving_mean, Quantile(moving, 0.95));
  std::fflush(stdout);
}

std::vector<LegPlaces> NearestPoses(const std::vector<MotionClip>& clips, const std::vector<LegPlaces>& truth, double length_m) {
  std::vector<LegPlaces> base;
  for (const MotionClip& clip : clips) {
    for (const LegPlaces& place : PlacesOfLegs(clip, length_m)) base.push_back(place);
  }
  Eigen::MatrixXf columns(12, static_cast<Eigen::Index>(base.size()));
  for (std::size_t i = 0; i < base.size(); ++i) columns.col(static_cast<Eigen::Index>(i)) = base[i].reshaped().cast<float>();
  std::vector<LegPlaces> nearest;
  for (const LegPlaces& place : truth) {
    Eigen::Index best = 0;
    (columns.colwise() - Eigen::VectorXf(place.reshaped().cast<float>())).colwise().squaredNorm().minCoeff(&best);
    nearest.push_back(base[static_cast<std::size_t>(best)]);
  }
  return nearest;
}

}  // namespace morphograph
