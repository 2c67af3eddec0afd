#include "datasets/resample.h"

#include <gtest/gtest.h>

#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "datasets/clip_conversion.h"
#include "datasets/bvh_reader.h"
#include "datasets/forward_kinematics.h"
#include "datasets/synthetic_gait.h"
#include "tests/support/shared_data.h"

namespace morphograph {
namespace {

std::shared_ptr<const Skeleton> TwoJoints() {
  std::vector<Joint> joints(2);
  joints[0].name = "root";
  joints[1].name = "child";
  joints[1].parent = 0;
  joints[1].offset_m = {0, 1, 0};
  return std::make_shared<const Skeleton>(joints, RoleMap(), 1.0, UpAxis::kY);
}

// Root position and child rotation swing at `swing_hz`.
MotionClip Swing(double rate_hz, int frames, double swing_hz) {
  MotionClip clip(TwoJoints(), rate_hz, frames);
  for (int f = 0; f < frames; ++f) {
    const double phase = 2 * std::numbers::pi * swing_hz * f / rate_hz;
    clip.root_positions().col(f) = Eigen::Vector3d(std::sin(phase), 1, f / rate_hz);
    clip.rotation(f, 1) = Eigen::AngleAxisd(0.6 * std::sin(phase), Eigen::Vector3d(1, 2, 3).normalized());
  }
  return clip;
}

TEST(Resample, KeepsTheDurationUpToTheLastFrame) {
  for (const int frames : {1, 2, 5, 121, 400}) {
    const MotionClip clip = Swing(120, frames, 1);
    for (const double rate : {30.0, 60.0, 240.0, 100.0, 29.97}) {
      const MotionClip out = Resample(clip, rate);
      EXPECT_LE(out.duration_s(), clip.duration_s() + 1e-6);
      EXPECT_GT(out.duration_s() + 1 / rate, clip.duration_s() + 1e-9 * frames) << frames << " " << rate;
    }
  }
  EXPECT_EQ(Resample(Swing(120, 121, 1), 30).frame_count(), 31);
  EXPECT_EQ(Resample(Swing(30, 31, 1), 120).frame_count(), 121);
}

TEST(Resample, RaisingTheRatePassesThroughTheSourceFrames) {
  const MotionClip clip = Swing(30, 40, 1.5);
  const MotionClip out = Resample(clip, 120);
  for (int f = 0; f < clip.frame_count(); ++f) {
    EXPECT_LT((out.root_positions().col(4 * f) - clip.root_positions().col(f)).norm(), 1e-12);
    EXPECT_LT(out.rotation(4 * f, 1).angularDistance(clip.rotation(f, 1)), 1e-7);
  }
}

TEST(Resample, FollowsSlowMotionBothWays) {
  for (const auto& [from, to] : {std::pair{30.0, 120.0}, {120.0, 30.0}, {120.0, 50.0}, {100.0, 30.0}, {30.0, 29.97}}) {
    const MotionClip out = Resample(Swing(from, static_cast<int>(3 * from), 1), to);
    const MotionClip exact = Swing(to, out.frame_count(), 1);
    const int margin = static_cast<int>(0.2 * to);  // the ends are continued by reflection, not by knowledge
    for (int f = margin; f + margin < out.frame_count(); ++f) {
      EXPECT_LT((out.root_positions().col(f) - exact.root_positions().col(f)).norm(), 0.01) << from << " " << to << " " << f;
      EXPECT_LT(out.rotation(f, 1).angularDistance(exact.rotation(f, 1)), 0.006) << from << " " << to << " " << f;
    }
  }
}

TEST(Resample, RemovesWhatTheLowerRateCannotHold) {
  const MotionClip out = Resample(Swing(120, 600, 29), 30);  // would come out as 1 Hz
  for (int f = 6; f + 6 < out.frame_count(); ++f) {
    EXPECT_LT(std::abs(out.root_positions()(0, f)), 0.02) << f;
    EXPECT_LT(out.rotation(f, 1).angularDistance(Eigen::Quaterniond::Identity()), 0.02) << f;
  }
}

TEST(Resample, SteadyMotionStaysSteadyUpToTheEnds) {
  MotionClip clip(TwoJoints(), 120, 200);
  for (int f = 0; f < 200; ++f) {
    clip.root_positions().col(f) = Eigen::Vector3d(0.01 * f, 1, -0.02 * f);
    clip.rotation(f, 0) = Eigen::AngleAxisd(0.05 * f, Eigen::Vector3d::UnitY());  // 1.6 turns: beyond one log map
  }
  for (const double rate : {30.0, 77.0, 500.0}) {
    const MotionClip out = Resample(clip, rate);
    for (int f = 0; f < out.frame_count(); ++f) {
      const double at = f * 120 / rate;
      EXPECT_LT((out.root_positions().col(f) - Eigen::Vector3d(0.01 * at, 1, -0.02 * at)).norm(), 1e-9);
      EXPECT_LT(out.rotation(f, 0).angularDistance(
                    Eigen::Quaterniond(Eigen::AngleAxisd(0.05 * at, Eigen::Vector3d::UnitY()))), 1e-6);
    }
  }
}

TEST(Resample, IsSymmetricInTime) {
  std::mt19937_64 rng(3);
  boost::random::normal_distribution<double> normal;
  MotionClip clip(TwoJoints(), 120, 121);
  for (int f = 0; f < 121; ++f) clip.root_positions().col(f) = Eigen::Vector3d(normal(rng), normal(rng), normal(rng));
  MotionClip reversed = clip;
  reversed.root_positions() = clip.root_positions().rowwise().reverse();
  const MotionClip a = Resample(clip, 30), b = Resample(reversed, 30);
  EXPECT_LT((a.root_positions() - b.root_positions().rowwise().reverse()).norm(), 1e-9);
}

TEST(Resample, RejectsARateThatIsNotPositive) {
  EXPECT_THROW(Resample(Swing(30, 5, 1), 0), std::invalid_argument);
  EXPECT_THROW(Resample(Swing(30, 5, 1), -1), std::invalid_argument);
  EXPECT_THROW(Resample(Swing(30, 5, 1), std::nan("")), std::invalid_argument);
}

TEST(Resample, RefusesResultsThatAreTooLarge) {
  const MotionClip clip = Swing(30, 31, 1);
  EXPECT_EQ(Resample(clip, 300, 301 * clip.joint_count()).frame_count(), 301);
  EXPECT_THROW(Resample(clip, 300, 301 * clip.joint_count() - 1), std::invalid_argument);
  EXPECT_THROW(Resample(clip, 1e9), std::invalid_argument);
}

TEST(Resample, MovesJointsOfARealWalkByMillimetres) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const MotionClip clip = ImportClip(ReadBvhFile(testing::SharedData() / "cmu" / "07" / "07_05.bvh"));
  const std::vector<Eigen::Matrix3Xd> before = JointPositions(clip);
  const std::vector<Eigen::Matrix3Xd> after = JointPositions(Resample(clip, 30));
  double worst = 0, sum = 0;
  for (size_t f = 0; f < after.size(); ++f) {
    const Eigen::VectorXd distance = (after[f] - before[4 * f]).colwise().norm();
    worst = std::max(worst, distance.maxCoeff());
    sum += distance.mean();
  }
  EXPECT_LT(worst, 0.03);
  EXPECT_LT(sum / static_cast<double>(after.size()), 0.003);
  RecordProperty("worst_mm", std::to_string(worst * 1000));
  RecordProperty("mean_mm", std::to_string(sum / static_cast<double>(after.size()) * 1000));
}

TEST(Retimed, KeepsFramesAndChangesTheirTime) {
  SyntheticGaitOptions options;
  options.frame_rate_hz = 30;
  const MotionClip clip = GenerateGait(options);
  const MotionClip slow = Retimed(clip, 24);
  EXPECT_EQ(slow.frame_count(), clip.frame_count());
  EXPECT_NEAR(slow.duration_s(), 1.25 * clip.duration_s(), 1e-9);
  EXPECT_EQ(slow.root_positions(), clip.root_positions());
  for (int j = 0; j < clip.joint_count(); ++j) EXPECT_EQ(slow.rotation(9, j).coeffs(), clip.rotation(9, j).coeffs());
  EXPECT_THROW(Retimed(clip, 0), std::invalid_argument);
}

TEST(Reversed, BeginsAtTheEnd) {
  const MotionClip clip = GenerateGait({});
  const MotionClip backwards = Reversed(clip);
  ASSERT_EQ(backwards.frame_count(), clip.frame_count());
  EXPECT_EQ(backwards.frame_rate_hz(), clip.frame_rate_hz());
  EXPECT_EQ(backwards.style, clip.style);
  const int last = clip.frame_count() - 1;
  for (const int f : {0, 1, last}) {
    EXPECT_EQ(backwards.root_positions().col(f), clip.root_positions().col(last - f));
    for (int j = 0; j < clip.joint_count(); ++j) EXPECT_EQ(backwards.rotation(f, j).coeffs(), clip.rotation(last - f, j).coeffs());
  }
}

}  // namespace
}  // namespace morphograph
