#include "primitives/decomposition.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "datasets/bvh_reader.h"
#include "datasets/clip_conversion.h"
#include "datasets/synthetic_gait.h"
#include "primitives/keyframe_detector.h"
#include "tests/support/shared_data.h"

namespace morphograph {
namespace {

std::vector<Segment> Cut(const MotionClip& clip) { return Decompose(clip, 3, DetectKeyframes(clip)); }

std::vector<std::string> Names(const std::vector<Segment>& segments) {
  std::vector<std::string> names;
  for (const Segment& segment : segments) names.push_back(segment.primitive);
  return names;
}

SyntheticGaitOptions WholeWalk() {
  SyntheticGaitOptions options;
  options.steps = 6;
  options.stand_s = 1;
  return options;
}

TEST(Decomposition, AWholeWalkIsAStartAlternatingStepsAndAnEnd) {
  const std::vector<Segment> segments = Cut(GenerateGait(WholeWalk()));
  EXPECT_THAT(Names(segments), ::testing::ElementsAre("left_first_start", "right_walk", "left_walk", "right_walk",
                                                      "left_walk", "right_walk", "left_end"));
  for (size_t i = 0; i < segments.size(); ++i) {
    EXPECT_EQ(segments[i].clip, 3);
    EXPECT_EQ(segments[i].previous, static_cast<int>(i) - 1);
    if (i > 0) {
      EXPECT_EQ(segments[i].start_frame, segments[i - 1].end_frame);
    }
  }
}

TEST(Decomposition, TheOtherFirstFootSwapsSides) {
  SyntheticGaitOptions options = WholeWalk();
  options.left_first = false;
  EXPECT_THAT(Names(Cut(GenerateGait(options))),
              ::testing::ElementsAre("right_first_start", "left_walk", "right_walk", "left_walk", "right_walk",
                                     "left_walk", "right_end"));
}

TEST(Decomposition, StepsNextToAStartAndAStopAreNotSteady) {
  const std::vector<Segment> segments = Cut(GenerateGait(WholeWalk()));
  ASSERT_EQ(segments.size(), 7u);
  EXPECT_FALSE(segments[1].steady);
  EXPECT_TRUE(segments[3].steady);
  EXPECT_FALSE(segments[5].steady);
}

TEST(Decomposition, ASlowFirstStepOfAClipThatBeginsInTheWalkIsAStart) {
  SyntheticGaitOptions options = WholeWalk();
  options.steps = 10;
  SyntheticGaitTruth truth;
  const MotionClip whole = GenerateGait(options, &truth);
  EXPECT_FALSE(Cut(whole)[0].slow_step) << "out of standing";
  // Cut a little before the first landing: the step that comes then still gathers speed.
  const int cut = static_cast<int>((truth.strikes[0].time_s - 0.2) * whole.frame_rate_hz());
  const std::vector<Segment> segments = Cut(whole.Slice(cut, whole.frame_count() - cut));
  ASSERT_GE(segments.size(), 6u);
  EXPECT_EQ(segments[0].primitive, "right_first_start");
  EXPECT_TRUE(segments[0].slow_step && segments[0].steady);
  EXPECT_EQ(segments[0].start, KeyframeLabel::kDoubleStance);
  EXPECT_EQ(segments[0].end, KeyframeLabel::kRightStance);
  EXPECT_EQ(segments[1].primitive, "left_walk");
  EXPECT_EQ(segments[1].previous, 0) << "it leads into the walk";
  EXPECT_EQ(std::count_if(segments.begin(), segments.end(), [](const Segment& s) { return s.slow_step; }), 1);
}

TEST(Decomposition, AStepAtFullSpeedStartsNothing) {
  SyntheticGaitOptions options = WholeWalk();
  options.steps = 12;
  options.start_standing = options.stop_standing = false;
  for (const Segment& segment : Cut(GenerateGait(options))) {
    EXPECT_FALSE(segment.slow_step);
    EXPECT_TRUE(segment.primitive.ends_with("_walk")) << segment.primitive;
  }
}

TEST(Decomposition, SegmentsKeepTheirMarginInTheClip) {
  SyntheticGaitOptions options = WholeWalk();
  options.start_standing = options.stop_standing = false;
  const MotionClip clip = GenerateGait(options);
  const std::vector<Segment> segments = Cut(clip);
  ASSERT_FALSE(segments.empty());
  for (const Segment& segment : segments) {
    const double margin = 0.25 * (segment.end_frame - segment.start_frame);
    EXPECT_GE(segment.start_frame, margin);
    EXPECT_LE(segment.end_frame + margin, clip.frame_count() - 1);
  }
}

TEST(Decomposition, AMissedLandingLeavesAHoleAndNoSegmentAcrossIt) {
  const MotionClip clip = GenerateGait(WholeWalk());
  std::vector<Keyframe> keyframes = DetectKeyframes(clip);
  const auto stance = std::find_if(keyframes.begin() + 4, keyframes.end(), [](const Keyframe& keyframe) {
    return keyframe.label == KeyframeLabel::kRightStance;
  });
  ASSERT_NE(stance, keyframes.end());
  const double missing = stance->frame;
  keyframes.erase(stance);
  const std::vector<Segment> segments = Decompose(clip, 0, keyframes);
  EXPECT_EQ(segments.size(), 5u);
  EXPECT_EQ(std::count_if(segments.begin(), segments.end(), [](const Segment& s) { return s.previous < 0; }), 2);
  for (const Segment& segment : segments) {
    EXPECT_FALSE(segment.start_frame < missing && missing < segment.end_frame) << segment.primitive;
  }
}

TEST(Decomposition, BackwardStepsAndFrozenRecordingsAreNotSteady) {
  MotionClip clip = GenerateGait(WholeWalk());
  const std::vector<Keyframe> keyframes = DetectKeyframes(clip);
  // The walk run backwards in time goes backwards in space.
  MotionClip backwards = clip;
  std::vector<Keyframe> reversed;
  for (int f = 0; f < clip.frame_count(); ++f) {
    const int from = clip.frame_count() - 1 - f;
    for (int j = 0; j < clip.joint_count(); ++j) backwards.rotation(f, j) = clip.rotation(from, j);
    backwards.root_positions().col(f) = clip.root_positions().col(from);
  }
  for (auto it = keyframes.rbegin(); it != keyframes.rend(); ++it) {
    reversed.push_back({clip.frame_count() - 1 - it->frame, it->label});
  }
  for (const Segment& segment : Decompose(backwards, 0, reversed)) EXPECT_FALSE(segment.steady) << segment.primitive;

  const std::vector<Segment> segments = Decompose(clip, 0, keyframes);
  ASSERT_TRUE(segments[3].steady);
  const int middle = static_cast<int>(0.5 * (segments[3].start_frame + segments[3].end_frame));
  for (int f = middle; f < middle + 5; ++f) clip.root_positions().col(f) = clip.root_positions().col(middle);
  EXPECT_FALSE(Decompose(clip, 0, keyframes)[3].steady);
}

TEST(Decomposition, TakesClipsWithoutSteps) {
  const MotionClip clip = GenerateGait(WholeWalk());
  EXPECT_TRUE(Decompose(clip, 0, {}).empty());
  EXPECT_TRUE(Cut(clip.Slice(0, 1)).empty());
  EXPECT_TRUE(Cut(clip.Slice(0, 40)).empty());
}

TEST(Decomposition, RefusesKeyframesOutOfOrderOrOutside) {
  const MotionClip clip = GenerateGait(WholeWalk());
  EXPECT_THROW(Decompose(clip, 0, {{40, KeyframeLabel::kLeftStance}, {20, KeyframeLabel::kRightStance}}),
               std::invalid_argument);
  EXPECT_THROW(Decompose(clip, 0, {{1e6, KeyframeLabel::kLeftStance}}), std::invalid_argument);
}

struct Recording {
  const char* path;
  int least_steady, most_steady;  // walking steps
  int slow_starts = 0, starts = 0, ends = 0, slow_ends = 0;  // slow first and last steps; out of standing, back to it
};

class Recordings : public ::testing::TestWithParam<Recording> {};

TEST_P(Recordings, HoldTheStepsThatTheyShow) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const MotionClip clip = ImportClip(ReadBvhFile(testing::SharedData() / GetParam().path));
  const std::vector<Segment> segments = Cut(clip);
  const auto steady = std::count_if(segments.begin(), segments.end(), [](const Segment& segment) {
    return segment.steady && segment.primitive.ends_with("_walk");
  });
  EXPECT_GE(steady, GetParam().least_steady);
  EXPECT_LE(steady, GetParam().most_steady);
  const auto count = [&](const std::string& kind, bool slow) {
    return std::count_if(segments.begin(), segments.end(), [&](const Segment& segment) {
      return segment.steady && segment.slow_step == slow && segment.primitive.ends_with(kind);
    });
  };
  EXPECT_EQ(count("_first_start", true), GetParam().slow_starts);
  EXPECT_EQ(count("_end", true), GetParam().slow_ends);
  EXPECT_EQ(count("_first_start", false), GetParam().starts);
  EXPECT_EQ(count("_end", false), GetParam().ends);
}

INSTANTIATE_TEST_SUITE_P(Shared, Recordings,
                         ::testing::Values(Recording{"cmu/07/07_01.bvh", 3, 4},
                                           Recording{"cmu/06/06_07.bvh", 0, 0},  // backwards
                                           Recording{"cmu/09/09_01.bvh", 0, 0},  // a run
                                           Recording{"cmu/06/06_02.bvh", 3, 5, 0, 1, 0},
                                           Recording{"real_imu/neura_s02/S02-Trial-Walk-1_xsens.bvh", 6, 9, 0, 1, 1},
                                           Recording{"bnr/dataset-2/walk/dataset-2_walk_normal_002.bvh", 12, 15},
                                           Recording{"bnr/dataset-2/walk/dataset-2_walk_active_021.bvh", 10, 13, 1},
                                           Recording{"bnr/dataset-2/walk/dataset-2_walk_elderly_001.bvh", 18, 24, 0, 0, 0, 1}));

}  // namespace
}  // namespace morphograph
