// What the embedded model promises: walks that turn, start and stop.
#include "api/default_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "datasets/forward_kinematics.h"
#include "synthesis/motion_synthesizer.h"

namespace morphograph {
namespace {

TEST(DefaultModel, StartsAtRestAndEndsAtRest) {
  const std::shared_ptr<const MotionGraph> graph = LoadDefaultModel();
  ASSERT_TRUE(graph) << "datasets/models/walk.mgm was not there when this was built";
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SynthesisRequest request;
    request.seed = seed;
    request.duration_s = 6;
    request.start_from = request.end = WalkBoundary::kStanding;
    const SynthesisResult result = Synthesize(*graph, request);
    const Eigen::Matrix3Xd& root = result.clip.root_positions();
    const auto speed = [&](Eigen::Index f) {
      const Eigen::Vector3d step = root.col(f + 1) - root.col(f);
      return std::hypot(step.x(), step.z()) * result.clip.frame_rate_hz();
    };
    for (int f = 0; f < 2; ++f) {
      EXPECT_LT(speed(f), 0.15) << seed;
      EXPECT_LT(speed(root.cols() - 2 - f), 0.15) << seed;
    }
    for (Eigen::Index f = 0; f + 2 < root.cols(); ++f) {
      // Measured: 0.51 m/s within a frame, 0.36 in steady walking. A pose that is held brakes by 1 m/s, a leap between steps by 2 to 5; who goes on
      // after a start at another walker's speed leaps by 0.75.
      EXPECT_LT(std::abs(speed(f + 1) - speed(f)), 0.55) << seed << " frame " << f;
    }
    EXPECT_THAT(result.report.steps.front().primitive, ::testing::EndsWith("_first_start"));
    EXPECT_THAT(result.report.steps.back().primitive, ::testing::EndsWith("_end"));
    EXPECT_NEAR(result.report.duration_s, 6, 0.4) << seed;
    // A person walked in between.
    EXPECT_GT((root.rightCols(1) - root.leftCols(1)).norm(), 3) << seed;
  }
}

}  // namespace
}  // namespace morphograph
