// Recordings that a model keeps.
#include "graph/recorded_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "graph/model_io.h"
#include "tests/support/small_model.h"

namespace morphograph {
namespace {

std::shared_ptr<const MotionGraph> ModelOf(bool keep_recordings) {
  std::vector<TrainingClip> clips;
  for (auto& [name, clip] : testing::SmallWalks()) clips.push_back({clip, false});
  clips.push_back({clips.front().clip, true});  // a copy, not to be kept
  TrainingOptions options;
  options.keep_recordings = keep_recordings;
  return BuildGraph(clips, options);
}

TEST(RecordedMotion, IsNotKeptUnlessAskedFor) { EXPECT_EQ(testing::SmallModel()->recordings(), nullptr); }

TEST(RecordedMotion, SurvivesTheModelFile) {
  const auto model = ParseModel(SerialiseModel(*ModelOf(true)), "model");
  ASSERT_NE(model->recordings(), nullptr);
  const RecordedMotion& motion = *model->recordings();
  const auto walks = testing::SmallWalks();
  const std::vector<MotionClip> clips = RecordedClips(motion, model->layout(), model->styles().front().mean_rotations);
  ASSERT_EQ(clips.size(), walks.size());
  for (std::size_t c = 0; c < clips.size(); ++c) {
    const MotionClip& wanted = walks[c].second;
    EXPECT_EQ(clips[c].name, wanted.name);
    EXPECT_EQ(clips[c].style, wanted.style);
    ASSERT_EQ(clips[c].frame_count(), wanted.frame_count());
    for (const int f : {0, wanted.frame_count() / 2, wanted.frame_count() - 1}) {
      const Eigen::Matrix3Xd there = ForwardKinematics(clips[c], f).positions, here = ForwardKinematics(wanted, f).positions;
      EXPECT_LT((there - here).colwise().norm().maxCoeff(), 1e-3) << wanted.name << " frame " << f;
    }
  }
  // 14 strikes a walk make some 12 steps from landing to landing, left and right in turn.
  EXPECT_GT(motion.steps.size(), 10 * walks.size());
  for (std::size_t s = 1; s < motion.steps.size(); ++s) {
    if (motion.steps[s].clip != motion.steps[s - 1].clip || motion.steps[s].start_frame != motion.steps[s - 1].end_frame) continue;
    EXPECT_NE(motion.steps[s].left, motion.steps[s - 1].left);
  }
}

TEST(RecordedMotion, ChangesNothingElseOfAModel) {
  const auto with = ModelOf(true), without = ModelOf(false);
  ASSERT_EQ(with->primitive_count(), without->primitive_count());
  for (int p = 0; p < with->primitive_count(); ++p) EXPECT_EQ(with->primitive(p).reduction.mean, without->primitive(p).reduction.mean);
}

TEST(RecordedMotion, ThatDoesNotFitIsRefused) {
  const auto model = ModelOf(true);
  RecordedMotion motion = *model->recordings();
  EXPECT_EQ(motion.Problem(model->layout()), "");
  motion.steps.front().end_frame = 1e6;
  EXPECT_THAT(motion.Problem(model->layout()), ::testing::HasSubstr("outside of its clip"));
  motion = *model->recordings();
  motion.clips.back().frames -= 1;
  EXPECT_NE(motion.Problem(model->layout()), "");
  motion = *model->recordings();
  motion.roots.conservativeResize(3, motion.roots.cols() - 1);
  EXPECT_NE(motion.Problem(model->layout()), "");
}

}  // namespace
}  // namespace morphograph
