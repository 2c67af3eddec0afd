// Every term of the constrained optimisation: its analytic derivatives against numeric ones, on steps of a learned model.
#include "synthesis/control/residuals/control_residuals.h"

#include <ceres/gradient_checker.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "datasets/leg_ik.h"
#include "datasets/virtual_sensors.h"
#include "synthesis/control/foot_landings.h"
#include "synthesis/control/kinematics_cache.h"
#include "synthesis/control/residuals/reach_residual.h"
#include "synthesis/control/residuals/sensor_residual.h"
#include "synthesis/control/residuals/swing_residual.h"
#include "synthesis/control/residuals/tempo_residual.h"
#include "synthesis/foot_lock.h"
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

// What it takes to solve is counted by how often terms are looked at: once a place, whatever a solver asks for there.
TEST_F(ControlResidual, IsWorkedOutOnceAPlace) {
  class Counting : public StepResidual {
   public:
    explicit Counting(std::shared_ptr<const StepKinematics> step) : StepResidual(std::move(step), 1) {}
    mutable int count = 0;

   protected:
    Linear Linearise(const Eigen::VectorXd& w, const KeyframePlace&) const override {
      ++count;
      return {Eigen::VectorXd::Constant(1, w[0]), Eigen::RowVectorXd::Unit(w.size(), 0), Eigen::RowVector4d::Zero()};
    }
  } counting(steps_[0]);
  Eigen::VectorXd latent = w(0);
  std::vector<double> by_latent(static_cast<size_t>(latent.size()));
  double value = 0, by_place[4];
  const double* parameters[] = {latent.data(), place_.data()};
  double* jacobians[] = {by_latent.data(), by_place};
  counting.Evaluate(parameters, &value, nullptr);
  counting.Evaluate(parameters, &value, jacobians);
  EXPECT_EQ(counting.ByLatent(latent, place_)(0, 0), 1);
  EXPECT_EQ(counting.count, 1);
  latent[0] += 1;
  counting.Evaluate(parameters, &value, nullptr);
  EXPECT_EQ(value, latent[0]);
  place_[0] += 1;
  counting.Evaluate(parameters, &value, jacobians);
  EXPECT_EQ(counting.count, 3);
}

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

TEST_F(ControlResidual, Swing) {
  const auto ball = Chain(LandingFoot(graph_->primitive(walk_.steps[0].step.primitive)) == 0 ? JointRole::kLeftToe : JointRole::kRightToe);
  const SwingState swing = SwingOf(*steps_[0], *ball, w(0));
  // As fast, and as high, as the step's own clip has it.
  std::vector<DrawnStep> steps = walk_.steps;
  const double rate_hz = 200;
  double time = 0;
  for (DrawnStep& step : steps) {
    step.start = time;
    step.end = time += step.shape.duration_s * rate_hz;
  }
  const MotionClip clip = MakeWalkClip(*graph_, steps, static_cast<int>(steps[0].end), rate_hz, {}, {.foot_lock = false});
  const ClipSwing of_clip = SwingInClip(clip, LandingFoot(graph_->primitive(steps[0].step.primitive)) == 0 ? Foot::kLeft : Foot::kRight, 0, clip.frame_count() - 1);
  EXPECT_NEAR(swing.speed_m_s.maxCoeff(), of_clip.speed_m_s, 0.08 * of_clip.speed_m_s);
  EXPECT_NEAR(swing.height_m.maxCoeff(), of_clip.height_m, 0.01);
  // Within its range it costs nothing; where that is narrower, what is beyond it.
  SwingRange range{2 * swing.speed_m_s.maxCoeff(), 2 * swing.height_m.maxCoeff(), 0.4, 0.02};
  CheckOfStep(SwingResidual(steps_[0], ball, range));
  Eigen::VectorXd value(2 * kSwingSpans);
  const double* parameters[] = {w(0).data(), place_.data()};
  SwingResidual(steps_[0], ball, range).Evaluate(parameters, value.data(), nullptr);
  EXPECT_EQ(value.norm(), 0);
  range.speed_m_s = 0.7 * swing.speed_m_s.maxCoeff();
  range.height_m = swing.height_m.mean();
  CheckOfStep(SwingResidual(steps_[0], ball, range));
  SwingResidual(steps_[0], ball, range).Evaluate(parameters, value.data(), nullptr);
  EXPECT_GT(value.head(kSwingSpans).maxCoeff(), 1);
  EXPECT_GT(value.tail(kSwingSpans).maxCoeff(), 0.1);
}

TEST_F(ControlResidual, Tempo) {
  const Eigen::MatrixXd by_latent = steps_[0]->model().timing().by_latent.bottomRows<kWarpKnots>();
  Eigen::VectorXd values(kWarpKnots);
  const Eigen::VectorXd first = by_latent.row(0).transpose().normalized();
  for (const double deviations : {-5.0, -1.5, 0.0, 1.5, 5.0}) {
    const Eigen::VectorXd latent = deviations * first;
    const double* parameters[] = {latent.data(), place_.data()};
    TempoResidual(steps_[0]).Evaluate(parameters, values.data(), nullptr);
    EXPECT_NEAR(values[0], std::abs(deviations) < 2.576 ? 0 : std::copysign((5 - 2.576) / 0.25, deviations), 1e-9);
    Check(TempoResidual(steps_[0]), {latent, place_});
  }
}

TEST_F(ControlResidual, Reach) {
  const bool left = LandingFoot(graph_->primitive(walk_.steps[0].step.primitive)) != 0;  // the foot that stands
  const FeetGeometry& feet = graph_->styles()[0].feet;
  PlantedMoment moment{Chain(left ? JointRole::kLeftHip : JointRole::kRightHip), Chain(left ? JointRole::kLeftAnkle : JointRole::kRightAnkle), Chain(left ? JointRole::kLeftToe : JointRole::kRightToe),
                       feet.heel_offset_m[left ? 0 : 1], LegIk(graph_->skeleton(), left ? Foot::kLeft : Foot::kRight).length_m(), 0.4};
  const std::vector<PointState> joints = steps_[0]->Joints({moment.hip.get(), moment.ankle.get(), moment.ball.get()}, {false, 0.4}, w(0), place_);
  const double heel = (joints[1].position_m + joints[1].rotation * moment.heel_offset_m).y(), ball = joints[2].position_m.y();
  const auto missing = [&] {
    double values[2] = {0, 0};
    const double* parameters[] = {w(0).data(), place_.data()};
    PlantedMoment other = moment;
    other.phase = 0.7;
    ReachResidual(steps_[0], {moment, other}, 0.001).Evaluate(parameters, values, nullptr);
    return values[0] * 0.001;
  };
  // A foot that is low enough, or that is not held, lacks nothing.
  moment.hold[0] = moment.hold[1] = 1;
  moment.height_m[0] = heel + 0.01;
  moment.height_m[1] = ball + 0.01;
  EXPECT_EQ(missing(), 0);
  CheckOfStep(ReachResidual(steps_[0], {moment}, 0.001));
  moment.height_m[0] = heel - 0.2;
  moment.height_m[1] = ball - 0.15;
  moment.hold[0] = moment.hold[1] = 0;
  EXPECT_EQ(missing(), 0);
  // One that is to come down farther than the leg can be stretched lacks the rest: as far as it is from the hip in the world.
  moment.hold[0] = 0.8;
  moment.hold[1] = 0.5;
  const FootLockOptions lock;
  const double drop = lock.level * (0.8 * 0.2 + 0.5 * 0.15) / (1 + lock.level * 1.3);
  const Eigen::Vector3d leg = joints[1].position_m - joints[0].position_m;
  EXPECT_NEAR(missing(), (leg - Eigen::Vector3d(0, drop, 0)).norm() - leg.norm() - lock.stretch * (moment.leg_length_m - leg.norm()), 1e-9);
  EXPECT_GT(missing(), 0.01);
  CheckOfStep(ReachResidual(steps_[0], {moment}, 0.001));
}

// Nearly all steps that are drawn keep to the range of their primitive, and some come near its bounds.
TEST_F(ControlResidual, SwingsKeepToTheirRange) {
  int beyond = 0, steps = 0;
  double most = 0;
  KinematicsCache kinematics(*graph_);
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    std::mt19937_64 rng(seed);
    const DrawnWalk drawn = DrawWalk(*graph_, {.style = 0, .steps = 8}, rng);
    for (const DrawnStep& step : drawn.steps) {
      const int side = LandingFoot(graph_->primitive(step.step.primitive));
      if (side < 0) continue;
      const auto ball = Chain(side == 0 ? JointRole::kLeftToe : JointRole::kRightToe);
      const SwingRange& range = kinematics.SwingsOf(step.step, *ball);
      const double part = SwingOf(*kinematics.Of(step.step), *ball, step.step.whitened).speed_m_s.maxCoeff() / range.speed_m_s;
      most = std::max(most, part);
      ++steps;
      if (part > 1) ++beyond;
    }
  }
  EXPECT_LT(beyond, 0.05 * steps);
  EXPECT_GT(most, 0.9);
}

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
