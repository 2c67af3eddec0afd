// Every term of the constrained optimisation: its analytic derivatives against numeric ones, on steps of a learned model.
#include "synthesis/control/residuals/control_residuals.h"

#include <ceres/gradient_checker.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "datasets/virtual_sensors.h"
#include "synthesis/control/residuals/sensor_residual.h"
#include "synthesis/walk_clip.h"
#include "synthesis/walk_sampler.h"
#include "tests/support/small_model.h"

namespace morphograph {
namespace {

constexpr double kFree = std::numeric_limits<double>::infinity();

// Two steps of a drawn walk, and where the first one begins.
class ControlResidual : public ::testing::Test {
 protected:
  void SetUp() override {
    graph_ = testing::SmallModel();
    std::mt19937_64 rng(3);
    walk_ = DrawWalk(*graph_, {.style = 0, .steps = 2}, rng);
    for (int k = 0; k < 2; ++k) {
      const WalkStep& step = walk_.steps[static_cast<size_t>(k)].step;
      const auto& means = graph_->styles()[0].mean_rotations;
      const auto model = std::make_shared<StepModel>(graph_->primitive(step.primitive), step.component);
      steps_.push_back(std::make_shared<StepKinematics>(model, graph_->layout(), means[static_cast<size_t>(graph_->layout().active_joints()[0])]));
    }
  }

  std::shared_ptr<const JointChain> Chain(JointRole role) const {
    return std::make_shared<JointChain>(graph_->layout(), graph_->styles()[0].mean_rotations, graph_->skeleton().roles()[role]);
  }
  const Eigen::VectorXd& w(int k) const { return walk_.steps[static_cast<size_t>(k)].step.whitened; }

  // Checks a term at the drawn walk and a little beside it.
  void Check(const ceres::CostFunction& term, std::vector<Eigen::VectorXd> parameters) {
    std::mt19937_64 rng(5);
    std::normal_distribution<double> normal(0, 0.05);
    ceres::NumericDiffOptions options;
    options.ridders_relative_initial_step_size = 1e-4;  // short, since areas and paths have corners
    const ceres::GradientChecker checker(&term, static_cast<std::vector<const ceres::Manifold*>*>(nullptr), options);
    for (int round = 0; round < 3; ++round) {
      std::vector<const double*> pointers;
      for (const Eigen::VectorXd& block : parameters) pointers.push_back(block.data());
      ceres::GradientChecker::ProbeResults results;
      checker.Probe(pointers.data(), 1e-4, &results);
      ASSERT_TRUE(results.return_value);
      for (size_t b = 0; b < parameters.size(); ++b) {
        // Against the largest entry: transitions are kept in single precision.
        const double scale = std::max(1e-3, results.jacobians[b].cwiseAbs().maxCoeff());
        EXPECT_LT((results.jacobians[b] - results.numeric_jacobians[b]).cwiseAbs().maxCoeff(), 1e-4 * scale) << "block " << b << ", round " << round;
      }
      for (Eigen::VectorXd& block : parameters) {
        for (double& value : block) value += normal(rng);
      }
    }
  }
  void CheckOfStep(const ceres::CostFunction& term) { Check(term, {w(0), place_}); }

  std::shared_ptr<const MotionGraph> graph_;
  DrawnWalk walk_;
  std::vector<std::shared_ptr<const StepKinematics>> steps_;
  KeyframePlace place_{0.4, -1.2, 0.7, 0.3};
  Eigen::Vector3d offset_{0.01, -0.02, 0.03};
};

TEST_F(ControlResidual, Innovation) {
  StepInnovation innovation(*graph_, walk_.steps[0].step, walk_.steps[1].step);
  const Eigen::VectorXd drawn = innovation.Value(w(0), w(1));
  Check(InnovationResidual(innovation, drawn), {w(0), w(1)});
  EXPECT_NEAR(innovation.LogLikelihood(w(0), w(1)), walk_.steps[1].step.log_likelihood, 1e-6) << "as the sampler has it";
}

TEST_F(ControlResidual, FirstStepAndStart) {
  Check(FirstStepResidual(Eigen::VectorXd::Zero(w(0).size()), Eigen::VectorXd::Constant(w(0).size(), 0.7)), {w(0)});
  Check(StartResidual({0, 0, 1, 0}, {0.1, 0.1, 0.2, 1e-3}), {place_});
}

TEST_F(ControlResidual, Radius) {
  Check(RadiusResidual(static_cast<int>(w(0).size()), 0.5 * w(0).norm(), 0.1), {w(0)});
  Check(RadiusResidual(static_cast<int>(w(0).size()), 2 * w(0).norm() + 1, 0.1), {w(0)});
}

TEST_F(ControlResidual, NextPlace) {
  Check(ArrivalResidual(3, 0.01), {place_});
  const KeyframePlace next = steps_[0]->Next(w(0), place_).value;
  Check(NextPlaceResidual(steps_[0], &offset_, 0.5), {w(0), place_, next});
}

TEST_F(ControlResidual, PathAtPhaseAndTime) {
  for (const FloorPath& path : {FloorPath({{0, -3}, {1.5, 2}}), FloorPath({{3, -0.5}, {0.9, -0.5}, {3, 0.5}})}) {
    CheckOfStep(PathResidual(steps_[0], {false, 0.5}, path, 0, path.length_m(), 0.03));
    CheckOfStep(PathResidual(steps_[0], {true, 0.6}, path, 0, path.length_m(), 0.03));
  }
}

TEST_F(ControlResidual, Root) {
  CheckOfStep(RootResidual(steps_[0], {true, 0.55}, {1, 2, 0.5}, {0.01, 0.02, 0.05}, &offset_));
  CheckOfStep(RootResidual(steps_[0], {false, 1}, {1, 2, 0.5}, {kFree, kFree, 0.05}, &offset_));
  CheckOfStep(RootResidual(steps_[0], {true, 0.25}, {1, 2, 0.5}, {0.01, 0.02, 0.05}, &offset_));  // before the key frame
}

TEST_F(ControlResidual, Joints) {
  const auto wrist = Chain(JointRole::kRightWrist);
  CheckOfStep(JointPositionResidual(steps_[0], wrist, {true, 0.6}, {0.5, 1, 0.2}, {0.01, 0.02, kFree}, &offset_));
  CheckOfStep(JointPositionResidual(steps_[0], wrist, {false, 0.4}, {0.5, 1, 0.2}, {0.01, 0.02, 0.01}, &offset_));
  CheckOfStep(JointOrientationResidual(steps_[0], wrist, {true, 0.6}, Eigen::Quaterniond(0.9, 0.3, -0.2, 0.1).normalized(), 0.1));
  CheckOfStep(LookAtResidual(steps_[0], Chain(JointRole::kHead), {true, 0.6}, Eigen::Vector3d(0.1, 0.2, 1).normalized(), {2, 1.5, 1}, 0.1));
}

TEST_F(ControlResidual, Speed) { CheckOfStep(SpeedResidual(steps_[0], 1.2, 0.05)); }

TEST_F(ControlResidual, KeepOut) {
  const Eigen::Vector2d here = place_.head<2>();
  KeepOutTerm circle;
  circle.center_m = here + Eigen::Vector2d(0.3, 0.1);
  circle.radius_m = 0.6;
  KeepOutTerm square;
  square.polygon_m = {here + Eigen::Vector2d(-0.5, -0.6), here + Eigen::Vector2d(0.9, -0.5), here + Eigen::Vector2d(1, 1), here + Eigen::Vector2d(-0.7, 0.8)};
  for (const KeepOutTerm& area : {circle, square}) {
    CheckOfStep(KeepOutResidual(steps_[0], nullptr, {false, 0.5}, area, 0.05, 0.01));
    CheckOfStep(KeepOutResidual(steps_[0], Chain(JointRole::kLeftToe), {false, 0.5}, area, 0.05, 0.01));
  }
  circle.center_m = here + Eigen::Vector2d(30, 0);
  const KeepOutResidual outside(steps_[0], nullptr, {false, 0.5}, circle, 0.05, 0.01);
  const double* parameters[] = {w(0).data(), place_.data()};
  double residual = -1;
  ASSERT_TRUE(outside.Evaluate(parameters, &residual, nullptr));
  EXPECT_EQ(residual, 0);
}

// Readings against sensors that sit beside their joints and lie askew, over samples that reach into both margins.
TEST_F(ControlResidual, Sensor) {
  const Eigen::Quaterniond askew(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()));
  const std::vector<ChainedSensor> sensors = {{{"wrist", "left_wrist", {0.02, -0.03, 0.05}, askew}, Chain(JointRole::kLeftWrist)},
                                              {{"ankle", "right_ankle"}, Chain(JointRole::kRightAnkle)}};
  std::mt19937_64 rng(8);
  std::normal_distribution<double> normal(0, 5);
  Eigen::MatrixXd readings(6, 4);
  for (double& value : readings.reshaped()) value = normal(rng);
  Check(SensorResidual(steps_[0], sensors, 0.5, 30, readings, 1.5), {w(0), Eigen::Vector4d(1, 2, 0.4, 0.47)});
}

// What a step is said to read is what sensors read on a clip of it, away from its joins.
TEST_F(ControlResidual, SensorReadsAsOnAClip) {
  const std::vector<Placement> places = {{"wrist", "left_wrist", {0.02, -0.03, 0.05}, Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX()))},
                                         {"knee", "right_knee"}};
  const std::vector<ChainedSensor> sensors = {{places[0], Chain(JointRole::kLeftWrist)}, {places[1], Chain(JointRole::kRightKnee)}};
  SynthesisVariant unlocked;
  unlocked.foot_lock = false;
  const MotionClip clip = MakeWalkClip(*graph_, walk_.steps, walk_.frames, 30, {}, unlocked);
  const Readings read = VirtualAccelerations(clip, places, 30);
  const int first = 4, samples = 4;
  ASSERT_GT(walk_.steps[0].end, first + samples + 4);
  const SensorResidual residual(steps_[0], sensors, first / 30.0, 30, read.values.middleCols(first, samples), 1);
  const Eigen::VectorXd latent = w(0);
  const Eigen::Vector4d place(0, 0, 0, walk_.steps[0].start / 30);
  const double* parameters[] = {latent.data(), place.data()};
  Eigen::VectorXd values(residual.num_residuals());
  ASSERT_TRUE(residual.Evaluate(parameters, values.data(), nullptr));
  EXPECT_LT(values.cwiseAbs().maxCoeff(), 0.1);
  EXPECT_GT(read.values.middleCols(first, samples).cwiseAbs().maxCoeff(), 5);  // where there is something to read
}

}  // namespace
}  // namespace morphograph
