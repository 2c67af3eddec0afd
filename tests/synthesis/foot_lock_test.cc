#include "synthesis/foot_lock.h"

#include <gtest/gtest.h>

#include "datasets/contact_detector.h"
#include "datasets/forward_kinematics.h"
#include "synthesis/internal/pentadiagonal_system.h"
#include "synthesis/motion_synthesizer.h"
#include "tests/support/small_model.h"

namespace morphograph {
namespace {

struct FootPoints {
  Eigen::Matrix3Xd heels, balls;
};

FootPoints PointsOf(const MotionClip& clip, const FeetGeometry& feet, int side) {
  const RoleMap& roles = clip.skeleton().roles();
  const int ankle = roles[side == 0 ? JointRole::kLeftAnkle : JointRole::kRightAnkle];
  const int toe = roles[side == 0 ? JointRole::kLeftToe : JointRole::kRightToe];
  FootPoints points{Eigen::Matrix3Xd(3, clip.frame_count()), Eigen::Matrix3Xd(3, clip.frame_count())};
  for (int f = 0; f < clip.frame_count(); ++f) {
    const WorldPose pose = ForwardKinematics(clip, f);
    points.heels.col(f) = pose.positions.col(ankle) + pose.rotations[ankle] * feet.heel_offset_m[side];
    points.balls.col(f) = pose.positions.col(toe);
  }
  return points;
}

class FootLockTest : public ::testing::Test {
 protected:
  FootLockTest() : model_(testing::SmallModel()), feet_(model_->styles().front().feet) {
    auto walks = testing::SmallWalks();
    clip_ = std::make_unique<MotionClip>(std::move(walks.front().second));
    // As if the steps knew exactly when which part is planted, and that it stands still at its usual height.
    contacts_ = ContactProfile::Zero(kContactRows, clip_->frame_count());
    contacts_.topRows(kFootParts) = DetectContacts(*clip_).planted.cast<double>().matrix();
    for (int side = 0; side < 2; ++side) {
      contacts_.row(kPlantedHeight + 2 * side).setConstant(feet_.heel_height_m[side]);
      contacts_.row(kPlantedHeight + 2 * side + 1).setConstant(feet_.ball_height_m[side]);
    }
  }
  void Lock(const FootLockOptions& options = {}) { LockFeet(feet_, model_->layout(), contacts_, options, clip_.get()); }
  std::shared_ptr<const MotionGraph> model_;
  FeetGeometry feet_;
  std::unique_ptr<MotionClip> clip_;
  ContactProfile contacts_;
};

TEST_F(FootLockTest, LearnsHowLowFeetCome) {
  for (int side = 0; side < 2; ++side) {
    EXPECT_LE(feet_.heel_lowest_m[side], feet_.heel_height_m[side]);
    EXPECT_LE(feet_.ball_lowest_m[side], feet_.ball_height_m[side]);
    EXPECT_GE(feet_.ball_lowest_m[side], feet_.ball_height_m[side] - 0.0091);
  }
}

TEST_F(FootLockTest, LiftsFeetThatComeLowerThanCapturedOnes) {
  clip_->root_positions().row(1).array() -= 0.03;
  ASSERT_LT(PointsOf(*clip_, feet_, 0).balls.row(1).minCoeff(), feet_.ball_lowest_m[0] - 0.01);
  Lock();
  for (int side = 0; side < 2; ++side) {
    const FootPoints points = PointsOf(*clip_, feet_, side);
    EXPECT_GT(points.balls.row(1).minCoeff(), feet_.ball_lowest_m[side] - 1e-6) << side;
    EXPECT_GT(points.heels.row(1).minCoeff(), feet_.heel_lowest_m[side] - 1e-6) << side;
  }
}

TEST_F(FootLockTest, LowersTheBodyWhereLegsAreTooStraightToReachTheFloor) {
  clip_->root_positions().row(1).array() += 0.05;
  const MotionClip before = *clip_;
  // Legs that must not be stretched at all: what is missing is the body's to give.
  Lock({.stretch = 0});
  const Eigen::VectorXd drops = (before.root_positions() - clip_->root_positions()).row(1);
  EXPECT_GT(drops.maxCoeff(), 0.03);
  EXPECT_LT(drops.maxCoeff(), 0.1);
  // Smoothly: no frame falls by more than a centimetre beyond what its neighbours do.
  for (int f = 1; f + 1 < before.frame_count(); ++f) {
    EXPECT_LT(std::abs(drops[f - 1] - 2 * drops[f] + drops[f + 1]), 0.01) << f;
  }
  double high = 0, was_high = 0;
  int count = 0;
  for (int side = 0; side < 2; ++side) {
    const FootPoints now = PointsOf(*clip_, feet_, side), then = PointsOf(before, feet_, side);
    for (int f = 2; f + 3 < before.frame_count(); ++f) {
      if (contacts_.row(2 * side + 1).segment(f - 2, 6).minCoeff() < 1) continue;
      high += now.balls(1, f) - feet_.ball_height_m[side], was_high += then.balls(1, f) - feet_.ball_height_m[side];
      ++count;
    }
  }
  ASSERT_GT(count, 10);
  EXPECT_GT(was_high / count, 0.045);
  EXPECT_LT(high / count, 0.015);
}

// Of two planted feet that both cannot be reached, one is hardly short: it must not keep the body up for the other.
TEST_F(FootLockTest, LowersTheBodyForTheLegThatLacksMost) {
  clip_->root_positions().row(1).array() += 0.04;
  contacts_.topRows(kFootParts).setOnes();
  contacts_.row(2).setZero(), contacts_.row(3).setZero();  // the left foot alone
  MotionClip alone = *clip_;
  LockFeet(feet_, model_->layout(), contacts_, {.stretch = 0}, &alone);
  contacts_.row(2).setOnes(), contacts_.row(3).setOnes();
  for (int part = 0; part < 2; ++part) {
    // The right foot a tenth of a millimetre lower than it is.
    const FootPoints points = PointsOf(*clip_, feet_, 1);
    contacts_.row(kPlantedHeight + 2 + part) = (part == 0 ? points.heels : points.balls).row(1).array() - 1e-4;
  }
  MotionClip both = *clip_;
  LockFeet(feet_, model_->layout(), contacts_, {.rolling = 1, .stretch = 0}, &both);
  const Eigen::VectorXd by_one = (clip_->root_positions() - alone.root_positions()).row(1), by_both = (clip_->root_positions() - both.root_positions()).row(1);
  ASSERT_GT(by_one.maxCoeff(), 0.02);
  EXPECT_LT(by_both.maxCoeff(), 0.052);
  const Eigen::ArrayXd lacks = (by_one.array() > 0.02).cast<double>();
  ASSERT_GT(lacks.sum(), 5);
  EXPECT_GT((lacks * by_both.array()).sum(), 0.9 * (lacks * by_one.array()).sum());
}

// A clip's feet go by its own steps, where their latents tell of them.
TEST(WalkClip, FeetDoWhatTheirStepSays) {
  const auto graph = testing::SmallModel();
  GraphContents contents;
  contents.name = graph->name(), contents.action = graph->action(), contents.frame_rate_hz = graph->frame_rate_hz();
  contents.layout = graph->layout(), contents.styles = graph->styles();
  for (int p = 0; p < graph->primitive_count(); ++p) contents.primitives.push_back(graph->primitive(p));
  for (int e = 0; e < graph->edge_count(); ++e) contents.edges.push_back({graph->edge_from(e), graph->edge_to(e), graph->transition(e)});
  SynthesisRequest request;
  request.seed = 5;
  request.duration_s = 4;
  const auto clip_with = [&](float slide, bool lock) {
    for (MotionPrimitive& primitive : contents.primitives) {
      primitive.contact_map.setZero(kContactRows * kPhaseSamples, primitive.reduction.components());
      for (int row = kPlantedHeight; row < kContactRows; ++row) {
        for (int sample = 0; sample < kPhaseSamples; ++sample) primitive.contact_map.row(sample * kContactRows + row).setConstant(slide);
      }
    }
    return Synthesize(MotionGraph(contents, ""), request, {.foot_lock = lock}).clip;
  };
  const auto apart = [&](bool lock) { return (PointsOf(clip_with(0, lock), contents.styles[0].feet, 0).balls - PointsOf(clip_with(0.01f, lock), contents.styles[0].feet, 0).balls).cwiseAbs().maxCoeff(); };
  EXPECT_GT(apart(true), 0.001);
  EXPECT_EQ(apart(false), 0);
}

TEST(HeldHeight, LeavesPartOfARiseAndAllOfASinking) {
  EXPECT_NEAR(HeldHeight_m(0.04, 0.06, {.rolling = 0.5}), 0.05, 1e-12);
  EXPECT_NEAR(HeldHeight_m(0.04, 0.03, {.rolling = 0.5}), 0.03, 1e-12);
}

TEST_F(FootLockTest, HoldsPlantedBallsOnTheirSpot) {
  // The root slides sideways under the feet, 10 cm/s.
  for (int f = 0; f < clip_->frame_count(); ++f) clip_->root_positions()(0, f) += 0.1 * f / clip_->frame_rate_hz();
  Lock({.hold_s = 2});
  double sum = 0;
  int count = 0;
  for (int side = 0; side < 2; ++side) {
    const FootPoints points = PointsOf(*clip_, feet_, side);
    for (int f = 2; f + 3 < clip_->frame_count(); ++f) {
      // The middle of stances: all around is planted.
      if (contacts_.row(2 * side + 1).segment(f - 2, 6).minCoeff() < 1) continue;
      const Eigen::Vector3d step = points.balls.col(f + 1) - points.balls.col(f);
      sum += std::hypot(step.x(), step.z()) * clip_->frame_rate_hz();
      ++count;
    }
  }
  ASSERT_GT(count, 10);
  EXPECT_LT(sum / count, 0.02);  // of the 0.1 m/s
}

TEST_F(FootLockTest, LeavesPartOfTheSlideThatCapturedFeetHave) {
  // Planted balls slide forwards at 10 cm/s, in the clip and in what was learned; what is left over is the option's part.
  const double heading = HeadingRad(*clip_, 0);
  for (int f = 0; f < clip_->frame_count(); ++f) {
    const double way = 0.1 * f / clip_->frame_rate_hz();
    clip_->root_positions()(0, f) += way * std::sin(heading);
    clip_->root_positions()(2, f) += way * std::cos(heading);
  }
  contacts_.middleRows(kSlideForward, kFootParts).setConstant(0.1);
  for (const double slide : {0.0, 0.5, 1.0}) {
    MotionClip clip = *clip_;
    LockFeet(feet_, model_->layout(), contacts_, {.slide = slide, .hold_s = 2}, &clip);
    const FootPoints points = PointsOf(clip, feet_, 0);
    double sum = 0;
    int count = 0;
    for (int f = 2; f + 3 < clip.frame_count(); ++f) {
      if (contacts_.row(1).segment(f - 2, 6).minCoeff() < 1) continue;
      const Eigen::Vector3d step = (points.balls.col(f + 1) - points.balls.col(f)) * clip.frame_rate_hz();
      sum += step.x() * std::sin(heading) + step.z() * std::cos(heading);
      ++count;
    }
    ASSERT_GT(count, 10);
    EXPECT_NEAR(sum / count, 0.1 * slide, 0.015) << slide;
  }
}

TEST_F(FootLockTest, ChangesNothingWhereNothingIsPlanted) {
  contacts_.topRows(kFootParts).setZero();
  const FootPoints before = PointsOf(*clip_, feet_, 0);
  const MotionClip clip = *clip_;
  Lock();
  EXPECT_EQ(clip_->root_positions(), clip.root_positions());
  EXPECT_LT((PointsOf(*clip_, feet_, 0).balls - before.balls).cwiseAbs().maxCoeff(), 0.002);
}

TEST_F(FootLockTest, LeavesHeadAndArmsAlone) {
  const MotionClip before = *clip_;
  clip_->root_positions().row(1).array() -= 0.01;
  Lock();
  const RoleMap& roles = clip_->skeleton().roles();
  for (const JointRole role : {JointRole::kHead, JointRole::kLeftWrist, JointRole::kHips}) {
    for (int f = 0; f < clip_->frame_count(); ++f) {
      ASSERT_EQ(clip_->rotation(f, roles[role]).coeffs(), before.rotation(f, roles[role]).coeffs());
    }
  }
}

TEST(PentadiagonalSystem, SolvesAsADenseSolverDoes) {
  const int n = 9;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  internal::PentadiagonalSystem system(n);
  const auto add = [&]<std::size_t k>(double weight, int first, const std::array<double, k>& coefficients) {
    system.Add(weight, first, coefficients);
    const Eigen::Map<const Eigen::VectorXd> row(coefficients.data(), static_cast<Eigen::Index>(k));
    dense.block(first, first, k, k) += weight * row * row.transpose();
  };
  for (int i = 0; i < n; ++i) {
    add(1.0 + i, i, std::array<double, 1>{1});
    if (i + 1 < n) add(3.0 - 0.2 * i, i, std::array<double, 2>{-1, 2});
    if (i + 2 < n) add(7.0 + 0.5 * i, i, std::array<double, 3>{1, -2, 1.5});
  }
  system.Factor();
  const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(n, -1, 3);
  Eigen::VectorXd solution = right;
  system.Solve(&solution);
  EXPECT_LT((dense * solution - right).norm(), 1e-12);
}

}  // namespace
}  // namespace morphograph
