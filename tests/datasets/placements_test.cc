#include "datasets/placements.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "datasets/errors.h"
#include "datasets/synthetic_skeleton.h"

namespace morphograph {
namespace {

using ::testing::HasSubstr;

std::string PlacementErrorOf(const std::string& text) {
  try {
    ParsePlacements(text, "p.json");
  } catch (const DatasetError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Placements, ComeBackAsTheyWere) {
  const std::vector<Placement> placements = ParsePlacements(
      R"({"placements": [{"joint": "left_wrist"}, {"name": "shin", "joint": "left_knee", "offset": [0.01, -0.2, 0.03], "orientation": [0.8, 0, 0.6, 0]}]})",
      "p.json");
  ASSERT_EQ(placements.size(), 2u);
  EXPECT_EQ(placements[0].name, "left_wrist");
  EXPECT_EQ(placements[0].offset_m, Eigen::Vector3d::Zero());
  EXPECT_EQ(placements[0].joint_from_sensor.coeffs(), Eigen::Quaterniond::Identity().coeffs());
  EXPECT_EQ(placements[1].joint, "left_knee");
  const std::vector<Placement> again = ParsePlacements(PlacementsJson(placements), "again.json");
  ASSERT_EQ(again.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(again[i].name, placements[i].name);
    EXPECT_EQ(again[i].joint, placements[i].joint);
    EXPECT_EQ(again[i].offset_m, placements[i].offset_m);
    EXPECT_LT(again[i].joint_from_sensor.angularDistance(placements[i].joint_from_sensor), 1e-7);
  }
  EXPECT_EQ(ParsePlacements(R"([{"joint": "head"}])", "p.json")[0].name, "head");
}

TEST(Placements, ErrorsNameThePlace) {
  EXPECT_THAT(PlacementErrorOf("{"), HasSubstr("p.json: not valid JSON"));
  EXPECT_THAT(PlacementErrorOf(std::string(100'000, '[')), HasSubstr("nested too deep"));
  EXPECT_THAT(PlacementErrorOf("3"), HasSubstr("the whole document: expected a list"));
  EXPECT_THAT(PlacementErrorOf("[]"), HasSubstr("the whole document: expected a list"));
  EXPECT_THAT(PlacementErrorOf("{}"), HasSubstr("\"placements\" is missing"));
  EXPECT_THAT(PlacementErrorOf(R"({"placements": [], "rate": 60})"), HasSubstr("/rate: unknown field"));
  EXPECT_THAT(PlacementErrorOf("[3]"), HasSubstr("/0: expected an object"));
  EXPECT_THAT(PlacementErrorOf("[{}]"), HasSubstr("/0: \"joint\" is missing"));
  EXPECT_THAT(PlacementErrorOf(R"([{"joint": ""}])"), HasSubstr("/0/joint: expected a text"));
  EXPECT_THAT(PlacementErrorOf(R"([{"joint": "head", "offset": [1, 2]}])"), HasSubstr("/0/offset: expected [x, y, z]"));
  EXPECT_THAT(PlacementErrorOf(R"([{"joint": "head", "offset": [1, 2, "3"]}])"), HasSubstr("/0/offset: expected [x, y, z]"));
  EXPECT_THAT(PlacementErrorOf(R"([{"joint": "head", "offset": [10, 0, 0]}])"), HasSubstr("/0/offset: lies more than 3 m"));
  EXPECT_THAT(PlacementErrorOf(R"([{"joint": "head", "orientation": [1, 1, 0, 0]}])"), HasSubstr("/0/orientation: must be a unit quaternion"));
  EXPECT_THAT(PlacementErrorOf(R"([{"joint": "head", "orientation": [0, 0, 0, 0]}])"), HasSubstr("/0/orientation: must be a unit quaternion"));
  EXPECT_THAT(PlacementErrorOf(R"({"placements": [{"joint": "head"}, {"joint": "head"}]})"), HasSubstr("/placements/1: a second placement is called 'head'"));
  EXPECT_THAT(PlacementErrorOf(R"([{"joint": "head", "name": "a,b"}])"), HasSubstr("/0/name: must hold no comma"));
  EXPECT_THAT(PlacementErrorOf(R"([{"joint": "head", "colour": "red"}])"), HasSubstr("/0/colour: unknown field"));
  std::string many = "[{\"joint\": \"head\"}";
  for (int i = 0; i < 500; ++i) many += ",{\"joint\": \"head\", \"name\": \"" + std::to_string(i) + "\"}";
  EXPECT_THAT(PlacementErrorOf(many + "]"), HasSubstr("more than 500"));
}

TEST(Placements, FindTheirJointsByRoleOrName) {
  const auto skeleton = SyntheticSkeleton();
  const std::vector<int> joints = JointsOf(PlacementsAtJoints({"left_wrist", skeleton->joint(3).name}), *skeleton);
  EXPECT_EQ(joints[0], skeleton->roles()[JointRole::kLeftWrist]);
  EXPECT_EQ(joints[1], 3);
  EXPECT_THROW(JointsOf(PlacementsAtJoints({"tail"}), *skeleton), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
