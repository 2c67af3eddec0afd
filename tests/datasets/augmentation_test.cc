#include "datasets/augmentation.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "datasets/synthetic_gait.h"

namespace morphograph {
namespace {

TEST(Augmentation, AddsMirroredAndBentCopiesInAFixedOrder) {
  SyntheticGaitOptions gait;
  gait.steps = 4;
  gait.style = "plain";
  std::vector<MotionClip> clips = {GenerateGait(gait)};
  gait.seed = 2;
  clips.push_back(GenerateGait(gait));
  DatasetManifest manifest;
  manifest.mirror = manifest.bend = true;
  const AugmentationOptions options = AugmentationOf(manifest);
  const std::vector<AugmentedClip> all = Augment(clips, options, 2);
  const size_t each = 2 * (1 + options.bends_rad.size());
  ASSERT_EQ(all.size(), 2 * each);
  EXPECT_FALSE(all[0].made);
  EXPECT_EQ(all[0].clip.name, clips[0].name);
  EXPECT_TRUE(all[1].made);
  EXPECT_EQ(all[1].clip.name, clips[0].name + "_mirrored");
  EXPECT_EQ(all[2].clip.name, clips[0].name + "_bent_left_7");
  EXPECT_EQ(std::count_if(all.begin(), all.end(), [](const AugmentedClip& copy) { return !copy.made; }), 2);
  for (const AugmentedClip& copy : all) EXPECT_EQ(copy.clip.style, "plain");

  const std::vector<AugmentedClip> alone = Augment(clips, options, 1);
  for (size_t i = 0; i < all.size(); ++i) EXPECT_EQ(alone[i].clip.root_positions(), all[i].clip.root_positions());
}

TEST(Augmentation, WithoutFlagsGivesTheClipsThemselves) {
  const std::vector<MotionClip> clips = {GenerateGait({})};
  const std::vector<AugmentedClip> all = Augment(clips, AugmentationOf(DatasetManifest()));
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].clip.root_positions(), clips[0].root_positions());
}

TEST(Augmentation, TheDefaultModelsManifestNamesItsSourceAndAsksForCopies) {
  const DatasetManifest manifest =
      ReadManifest(std::filesystem::path(MORPHOGRAPH_SOURCE_DIR) / "datasets/models/walk.manifest.json");
  EXPECT_TRUE(manifest.mirror && manifest.bend);
  EXPECT_FALSE(manifest.source.empty() || manifest.licence.empty() || manifest.attribution.empty());
  EXPECT_TRUE(Includes(manifest, "07/07_03.bvh"));
  EXPECT_FALSE(Includes(manifest, "06/06_07.bvh"));  // walks backwards
}

}  // namespace
}  // namespace morphograph
