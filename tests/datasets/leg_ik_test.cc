#include "datasets/leg_ik.h"

#include <gmock/gmock.h>

#include <boost/random/uniform_real_distribution.hpp>
#include <cmath>
#include <random>

#include "datasets/forward_kinematics.h"
#include "datasets/synthetic_skeleton.h"

namespace morphograph {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

double Uniform(std::mt19937_64& rng, double low, double high) {
  return boost::random::uniform_real_distribution<double>(low, high)(rng);
}

Quaterniond SmallTurn(std::mt19937_64& rng, double limit_rad) {
  const Vector3d axis(Uniform(rng, -1, 1), Uniform(rng, -1, 1), Uniform(rng, -1, 1));
  return Quaterniond(AngleAxisd(Uniform(rng, 0, limit_rad), axis.normalized()));
}

/// A leg pose like those of walking: thigh anywhere forward or back, knee bent by `knee_rad`, foot nearly level.
std::vector<Quaterniond> LegPose(const Skeleton& skeleton, const LegIk& leg, std::mt19937_64& rng, double knee_rad) {
  std::vector<Quaterniond> rotations(skeleton.joint_count(), Quaterniond::Identity());
  rotations[skeleton.moving_root()] = SmallTurn(rng, 0.3) * Quaterniond(AngleAxisd(Uniform(rng, -3, 3), Vector3d::UnitY()));
  rotations[leg.hip()] = SmallTurn(rng, 0.2) * Quaterniond(AngleAxisd(Uniform(rng, -0.6, 0.4), Vector3d::UnitX()));
  rotations[leg.knee()] = Quaterniond(AngleAxisd(knee_rad, Vector3d::UnitX()));
  rotations[leg.ankle()] = SmallTurn(rng, 0.3);
  return rotations;
}

/// The synthetic skeleton with a joint of no length between hip and knee, knee and ankle, hips and hip.
Skeleton WithIdleJoints() {
  const auto plain = SyntheticSkeleton();
  std::vector<Joint> joints;
  std::vector<int> index_of(plain->joint_count());
  for (int j = 0; j < plain->joint_count(); ++j) {
    Joint joint = plain->joint(j);
    if (joint.parent >= 0) joint.parent = index_of[joint.parent];
    if (joint.name.ends_with("UpLeg") || joint.name.ends_with("Leg") || joint.name.ends_with("Foot")) {
      Joint idle = joint;
      idle.name = joint.name + "Idle";
      joint.offset_m.setZero();
      joints.push_back(idle);
      joint.parent = static_cast<int>(joints.size()) - 1;
    }
    index_of[j] = static_cast<int>(joints.size());
    joints.push_back(joint);
  }
  std::vector<std::string> names;
  for (const Joint& joint : joints) names.push_back(joint.name);
  return Skeleton(joints, DetectRoles(names), 0.01, UpAxis::kY);
}

class LegIkTest : public ::testing::TestWithParam<std::tuple<bool, Foot>> {
 protected:
  LegIkTest() : skeleton_(std::get<0>(GetParam()) ? WithIdleJoints() : *SyntheticSkeleton()), leg_(skeleton_, std::get<1>(GetParam())) {}
  Skeleton skeleton_;
  LegIk leg_;
  Vector3d root_{0.3, 0.9, -2};
  std::mt19937_64 rng_{11};
};

TEST_P(LegIkTest, ReachesRandomTargetsWithTheAskedFootOrientationAndAForwardKnee) {
  for (int trial = 0; trial < 500; ++trial) {
    std::vector<Quaterniond> rotations = LegPose(skeleton_, leg_, rng_, Uniform(rng_, -0.1, 1.2));
    const LegMeasure before = leg_.Measure(root_, rotations.data());
    const Vector3d direction = SmallTurn(rng_, 0.7) * (before.ankle_m - before.hip_m).normalized();
    const Vector3d target = before.hip_m + Uniform(rng_, 0.55, 0.99) * leg_.length_m() * direction;
    const Quaterniond foot = SmallTurn(rng_, 0.5) * rotations[skeleton_.moving_root()];
    const LegSolution solution = leg_.Solve(target, foot, root_, rotations.data());

    WorldPose pose;
    ForwardKinematics(skeleton_, rotations.data(), root_, &pose);
    ASSERT_LT((pose.positions.col(leg_.ankle()) - target).norm(), 1e-9) << trial;
    ASSERT_LT(pose.rotations[leg_.ankle()].angularDistance(foot), 1e-7) << trial;
    ASSERT_GE(solution.knee_bend_rad, 0);
    // The foot may point anywhere afterwards: whether the knee bends forwards is judged against the pelvis.
    const Vector3d left = rotations[skeleton_.moving_root()] * Vector3d::UnitX();
    const Vector3d bend = (pose.positions.col(leg_.knee()) - before.hip_m).cross(target - pose.positions.col(leg_.knee()));
    ASSERT_GT(bend.dot(left), 0) << trial;
  }
}

TEST_P(LegIkTest, LeavesThePoseAloneWhenTheTargetIsItsOwnAnkle) {
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Quaterniond> rotations = LegPose(skeleton_, leg_, rng_, Uniform(rng_, 0.0, 1.2));
    const std::vector<Quaterniond> before = rotations;
    const LegMeasure measure = leg_.Measure(root_, rotations.data());
    leg_.Solve(measure.ankle_m, std::nullopt, root_, rotations.data());
    for (int j = 0; j < skeleton_.joint_count(); ++j) ASSERT_LT(before[j].angularDistance(rotations[j]), 1e-5) << trial;
  }
}

TEST_P(LegIkTest, StraightensWithoutSnappingWhenTheTargetRunsAway) {
  std::vector<Quaterniond> pose = LegPose(skeleton_, leg_, rng_, 0.3);
  const LegMeasure start = leg_.Measure(root_, pose.data());
  const Vector3d away = (start.ankle_m - start.hip_m).normalized();
  double last_bend = 10, last_miss = -1;
  for (double reach = 0.9; reach < 1.1; reach += 1e-4) {
    std::vector<Quaterniond> rotations = pose;
    const LegSolution solution = leg_.Solve(start.hip_m + reach * leg_.length_m() * away, std::nullopt, root_, rotations.data());
    ASSERT_LE(solution.knee_bend_rad, last_bend);
    if (reach > 0.9001) {
      ASSERT_LT(last_bend - solution.knee_bend_rad, 0.004) << reach;  // without the soft limit: 0.02 in the last step
    }
    ASSERT_GE(solution.miss_m, last_miss - 1e-12);
    if (reach < 0.996) {
      ASSERT_LT(solution.miss_m, 1e-9);
    }
    ASSERT_LT(solution.miss_m, std::max(0.0, reach - 0.995) * leg_.length_m() + 1e-9);
    last_bend = solution.knee_bend_rad;
    last_miss = solution.miss_m;
  }
  EXPECT_LT(last_bend, 0.01);
}

TEST_P(LegIkTest, TurnsABackwardKneeForward) {
  std::vector<Quaterniond> rotations = LegPose(skeleton_, leg_, rng_, -0.4);
  const LegMeasure before = leg_.Measure(root_, rotations.data());
  EXPECT_LT(before.knee_bend_rad, -0.3);
  const Vector3d target = before.hip_m + 0.97 * (before.ankle_m - before.hip_m);
  leg_.Solve(target, std::nullopt, root_, rotations.data());
  const LegMeasure after = leg_.Measure(root_, rotations.data());
  EXPECT_GT(after.knee_bend_rad, 0.3);
  EXPECT_LT((after.ankle_m - target).norm(), 1e-9);
}

// A drawn pose may bend a knee back and bow it to the side at once. Seen from the pelvis, no solved knee points back.
TEST_P(LegIkTest, TurnsABackwardKneeForwardThatIsBowedToTheSideToo) {
  for (int trial = 0; trial < 500; ++trial) {
    std::vector<Quaterniond> rotations = LegPose(skeleton_, leg_, rng_, 0.0);
    const Quaterniond bow(AngleAxisd(Uniform(rng_, -0.2, 0.2), Vector3d::UnitZ()));
    rotations[leg_.knee()] = bow * Quaterniond(AngleAxisd(Uniform(rng_, -0.3, 0.1), Vector3d::UnitX()));
    const Quaterniond hip_turn = rotations[leg_.hip()];
    const LegMeasure before = leg_.Measure(root_, rotations.data());
    const Vector3d target = before.hip_m + Uniform(rng_, 0.98, 1.01) * (before.ankle_m - before.hip_m);
    const Vector3d left = rotations[skeleton_.moving_root()] * hip_turn * Vector3d::UnitX();  // the thigh's own
    leg_.Solve(target, std::nullopt, root_, rotations.data());
    const LegMeasure after = leg_.Measure(root_, rotations.data());
    const double bend = (after.knee_m - after.hip_m).cross(after.ankle_m - after.knee_m).dot(left);
    // Foot and pelvis are turned by up to 0.3 rad against the thigh, and show as much less of a bow of 0.2 rad.
    ASSERT_GT(bend / (leg_.length_m() * leg_.length_m() / 4), -0.06) << trial;
    ASSERT_LT((after.ankle_m - target).norm(), 0.02 * leg_.length_m()) << trial;
  }
}

TEST_P(LegIkTest, StaysFiniteForTargetsAtTheHipAndFarAway) {
  for (const double reach : {0.0, 1e-12, 50.0}) {
    std::vector<Quaterniond> rotations = LegPose(skeleton_, leg_, rng_, 0.0);
    const LegMeasure before = leg_.Measure(root_, rotations.data());
    leg_.Solve(before.hip_m + reach * Vector3d::UnitX(), std::nullopt, root_, rotations.data());
    for (const Quaterniond& rotation : rotations) ASSERT_NEAR(rotation.norm(), 1, 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(Skeletons, LegIkTest,
                         ::testing::Combine(::testing::Bool(), ::testing::Values(Foot::kLeft, Foot::kRight)));

TEST(LegIk, NamesTheMissingRole) {
  const auto plain = SyntheticSkeleton();
  RoleMap roles = plain->roles();
  roles.Set(JointRole::kRightKnee, -1);
  const Skeleton skeleton(plain->joints(), roles, 0.01, UpAxis::kY);
  EXPECT_THAT([&] { LegIk(skeleton, Foot::kLeft); },
              ::testing::ThrowsMessage<std::invalid_argument>(::testing::HasSubstr("right_knee")));
}

}  // namespace
}  // namespace morphograph
