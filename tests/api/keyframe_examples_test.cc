#include "api/keyframe_examples.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/errors.h"
#include "datasets/synthetic_gait.h"

namespace morphograph {
namespace {

std::vector<LoadedClip> Clips(const std::vector<std::string>& files) {
  std::vector<LoadedClip> clips;
  for (const std::string& file : files) {
    LoadedClip loaded;
    loaded.clip = GenerateGait({});
    loaded.file = file;
    loaded.clip.name = loaded.file.stem().string();
    loaded.first_frame = 10;
    clips.push_back(std::move(loaded));
  }
  return clips;
}

std::vector<int> Frames(const std::vector<LabelledFrame>& labels) {
  std::vector<int> frames;
  for (const LabelledFrame& label : labels) frames.push_back(label.frame);
  return frames;
}

TEST(MatchLabels, ByStemOrByPathInFramesOfTheClip) {
  const std::vector<LoadedClip> clips = Clips({"data/a/walk.bvh", "data/b/walk.bvh", "data/b/run.v2.bvh"});
  const MatchedLabels matched = MatchLabels({{"run.v2", {{30, "left_strike"}, {5, "left_strike"}, {40, "left_strike", true}}},
                                             {"b/walk.bvh", {{10, "left_strike"}, {1'000'000, "right_strike"}}},
                                             {"elsewhere/jump.bvh", {{1, "x"}}}},
                                            clips, "labels.json");
  EXPECT_THAT(Frames(matched.frames[0]), ::testing::IsEmpty());
  EXPECT_THAT(Frames(matched.frames[1]), ::testing::ElementsAre(0));
  EXPECT_THAT(Frames(matched.frames[2]), ::testing::ElementsAre(20));
  EXPECT_EQ(matched.notes.size(), 1u);
  EXPECT_THROW(MatchLabels({{"walk", {{20, "x"}}}}, clips, "labels.json"), DatasetError);       // which of two?
  EXPECT_THROW(MatchLabels({{"c/walk.bvh", {{20, "x"}}}}, clips, "labels.json"), DatasetError);  // neither
  EXPECT_THROW(MatchLabels({{"run.v2", {{5, "x"}}}}, clips, "labels.json"), DatasetError);       // nothing in use
  EXPECT_THROW(MatchLabels({{"", {{20, "x"}}}}, clips, "labels.json"), DatasetError);
  EXPECT_THAT(Frames(MatchLabels({{"", {{20, "x"}}}}, Clips({"one.bvh"}), "labels.json").frames[0]), ::testing::ElementsAre(10));
}

}  // namespace
}  // namespace morphograph
