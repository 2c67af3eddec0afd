#include "datasets/virtual_sensors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>

#include "datasets/forward_kinematics.h"
#include "datasets/synthetic_gait.h"
#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// A stick: a root and a joint this far out on X.
constexpr double kArm_m = 0.4;

MotionClip Stick(int frames, double rate_hz) {
  const auto skeleton = std::make_shared<const Skeleton>(
      std::vector<Joint>{{"root", -1, Vector3d::Zero(), {}, {}}, {"tip", 0, Vector3d(kArm_m, 0, 0), {}, {}}}, RoleMap(), 1.0, UpAxis::kY);
  return MotionClip(skeleton, rate_hz, frames);
}

const Vector3d kUpward(0, kGravity_m_s2, 0);

TEST(VirtualAccelerations, AtRestTheyReadGravityOnly) {
  const Readings readings = VirtualAccelerations(Stick(20, 60), PlacementsAtJoints({"root", "tip"}), 60);
  EXPECT_EQ(readings.sample_count(), 20);
  EXPECT_EQ(readings.names, (std::vector<std::string>{"root", "tip"}));
  EXPECT_NEAR(readings.times_s[19], 19 / 60.0, 1e-12);
  for (int s = 0; s < 2; ++s) {
    for (int f = 0; f < 20; ++f) EXPECT_LT((readings.values.col(f).segment<3>(3 * s) - kUpward).norm(), 1e-9);
  }
}

TEST(VirtualAccelerations, GravityIsSeenInTheSensorsAxes) {
  MotionClip clip = Stick(10, 60);
  const Quaterniond pose(AngleAxisd(0.7, Vector3d(1, 2, 3).normalized())), mounting(AngleAxisd(-1.1, Vector3d(0, 1, 1).normalized()));
  for (int f = 0; f < 10; ++f) clip.rotation(f, 0) = pose;
  Placement placement{"s", "tip", Vector3d(0.1, 0.2, 0.3), mounting};
  const Readings readings = VirtualAccelerations(clip, {placement}, 60);
  EXPECT_LT((pose * mounting * Vector3d(readings.values.col(4)) - kUpward).norm(), 1e-9);
}

TEST(VirtualAccelerations, InFreeFallTheyReadNothing) {
  MotionClip clip = Stick(30, 100);
  for (int f = 0; f < 30; ++f) {
    const double t = f / 100.0;
    clip.root_positions().col(f) = Vector3d(2 * t, 3 - 0.5 * kGravity_m_s2 * t * t, -t);
  }
  const Readings readings = VirtualAccelerations(clip, PlacementsAtJoints({"tip"}), 100);
  EXPECT_LT(readings.values.cwiseAbs().maxCoeff(), 1e-8);
}

TEST(VirtualAccelerations, OnACircleTheyPointInwards) {
  const double rate_hz = 60, rate_rad_s = 2 * std::numbers::pi * 1.5;
  MotionClip clip = Stick(60, rate_hz);
  for (int f = 0; f < 60; ++f) clip.rotation(f, 0) = AngleAxisd(rate_rad_s * f / rate_hz, Vector3d::UnitY());
  const Readings readings = VirtualAccelerations(clip, PlacementsAtJoints({"tip"}), rate_hz);
  // The second difference of a circle: 2 - 2 cos(w h) for (w h)^2.
  const double inwards = kArm_m * (2 - 2 * std::cos(rate_rad_s / rate_hz)) * rate_hz * rate_hz;
  EXPECT_NEAR(inwards, kArm_m * rate_rad_s * rate_rad_s, 0.01 * inwards);
  for (int f = 1; f < 59; ++f) EXPECT_LT((readings.values.col(f) - Vector3d(-inwards, kGravity_m_s2, 0)).norm(), 1e-8);
}

TEST(VirtualAccelerations, AtAnotherRateTheyReadTheSameMotion) {
  SyntheticGaitOptions options;
  options.frame_rate_hz = 120;
  const MotionClip clip = GenerateGait(options);
  const auto placements = PlacementsAtJoints({"hips", "head"});
  const Readings fine = VirtualAccelerations(clip, placements, 60), coarse = VirtualAccelerations(clip, placements, 30);
  EXPECT_NEAR(coarse.rate_hz(), 30, 1e-9);
  // A second difference over 1/30 s is that over 1/60 s averaged 1, 2, 1.
  double squares = 0, size = 0;
  for (int f = 20; f < coarse.sample_count() - 20; ++f) {
    const Eigen::VectorXd expected = (fine.values.col(2 * f - 1) + 2 * fine.values.col(2 * f) + fine.values.col(2 * f + 1)) / 4;
    squares += (coarse.values.col(f) - expected).squaredNorm();
    size += (expected - kUpward.replicate<2, 1>()).squaredNorm();
  }
  EXPECT_GT(size, 0);
  EXPECT_LT(std::sqrt(squares / size), 0.1);
}

TEST(VirtualAccelerations, RefuseWhatCannotBe) {
  EXPECT_THROW(VirtualAccelerations(Stick(2, 60), PlacementsAtJoints({"tip"}), 60), std::invalid_argument);
  EXPECT_THROW(VirtualAccelerations(Stick(20, 60), PlacementsAtJoints({"tip"}), 0), std::invalid_argument);
  EXPECT_THROW(VirtualAccelerations(Stick(20, 60), PlacementsAtJoints({"tail"}), 60), std::invalid_argument);
}

TEST(VirtualMarkers, LieWhereTheirPlacementSays) {
  MotionClip clip = Stick(2, 30);
  clip.root_positions().col(1) = Vector3d(1, 2, 3);
  clip.rotation(1, 0) = AngleAxisd(std::numbers::pi / 2, Vector3d::UnitY());
  const Readings readings = VirtualMarkers(clip, {{"m", "tip", Vector3d(0, 0.1, 0.2), Quaterniond::Identity()}});
  EXPECT_LT((readings.values.col(0) - Vector3d(kArm_m, 0.1, 0.2)).norm(), 1e-12);
  EXPECT_LT((readings.values.col(1) - Vector3d(1.2, 2.1, 3 - kArm_m)).norm(), 1e-12);
  EXPECT_NEAR(readings.times_s[1], 1 / 30.0, 1e-12);
}

Readings RandomReadings(int sensors, int samples) {
  std::mt19937_64 rng(5);
  Readings readings;
  for (int s = 0; s < sensors; ++s) readings.names.push_back("s" + std::to_string(s));
  for (int i = 0; i < samples; ++i) readings.times_s.push_back(i / 100.0);
  readings.values = 10 * testing::RandomNormal(3 * sensors, samples, rng);
  return readings;
}

// Loss marks values NaN; the others must be what they would be without it.
void ExpectSameWherePresent(const Eigen::MatrixXd& with_loss, const Eigen::MatrixXd& without) {
  int present = 0;
  for (Eigen::Index c = 0; c < without.cols(); ++c) {
    for (Eigen::Index r = 0; r < without.rows(); ++r) {
      if (std::isnan(with_loss(r, c))) continue;
      ++present;
      ASSERT_EQ(with_loss(r, c), without(r, c));
    }
  }
  EXPECT_GT(present, without.size() / 2);
}

TEST(WithFaults, NoFaultChangesNothing) {
  const Readings clean = RandomReadings(2, 100);
  EXPECT_EQ(WithFaults(clean, {}, 1).values, clean.values);
}

TEST(WithFaults, AreTheSeedsAndEachKindHasItsOwnNumbers) {
  const Readings clean = RandomReadings(2, 2000);
  SensorFaults all;
  all.noise = 0.5;
  all.bias = 0.3;
  all.mounting_rad = 0.2;
  all.loss = 0.1;
  SensorFaults no_loss = all, noise_only, bias_only, both;
  no_loss.loss = 0;
  noise_only.noise = both.noise = 0.5;
  bias_only.bias = both.bias = 0.3;
  ExpectSameWherePresent(WithFaults(clean, all, 7).values, WithFaults(clean, no_loss, 7).values);
  const Eigen::MatrixXd noise = WithFaults(clean, noise_only, 7).values - clean.values, bias = WithFaults(clean, bias_only, 7).values - clean.values;
  EXPECT_LT((WithFaults(clean, both, 7).values - clean.values - noise - bias).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(WithFaults(clean, no_loss, 7).values, WithFaults(clean, no_loss, 7).values);
  EXPECT_GT((WithFaults(clean, no_loss, 8).values - WithFaults(clean, no_loss, 7).values).norm(), 1);
}

TEST(WithFaults, HaveTheSizeAskedFor) {
  const Readings clean = RandomReadings(4, 5000);
  SensorFaults faults;
  faults.noise = 0.5;
  const Eigen::MatrixXd noise = WithFaults(clean, faults, 7).values - clean.values;
  EXPECT_NEAR(std::sqrt(noise.squaredNorm() / noise.size()), 0.5, 0.01);
  EXPECT_NEAR(noise.mean(), 0, 0.01);

  faults = {};
  faults.loss = 0.1;
  const Eigen::MatrixXd lossy = WithFaults(clean, faults, 7).values;
  int lost = 0;
  for (int f = 0; f < 5000; ++f) {
    for (int s = 0; s < 4; ++s) {
      const auto sample = lossy.col(f).segment<3>(3 * s).array().isNaN();
      EXPECT_EQ(sample.any(), sample.all());
      lost += sample.all();
    }
  }
  EXPECT_NEAR(lost / 20000.0, 0.1, 0.01);

  faults = {};
  faults.range = 8;
  const Eigen::MatrixXd clipped = WithFaults(clean, faults, 7).values;
  EXPECT_EQ(clipped, clean.values.cwiseMax(-8).cwiseMin(8));

  faults = {};
  faults.mounting_rad = 0.3;
  const Eigen::MatrixXd turned = WithFaults(clean, faults, 7).values;
  for (int s = 0; s < 4; ++s) {
    // A turn keeps lengths, and is the same throughout.
    EXPECT_NEAR(turned.col(9).segment<3>(3 * s).norm(), clean.values.col(9).segment<3>(3 * s).norm(), 1e-9);
    EXPECT_NEAR(turned.col(9).segment<3>(3 * s).dot(turned.col(2).segment<3>(3 * s)),
                clean.values.col(9).segment<3>(3 * s).dot(clean.values.col(2).segment<3>(3 * s)), 1e-9);
    EXPECT_GT((turned.col(9) - clean.values.col(9)).segment<3>(3 * s).norm(), 1e-3);
  }
}

TEST(WithFaults, LostValuesStayLost) {
  Readings readings = RandomReadings(1, 10);
  readings.values.col(3).setConstant(std::nan(""));
  SensorFaults faults;
  faults.noise = 1;
  faults.range = 5;
  faults.mounting_rad = 0.1;
  EXPECT_TRUE(WithFaults(readings, faults, 1).values.col(3).array().isNaN().all());
}

TEST(WithFaults, RefusesWhatCannotBe) {
  const Readings clean = RandomReadings(1, 3);
  for (double SensorFaults::*field : {&SensorFaults::noise, &SensorFaults::bias, &SensorFaults::mounting_rad, &SensorFaults::range, &SensorFaults::loss}) {
    for (const double value : {-0.1, std::nan(""), std::numeric_limits<double>::infinity()}) {
      SensorFaults faults;
      faults.*field = value;
      EXPECT_THROW(WithFaults(clean, faults, 1), std::invalid_argument);
    }
  }
  SensorFaults all_lost;
  all_lost.loss = 1;
  EXPECT_THROW(WithFaults(clean, all_lost, 1), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
