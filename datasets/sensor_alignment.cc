#include "datasets/sensor_alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "datasets/foot_strikes.h"
#include "datasets/forward_kinematics.h"
#include "datasets/low_pass.h"
#include "datasets/virtual_sensors.h"

namespace morphograph {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

constexpr int kLeastAlignedSamples = 50;
constexpr double kLeastWidth_m = 0.002;  // of the markers across their line
constexpr int kShapeRounds = 3;

Eigen::MatrixXd SecondDifference(const Eigen::MatrixXd& values, double rate_hz) {
  Eigen::MatrixXd second(values.rows(), values.cols());
  for (Index i = 0; i < values.cols(); ++i) {
    const Index middle = std::clamp<Index>(i, 1, values.cols() - 2);
    second.col(i) = (values.col(middle + 1) - 2 * values.col(middle) + values.col(middle - 1)) * rate_hz * rate_hz;
  }
  return second;
}

// What a sensor at the segment's origin reads, in the segment's axes, and how that changes with the lever arm.
struct SegmentAcceleration {
  Matrix3Xd at_origin;           // R^T (p'' - g)
  std::vector<Matrix3d> lever;   // R^T R''
};

SegmentAcceleration AccelerationOf(const SegmentMotion& segment, double cutoff_hz) {
  const int samples = segment.sample_count();
  Eigen::MatrixXd rotations(9, samples);
  for (int i = 0; i < samples; ++i) rotations.col(i) = Eigen::Map<const Eigen::Matrix<double, 9, 1>>(segment.rotations[static_cast<std::size_t>(i)].data());
  const Eigen::MatrixXd moves = SecondDifference(LowPass(segment.positions, segment.rate_hz, cutoff_hz), segment.rate_hz);
  const Eigen::MatrixXd turns = SecondDifference(LowPass(rotations, segment.rate_hz, cutoff_hz), segment.rate_hz);
  SegmentAcceleration acceleration;
  acceleration.at_origin.resize(3, samples);
  for (int i = 0; i < samples; ++i) {
    const Matrix3d& rotation = segment.rotations[static_cast<std::size_t>(i)];
    acceleration.at_origin.col(i) = rotation.transpose() * (moves.col(i) + Vector3d(0, kGravity_m_s2, 0));
    const Vector3d packed[3] = {turns.col(i).head<3>(), turns.col(i).segment<3>(3), turns.col(i).tail<3>()};
    Matrix3d turn;
    turn << packed[0], packed[1], packed[2];
    acceleration.lever.push_back(rotation.transpose() * turn);
  }
  return acceleration;
}

Matrix3Xd WithLever(const SegmentAcceleration& acceleration, const Vector3d& offset_m) {
  Matrix3Xd readings = acceleration.at_origin;
  for (Index i = 0; i < readings.cols(); ++i) readings.col(i) += acceleration.lever[static_cast<std::size_t>(i)] * offset_m;
  return readings;
}

Vector3d BestLever(const SegmentAcceleration& acceleration, const Matrix3Xd& in_segment, Index first) {
  Matrix3d normal = 1e-9 * Matrix3d::Identity();  // a segment that never turns has no lever
  Vector3d right = Vector3d::Zero();
  for (Index i = 0; i < in_segment.cols(); ++i) {
    const Matrix3d& lever = acceleration.lever[static_cast<std::size_t>(first + i)];
    normal += lever.transpose() * lever;
    right += lever.transpose() * (in_segment.col(i) - acceleration.at_origin.col(first + i));
  }
  return normal.llt().solve(right);
}

// Tilt from gravity while standing, then the yaw about it, in closed form.
Matrix3d FirstRotation(const Matrix3Xd& sensor, const Matrix3Xd& segment, double rate_hz, double least_standing_s) {
  const auto phases = StillPhases(sensor, rate_hz, least_standing_s);
  if (phases.empty()) return BestRotation(sensor, segment);
  const auto longest = *std::max_element(phases.begin(), phases.end(), [](const auto& a, const auto& b) { return a.second - a.first < b.second - b.first; });
  const Index count = longest.second - longest.first + 1;
  const Vector3d up_sensor = sensor.middleCols(longest.first, count).rowwise().mean().normalized();
  const Vector3d up_segment = segment.middleCols(longest.first, count).rowwise().mean().normalized();
  const Matrix3d tilt = Eigen::Quaterniond::FromTwoVectors(up_sensor, up_segment).toRotationMatrix();
  double along = 0, across = 0;
  for (Index i = 0; i < sensor.cols(); ++i) {
    const Vector3d a = tilt * sensor.col(i), b = segment.col(i);
    const Vector3d flat_a = a - a.dot(up_segment) * up_segment, flat_b = b - b.dot(up_segment) * up_segment;
    along += flat_a.dot(flat_b);
    across += up_segment.dot(flat_a.cross(flat_b));
  }
  return Eigen::AngleAxisd(std::atan2(across, along), up_segment).toRotationMatrix() * tilt;
}

// Samples that both have when the sensor's come `delay` later: from `first` of the segment, `count` of them.
struct Overlap {
  Index first, count;
  Overlap(Index segment, Index sensor, int delay) : first(std::max(0, -delay)), count(std::max<Index>(0, std::min(segment, sensor - delay) - first)) {}
};

struct AlignmentFit {
  SensorAlignment alignment;
  double mean_square = std::numeric_limits<double>::infinity();
};

AlignmentFit FitAtDelay(const SegmentAcceleration& motion, const Matrix3Xd& smooth, double rate_hz, int delay, const SensorAlignmentOptions& options) {
  AlignmentFit fit;
  fit.alignment.delay_samples = delay;
  const Overlap overlap(motion.at_origin.cols(), smooth.cols(), delay);
  if (overlap.count < kLeastAlignedSamples) return fit;
  const Matrix3Xd sensor = smooth.middleCols(overlap.first + delay, overlap.count);
  Matrix3d rotation = FirstRotation(sensor, motion.at_origin.middleCols(overlap.first, overlap.count), rate_hz, options.least_standing_s);
  Matrix3Xd expected;
  for (int round = 0; round < options.rounds; ++round) {
    fit.alignment.offset_m = BestLever(motion, rotation * sensor, overlap.first);
    expected = WithLever(motion, fit.alignment.offset_m).middleCols(overlap.first, overlap.count);
    rotation = BestRotation(sensor, expected);
  }
  fit.alignment.segment_from_sensor = Eigen::Quaterniond(rotation);
  fit.mean_square = (rotation * sensor - expected).squaredNorm() / static_cast<double>(overlap.count);
  return fit;
}

Eigen::MatrixXd Moments(const Matrix3Xd& centred) {
  // Second moments (6) and third (10) of a sample, each scaled to the size of an acceleration so that both count.
  Eigen::MatrixXd moments = Eigen::MatrixXd::Zero(16, 1);
  int row = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      const double mean = (centred.row(i).array() * centred.row(j).array()).mean();
      moments(row++) = (mean < 0 ? -1 : 1) * std::sqrt(std::abs(mean));
      for (int k = j; k < 3; ++k) {
        const double third = (centred.row(i).array() * centred.row(j).array() * centred.row(k).array()).mean();
        moments(row++) = std::cbrt(third);
      }
    }
  }
  return moments;
}

}  // namespace

Matrix3d BestRotation(const Matrix3Xd& from, const Matrix3Xd& to) {
  const Eigen::JacobiSVD<Matrix3d> svd(Matrix3d(to * from.transpose()), Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

SegmentMotion SegmentFromMarkers(const Readings& markers, const std::vector<std::string>& names) {
  if (names.size() < 3) throw std::invalid_argument("SegmentFromMarkers: 3 or more markers are needed");
  const int samples = markers.sample_count();
  std::vector<Matrix3Xd> seen(static_cast<std::size_t>(samples), Matrix3Xd(3, static_cast<Index>(names.size())));
  for (std::size_t n = 0; n < names.size(); ++n) {
    const auto found = std::find(markers.names.begin(), markers.names.end(), names[n]);
    if (found == markers.names.end()) throw std::invalid_argument("SegmentFromMarkers: there is no marker '" + names[n] + "'");
    const Index row = 3 * (found - markers.names.begin());
    for (int i = 0; i < samples; ++i) seen[static_cast<std::size_t>(i)].col(static_cast<Index>(n)) = markers.values.col(i).segment<3>(row);
  }
  SegmentMotion segment;
  segment.rate_hz = markers.rate_hz();
  segment.positions.resize(3, samples);
  segment.rotations.assign(static_cast<std::size_t>(samples), Matrix3d::Identity());
  if (samples == 0) return segment;
  for (int i = 0; i < samples; ++i) {
    Matrix3Xd& places = seen[static_cast<std::size_t>(i)];
    if (!places.allFinite()) throw std::invalid_argument("SegmentFromMarkers: a marker is lost; repair the stream first");
    segment.positions.col(i) = places.rowwise().mean();
    places.colwise() -= Vector3d(segment.positions.col(i));
  }
  // The mean shape: every sample laid over the shape so far, averaged, and again.
  Matrix3Xd shape = seen[static_cast<std::size_t>(samples / 2)];
  for (int round = 0; round <= kShapeRounds; ++round) {
    Matrix3Xd sum = Matrix3Xd::Zero(3, shape.cols());
    for (std::size_t i = 0; i < seen.size(); ++i) {
      segment.rotations[i] = BestRotation(shape, seen[i]);
      sum += segment.rotations[i].transpose() * seen[i];
    }
    if (round < kShapeRounds) shape = sum / samples;
  }
  const Vector3d spread = Eigen::JacobiSVD<Matrix3d>(Matrix3d(shape * shape.transpose() / static_cast<double>(shape.cols()))).singularValues().cwiseSqrt();
  if (spread[1] < kLeastWidth_m) throw std::invalid_argument("SegmentFromMarkers: the markers lie on a line");
  return segment;
}

SegmentMotion SegmentOfJoint(const MotionClip& clip, int joint) {
  SegmentMotion segment;
  segment.rate_hz = clip.frame_rate_hz();
  segment.positions.resize(3, clip.frame_count());
  WorldPose pose;
  for (int f = 0; f < clip.frame_count(); ++f) {
    ForwardKinematics(clip.skeleton(), clip.rotations(f), clip.root_positions().col(f), &pose);
    segment.positions.col(f) = pose.positions.col(joint);
    segment.rotations.push_back(pose.rotations[static_cast<std::size_t>(joint)].toRotationMatrix());
  }
  return segment;
}

int DelayByCorrelation(const Eigen::MatrixXd& reference, const Eigen::MatrixXd& later, int most) {
  int best = 0;
  double highest = -std::numeric_limits<double>::infinity();
  for (int shift = 0; shift <= 2 * most; ++shift) {
    const int delay = shift % 2 == 0 ? shift / 2 : -(shift + 1) / 2;  // the smaller of two that are as good
    const Overlap overlap(reference.cols(), later.cols(), delay);
    if (overlap.count < 3) continue;
    Eigen::MatrixXd a = reference.middleCols(overlap.first, overlap.count), b = later.middleCols(overlap.first + delay, overlap.count);
    a.colwise() -= Eigen::VectorXd(a.rowwise().mean());
    b.colwise() -= Eigen::VectorXd(b.rowwise().mean());
    const double scale = a.norm() * b.norm(), correlation = scale > 0 ? a.cwiseProduct(b).sum() / scale : 0;
    if (correlation > highest + 1e-12) {
      highest = correlation;
      best = delay;
    }
  }
  return best;
}

SensorAlignment AlignSensor(const SegmentMotion& segment, const Matrix3Xd& accelerations, const SensorAlignmentOptions& options) {
  if (segment.sample_count() < kLeastAlignedSamples || accelerations.cols() < kLeastAlignedSamples) throw std::invalid_argument("AlignSensor: fewer than 50 samples");
  if (!accelerations.allFinite() || !segment.positions.allFinite() || options.rounds < 1) throw std::invalid_argument("AlignSensor: values must be finite (repair the stream first) and rounds 1 or more");
  const Matrix3Xd smooth = LowPass(accelerations, segment.rate_hz, options.cutoff_hz);
  const SegmentAcceleration motion = AccelerationOf(segment, options.cutoff_hz);
  const int most = options.most_delay_samples;
  // The lever arm turns with the segment and shifts the lengths' best delay by a few samples: from there, downhill with everything fitted anew.
  int delay = DelayByCorrelation(motion.at_origin.colwise().norm(), smooth.colwise().norm(), most);
  AlignmentFit best = FitAtDelay(motion, smooth, segment.rate_hz, delay, options);
  for (const int step : {-1, 1}) {
    while (std::abs(best.alignment.delay_samples + step) <= most) {
      const AlignmentFit next = FitAtDelay(motion, smooth, segment.rate_hz, best.alignment.delay_samples + step, options);
      if (!(next.mean_square < best.mean_square * (1 - 1e-9))) break;
      best = next;
    }
  }
  return best.alignment;
}

Matrix3Xd ReadingsOf(const SegmentMotion& segment, const SensorAlignment& alignment, double cutoff_hz) {
  if (segment.sample_count() < 3) throw std::invalid_argument("ReadingsOf: fewer than 3 samples");
  return alignment.segment_from_sensor.toRotationMatrix().transpose() * WithLever(AccelerationOf(segment, cutoff_hz), alignment.offset_m);
}

AlignmentQuality MeasureAlignment(const SegmentMotion& segment, const Matrix3Xd& accelerations, const SensorAlignment& alignment, int first, int last, double cutoff_hz) {
  const int delay = alignment.delay_samples;
  if (first < 0 || last < first || last >= segment.sample_count() || first + delay < 0 || last + delay >= accelerations.cols()) {
    throw std::invalid_argument("MeasureAlignment: samples outside of the recording");
  }
  const int count = last - first + 1;
  Eigen::MatrixXd expected = ReadingsOf(segment, alignment, cutoff_hz).middleCols(first, count);
  Eigen::MatrixXd found = LowPass(accelerations, segment.rate_hz, cutoff_hz).middleCols(first + delay, count);
  AlignmentQuality quality;
  quality.residual_m_s2 = std::sqrt((found - expected).squaredNorm() / count);
  // Correlation in the segment's axes would be the same: a turn keeps the products.
  expected.colwise() -= Eigen::VectorXd(expected.rowwise().mean());
  found.colwise() -= Eigen::VectorXd(found.rowwise().mean());
  const double scale = expected.norm() * found.norm();
  quality.correlation = scale > 0 ? expected.cwiseProduct(found).sum() / scale : 0;
  return quality;
}

Eigen::Quaterniond MountingByMoments(const Matrix3Xd& reference, const Matrix3Xd& sensor) {
  if (reference.cols() == 0 || sensor.cols() == 0) throw std::invalid_argument("MountingByMoments: there are no samples");
  const Vector3d up = reference.rowwise().mean(), up_sensor = sensor.rowwise().mean();
  const Eigen::Quaterniond tilt = Eigen::Quaterniond::FromTwoVectors(up_sensor, up);
  const Matrix3Xd centred_reference = reference.colwise() - up;
  const Matrix3Xd centred = tilt.toRotationMatrix() * (sensor.colwise() - up_sensor);
  const Eigen::MatrixXd wanted = Moments(centred_reference);
  Eigen::Quaterniond best = tilt;
  double least = std::numeric_limits<double>::infinity();
  for (int degree = 0; degree < 360; ++degree) {
    const Eigen::Quaterniond yaw(Eigen::AngleAxisd(degree * std::numbers::pi / 180, up.normalized()));
    const double difference = (Moments(yaw.toRotationMatrix() * centred) - wanted).squaredNorm();
    if (difference < least) {
      least = difference;
      best = yaw * tilt;
    }
  }
  return best;
}

}  // namespace morphograph
