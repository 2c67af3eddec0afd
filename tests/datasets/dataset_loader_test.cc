#include "datasets/dataset_loader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/errors.h"
#include "tests/datasets/bvh_test_files.h"
#include "tests/support/shared_data.h"
#include "tests/support/temporary_folder.h"

namespace morphograph {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::kSmallBvh;

std::vector<std::string> Names(const Dataset& dataset) {
  std::vector<std::string> names;
  for (const LoadedClip& loaded : dataset.clips) names.push_back(loaded.clip.name + "/" + loaded.clip.style);
  return names;
}

template <typename Body>
std::string LoadError(const Body& body) {
  try {
    body();
  } catch (const DatasetError& error) {
    return error.what();
  }
  return "";
}

TEST(DatasetLoader, FindsFilesByNameAtAnyDepthAndEachOnce) {
  const testing::TemporaryFolder folder;
  folder.Write("b.bvh", kSmallBvh);
  folder.Write("a/z.BVH", kSmallBvh);
  folder.Write("a/y.bvh", kSmallBvh);
  folder.Write("a/._y.bvh", "not a clip");
  folder.Write("a/readme.txt", "not a clip");
  std::vector<std::string> names;
  for (const auto& file : FindBvhFiles({folder.path() / "b.bvh", folder.path()})) {
    names.push_back(file.lexically_relative(folder.path()).generic_string());
  }
  EXPECT_THAT(names, ElementsAre("b.bvh", "a/y.bvh", "a/z.BVH"));
}

TEST(DatasetLoader, TakesStylesFromNamesOnlyWhenAllNamesAgree) {
  const testing::TemporaryFolder folder;
  folder.Write("set_walk_old_001.bvh", kSmallBvh);
  folder.Write("set_walk_young_001.bvh", kSmallBvh);
  EXPECT_THAT(Names(LoadDataset({folder.path()}, DatasetManifest(), 2)),
              ElementsAre("set_walk_old_001/old", "set_walk_young_001/young"));
  folder.Write("07_01.bvh", kSmallBvh);
  EXPECT_THAT(Names(LoadDataset({folder.path()}, DatasetManifest(), 2)),
              ElementsAre("07_01/", "set_walk_old_001/", "set_walk_young_001/"));
}

TEST(DatasetLoader, ObeysTheManifest) {
  const testing::TemporaryFolder folder;
  for (const char* name : {"a_x.bvh", "b_y.bvh", "c_z.bvh", "d_w.bvh"}) folder.Write(name, kSmallBvh);
  const DatasetManifest manifest = ParseManifest(R"({
    "style": "_(.)$", "exclude": ["d*"], "metres_per_unit": 0.02,
    "clips": {"a_x": {"from": 1}, "b_y": {"to": 0, "style": "other"}, "c_z": {"exclude": true}, "gone": {}}})", "m");
  const Dataset dataset = LoadDataset({folder.path()}, manifest);
  EXPECT_THAT(Names(dataset), ElementsAre("a_x/x", "b_y/other"));
  EXPECT_EQ(dataset.clips[0].clip.frame_count(), 2);
  EXPECT_EQ(dataset.clips[0].first_frame, 1);
  EXPECT_DOUBLE_EQ(dataset.clips[0].clip.root_positions()(1, 0), 96 * 0.02);
  EXPECT_EQ(dataset.clips[1].clip.frame_count(), 1);
  EXPECT_EQ(dataset.clips[1].first_frame, 0);
  EXPECT_EQ(dataset.skipped.size(), 2u);
  ASSERT_EQ(dataset.notes.size(), 1u);
  EXPECT_THAT(dataset.notes[0], HasSubstr("gone"));
}

TEST(DatasetLoader, ClipsKnowWhichOtherActionTheyShow) {
  const testing::TemporaryFolder folder;
  folder.Write("runs/a.bvh", kSmallBvh);
  folder.Write("walks/a_walk.bvh", kSmallBvh);
  const DatasetManifest manifest = ParseManifest(R"({"actions": {"run": ["runs/*"]}})", "set.json");
  const Dataset dataset = LoadDataset({folder.path()}, manifest);
  ASSERT_EQ(dataset.clips.size(), 2u);
  EXPECT_EQ(dataset.clips[0].other_action, "run");
  EXPECT_EQ(dataset.clips[1].other_action, "");
}

TEST(DatasetLoader, ANestedStylePatternTakesNoExponentialTime) {
  const testing::TemporaryFolder folder;
  const std::string stem(200, 'a');
  folder.Write(stem + "b.bvh", kSmallBvh);
  folder.Write(stem + "_x_1.bvh", kSmallBvh);
  const DatasetManifest manifest = ParseManifest(R"({"style": "^(?:(?:a+)+)+_([a-z])_"})", "m");
  EXPECT_THAT(Names(LoadDataset({folder.path()}, manifest)), ElementsAre(stem + "_x_1/x", stem + "b/"));
}

TEST(DatasetLoader, ErrorsNameTheFile) {
  const testing::TemporaryFolder folder;
  EXPECT_THAT(LoadError([&] { LoadDataset({folder.path()}); }), HasSubstr("no *.bvh file found"));
  EXPECT_THAT(LoadError([&] { LoadDataset({folder.path() / "none"}); }), HasSubstr("none: no such file or folder"));
  folder.Write("good.bvh", kSmallBvh);
  folder.Write("broken1.bvh", std::string(kSmallBvh).substr(0, 300));
  folder.Write("broken2.bvh", "");
  for (const int jobs : {1, 4}) {
    EXPECT_THAT(LoadError([&] { LoadDataset({folder.path()}, DatasetManifest(), jobs); }), HasSubstr("broken1.bvh:")) << jobs;
    EXPECT_THAT(LoadError([&] { LoadDataset({folder.path()}, DatasetManifest(), jobs); }), HasSubstr("2 files are broken, also: broken2.bvh")) << jobs;
  }
  const DatasetLimits tight{.file = {}, .max_joint_frames = 10};
  EXPECT_THAT(LoadError([&] { LoadDataset({folder.path() / "good.bvh"}, DatasetManifest(), 1, tight); }), HasSubstr("good.bvh: the set is too large"));
  EXPECT_THAT(LoadError([&] {
                LoadDataset({folder.path()}, ParseManifest(R"({"include": ["good*"], "clips": {"good": {"to": 3}}})", "m"));
              }),
              HasSubstr("good.bvh: the manifest asks for frame 3 of 3"));
  EXPECT_THAT(LoadError([&] { LoadDataset({folder.path()}, ParseManifest(R"({"include": ["x"]})", "m")); }),
              HasSubstr("m: leaves none of the files"));
}

TEST(DatasetLoader, ReadsRealWalksAndCountsFramesInTheFile) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const DatasetManifest manifest = ParseManifest(R"({"clips": {"07_12": {"from": 10, "to": 100}}})", "m");
  const Dataset dataset = LoadDataset({testing::SharedData() / "cmu" / "07"}, manifest, 2);
  ASSERT_EQ(dataset.clips.size(), 12u);
  EXPECT_EQ(dataset.clips[0].clip.name, "07_01");
  EXPECT_EQ(dataset.clips[0].first_frame, 1);  // the T-pose row
  EXPECT_EQ(dataset.clips[11].first_frame, 10);
  EXPECT_EQ(dataset.clips[11].clip.frame_count(), 91);
  for (const LoadedClip& loaded : dataset.clips) EXPECT_TRUE(loaded.clip.style.empty());
}

}  // namespace
}  // namespace morphograph
