#include "graph/action_change.h"

#include <gtest/gtest.h>

#include "datasets/leg_ik.h"
#include "primitives/time_warp.h"
#include "tests/support/two_actions.h"

namespace morphograph {
namespace {

// The mean step of a primitive.
StepWithContacts MeanStep(const MotionGraph& graph, int id) {
  const MotionPrimitive& primitive = graph.primitive(id);
  return {primitive.Shape(Eigen::VectorXd::Zero(primitive.reduction.components())), primitive.contacts};
}

class MadeStep : public ::testing::Test {
 protected:
  MadeStep() : graph_(testing::ModelOfTwoActions()), change_(graph_->changes().at(0)), first_(MeanStep(*graph_, change_.from)),
               last_(MeanStep(*graph_, change_.to)), style_(graph_->styles()[graph_->primitive(change_.to).style_index]),
               weights_(graph_->layout().ChannelWeights(style_.mean_rotations)) {
    // Longer and quicker than what was learned, so that there is something to change.
    last_.shape.poses.row(2) *= 1.4;
    last_.shape.duration_s *= 0.8;
    stance_ = graph_->primitive(change_.from).start == KeyframeLabel::kLeftStance ? Foot::kLeft : Foot::kRight;
  }

  StepWithContacts Made() const { return BlendSteps(graph_->layout(), style_.mean_rotations, stance_, first_, last_); }

  std::shared_ptr<const MotionGraph> graph_;
  ActionChange change_;
  StepWithContacts first_, last_;
  GraphStyle style_;
  Eigen::VectorXd weights_;
  Foot stance_ = Foot::kLeft;
};

TEST_F(MadeStep, BeginsAsOneStepAndEndsAsTheOther) {
  const StepWithContacts made = Made();
  for (int i = 0; i < kPhaseSamples; ++i) {
    const double phase = PhaseOfSample(i);
    const auto pose = made.shape.poses.col(i);
    if (phase <= 0) EXPECT_LT((pose - first_.shape.poses.col(i)).norm(), 1e-12) << phase;
    if (phase < 1) continue;
    // Where it stands on the floor is of the first step; how it moves there is of the other.
    const Eigen::VectorXd apart = pose - last_.shape.poses.col(i), at_last_landing = made.shape.poses.col(20) - last_.shape.poses.col(20);
    EXPECT_LT((apart - at_last_landing).norm(), 1e-12) << phase;
    EXPECT_LT(apart.tail(apart.size() - 3).norm(), 1e-12) << phase;
  }
  EXPECT_LT(made.shape.duration_s, first_.shape.duration_s);
  EXPECT_GT(made.shape.duration_s, last_.shape.duration_s);
  // Seconds a phase, where it begins and where it ends.
  const auto tempo_s = [](const StepShape& step, double phase) {
    return step.duration_s * TimeWarp::FromLogSlopes(step.log_slopes).Slope(phase);
  };
  EXPECT_NEAR(tempo_s(made.shape, 0), tempo_s(first_.shape, 0), 1e-9);
  EXPECT_NEAR(tempo_s(made.shape, 1), tempo_s(last_.shape, 1), 1e-9);
}

TEST_F(MadeStep, LeavesAStandingFootWhereItIs) {
  const LegIk leg(graph_->skeleton(), stance_);
  const int ball = stance_ == Foot::kLeft ? 1 : 3;
  const auto way_of_ball = [&](const StepWithContacts& step) {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = -low;
    for (int i = 5; i < 14; ++i) {
      if (first_.contacts(ball, i) < 0.9) continue;
      std::vector<Eigen::Quaterniond> rotations = style_.mean_rotations;
      const auto& joints = graph_->layout().active_joints();
      for (size_t n = 0; n < joints.size(); ++n) {
        rotations[joints[n]] = graph_->layout().RotationOf(n, style_.mean_rotations[joints[n]], step.shape.poses.block<3, 1>(3 + 3 * n, i));
      }
      const Eigen::Vector3d place = leg.Place(step.shape.poses.block<3, 1>(0, i), rotations.data()).toe_m;
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
    }
    return (high - low).norm();
  };
  // The same step from another place: blended where the root is, the foot would slide by a tenth of a metre.
  last_ = first_;
  last_.shape.poses.row(2).array() += 0.1;
  const StepWithContacts moved = Made();
  EXPECT_NEAR(way_of_ball(moved), way_of_ball(first_), 1e-6);
}

TEST_F(MadeStep, EffortIsOfSpeedAndOfTheBody) {
  const StepWithContacts same = first_;
  EXPECT_NEAR(SpeedChange_m_s2(first_.shape, same.shape), 0, 1e-12);
  EXPECT_NEAR(PoseDistance_m(first_.shape, same.shape, weights_), 0, 1e-12);
  StepShape faster = first_.shape;
  faster.duration_s *= 0.5;
  const double speed_m_s = StepSpeed_m_s(first_.shape);
  EXPECT_NEAR(StepSpeed_m_s(faster), 2 * speed_m_s, 1e-9);
  EXPECT_NEAR(SpeedChange_m_s2(first_.shape, faster), speed_m_s / (0.75 * first_.shape.duration_s), 1e-9);
  EXPECT_NEAR(HardestAcceleration_m_s2(faster, weights_), 4 * HardestAcceleration_m_s2(first_.shape, weights_), 1e-6);
  const ChangeEffort effort = EffortOf(first_.shape, Made().shape, last_.shape, weights_);
  EXPECT_TRUE(IsWithin(effort, effort));
  EXPECT_FALSE(IsWithin(effort, {effort.speed_m_s2 * 0.99, effort.body_m_s2}));
  EXPECT_FALSE(IsWithin(effort, {effort.speed_m_s2, effort.body_m_s2 * 0.99}));
}

}  // namespace
}  // namespace morphograph
