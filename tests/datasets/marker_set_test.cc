#include "datasets/marker_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

#include "datasets/bvh_reader.h"
#include "datasets/clip_conversion.h"
#include "datasets/synthetic_gait.h"
#include "datasets/virtual_sensors.h"
#include "tests/support/shared_data.h"

namespace morphograph {
namespace {

// Where the markers of a walking body must lie, whatever the skeleton's axes: sides, heights, fronts and backs, averaged over the clip.
void ExpectOnTheBody(const MotionClip& clip) {
  const std::vector<Placement> markers = FullBodyMarkers({clip});
  ASSERT_EQ(markers.size(), 41u);
  const Readings readings = VirtualMarkers(clip, markers);
  EXPECT_EQ(std::set<std::string>(readings.names.begin(), readings.names.end()).size(), 41u);
  std::map<std::string, Eigen::Vector3d> mean;  // left, up, forwards of the pelvis
  for (int f = 0; f < clip.frame_count(); ++f) {
    const Eigen::Quaterniond level(Eigen::AngleAxisd(-HeadingRad(clip, f), Eigen::Vector3d::UnitY()));
    for (std::size_t m = 0; m < 41; ++m) {
      const Eigen::Vector3d position = readings.values.col(f).segment<3>(3 * static_cast<Eigen::Index>(m)) - clip.root_positions().col(f);
      mean.try_emplace(readings.names[m], Eigen::Vector3d::Zero()).first->second += level * position / clip.frame_count();
    }
  }
  for (const auto& [name, place] : mean) {
    SCOPED_TRACE(name);
    if (name.starts_with("left_")) {
      EXPECT_GT(place.x(), 0);
      EXPECT_GT(place.x(), mean.at("right_" + name.substr(5)).x() + 0.05);
    }
    EXPECT_LT(place.norm(), 1.2);
  }
  EXPECT_GT(mean.at("left_front_head").y(), 0.4);
  EXPECT_GT(mean.at("left_front_head").z(), mean.at("left_back_head").z() + 0.1);
  EXPECT_GT(mean.at("sternum").z(), mean.at("right_back").z() + 0.15);
  EXPECT_GT(mean.at("left_asis").z(), mean.at("left_psis").z() + 0.15);
  EXPECT_LT(mean.at("left_heel").z(), mean.at("left_ball").z() - 0.1);
  EXPECT_LT(mean.at("right_heel").y(), mean.at("right_ankle").y());
  EXPECT_LT(mean.at("right_knee").y(), mean.at("right_thigh").y());
  EXPECT_LT(mean.at("right_shin").y(), mean.at("right_knee").y());
}

TEST(FullBodyMarkers, LieOnASyntheticWalkersBody) {
  SyntheticGaitOptions options;
  options.stature_m = 1.6;
  options.heading_rad = 2;
  ExpectOnTheBody(GenerateGait(options));
}

TEST(FullBodyMarkers, LieOnBodiesOfBothFamiliesOfRecordings) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const std::filesystem::path data = testing::SharedData();
  for (const char* file : {"bnr/dataset-2/walk/dataset-2_walk_active_001.bvh", "cmu/07/07_01.bvh"}) {
    SCOPED_TRACE(file);
    ExpectOnTheBody(ImportClip(ReadBvhFile(data / file)));
  }
}

TEST(FullBodyMarkers, RefuseABodyWithoutLegs) {
  EXPECT_THROW(FullBodyMarkers({}), std::invalid_argument);
  const auto stick = std::make_shared<const Skeleton>(std::vector<Joint>{{"root", -1, Eigen::Vector3d::Zero(), {}, {}}}, RoleMap(), 1.0, UpAxis::kY);
  EXPECT_THROW(FullBodyMarkers({MotionClip(stick, 30, 5)}), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
