#include "datasets/manifest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/errors.h"

namespace morphograph {
namespace {

using ::testing::HasSubstr;

std::string ManifestError(const std::string& json) {
  try {
    ParseManifest(json, "set.json");
  } catch (const DatasetError& error) {
    return error.what();
  }
  return "";
}

TEST(Manifest, ReadsEveryField) {
  const DatasetManifest manifest = ParseManifest(R"({
    "name": "n", "action": "run", "source": "s", "licence": "l", "attribution": "a",
    "metres_per_unit": 0.0254, "up_axis": "Z", "roles": {"left_toe": "Toe.L"},
    "style": "_([a-z]+)_", "include": ["walk*"], "exclude": ["*33*", "old/*"],
    "clips": {"06_02": {"from": 12, "to": 600, "style": "ball"}, "06_07": {"exclude": true}},
    "mirror": true, "bend": true, "keyframes": "labels/mine.json"})", "sets/set.json");
  EXPECT_EQ(manifest.name, "n");
  EXPECT_EQ(manifest.action, "run");
  EXPECT_EQ(manifest.source, "s");
  EXPECT_EQ(manifest.licence, "l");
  EXPECT_EQ(manifest.attribution, "a");
  EXPECT_EQ(manifest.import.metres_per_unit, 0.0254);
  EXPECT_EQ(manifest.import.up_axis, UpAxis::kZ);
  EXPECT_EQ(manifest.import.roles.at("left_toe"), "Toe.L");
  EXPECT_EQ(manifest.style_pattern, "_([a-z]+)_");
  EXPECT_EQ(manifest.clips.at("06_02").from, 12);
  EXPECT_EQ(manifest.clips.at("06_02").to, 600);
  EXPECT_EQ(manifest.clips.at("06_02").style, "ball");
  EXPECT_FALSE(manifest.clips.at("06_02").exclude);
  EXPECT_TRUE(manifest.clips.at("06_07").exclude);
  EXPECT_TRUE(manifest.mirror && manifest.bend);
  EXPECT_EQ(manifest.keyframe_examples, std::filesystem::path("sets/labels/mine.json"));
  EXPECT_TRUE(Includes(manifest, "walk_01.bvh"));
  EXPECT_TRUE(Includes(manifest, "a/walk_01.bvh"));
  EXPECT_FALSE(Includes(manifest, "walk_33.bvh"));
  EXPECT_FALSE(Includes(manifest, "old/walk_01.bvh"));
  EXPECT_FALSE(Includes(manifest, "run_01.bvh"));
}

TEST(Manifest, SaysWhichFilesShowAnotherAction) {
  const DatasetManifest manifest = ParseManifest(R"({"actions": {"run": ["*_run_*", "runs/*"], "hop": ["*hop*"]}})", "set.json");
  EXPECT_EQ(OtherAction(manifest, "set_run_01.bvh"), "run");
  EXPECT_EQ(OtherAction(manifest, "runs/01.bvh"), "run");
  EXPECT_EQ(OtherAction(manifest, "hop_01.bvh"), "hop");
  EXPECT_EQ(OtherAction(manifest, "runs/hop_01.bvh"), "hop") << "the first by name";
  EXPECT_EQ(OtherAction(manifest, "set_walk_01.bvh"), "");
  EXPECT_THAT(ManifestError(R"({"actions": ["run"]})"), HasSubstr("set.json: /actions: expected an object"));
  EXPECT_THAT(ManifestError(R"({"actions": {"run": "*_run_*"}})"), HasSubstr("set.json: /actions/run: expected an array of strings"));
  EXPECT_THAT(ManifestError(R"({"actions": {"run": []}})"), HasSubstr("set.json: /actions/run: has no pattern"));
  EXPECT_THAT(ManifestError(R"({"actions": {"walk": ["*"]}})"), HasSubstr("set.json: /actions/walk: must name another action"));
  EXPECT_THAT(ManifestError(R"({"action": "run", "actions": {"run": ["*"]}})"), HasSubstr("/actions/run: must name another action"));
}

TEST(Manifest, AnEmptyObjectLeavesTheDefaults) {
  const DatasetManifest manifest = ParseManifest("\xEF\xBB\xBF{}", "set.json");
  EXPECT_EQ(manifest.action, "walk");
  EXPECT_EQ(manifest.keyframes, "walking");
  EXPECT_FALSE(manifest.mirror || manifest.bend || manifest.import.metres_per_unit || manifest.import.up_axis);
  EXPECT_TRUE(Includes(manifest, "anything.bvh"));
}

TEST(Manifest, ErrorsNameTheFileAndTheMember) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {R"({"colour": 1})", "set.json: /colour: unknown field"},
      {R"({"clips": {"a/b": {"form": 1}}})", "/clips/a~1b/form: unknown field"},
      {R"({"clips": {"a": {"from": 9, "to": 8}}})", "/clips/a/to: lies before"},
      {R"({"clips": {"a": {"from": -1}}})", "/clips/a/from: expected a frame number"},
      {R"({"clips": {"a": {"from": 1.5}}})", "/clips/a/from: expected a frame number"},
      {R"({"clips": {"a": {"to": 5000000000}}})", "/clips/a/to: expected a frame number"},
      {R"({"clips": []})", "/clips: expected an object"},
      {R"({"metres_per_unit": 0})", "/metres_per_unit: expected a positive number"},
      {R"({"metres_per_unit": "1"})", "/metres_per_unit"},
      {R"({"up_axis": "X"})", "/up_axis: expected"},
      {R"({"roles": {"tail": "Tail"}})", "/roles/tail: no such joint role"},
      {R"({"roles": {"head": 3}})", "/roles/head: expected a string"},
      {R"({"style": "("})", "/style: not a regular expression"},
      {R"({"style": "abc"})", "/style: has no group"},
      {R"({"include": "a"})", "/include: expected an array"},
      {R"({"include": ["a", 3]})", "/include/1: expected a string"},
      {R"({"mirror": 1})", "/mirror: expected true or false"},
      {R"({"keyframes": "dancing"})", "/keyframes: expected"},
      {R"({"action": ""})", "/action: is empty"},
      {R"({"name": "a", "name": "b"})", "\"name\" stands twice"},
      {"[]", "the whole document: expected an object"},
      {"{\n  \"name\": \n}", "set.json:3:1: not valid JSON"},
      {"", "set.json:1:1: not valid JSON"},
      {std::string(100000, '['), "nested deeper"},
  };
  for (const auto& [json, expected] : cases) EXPECT_THAT(ManifestError(json), HasSubstr(expected)) << json.substr(0, 60);
}

// Patterns come from strangers too (POST /v1/models): none may take the stack or exponential time.
TEST(Manifest, DeepAndNestedPatternsAreBounded) {
  EXPECT_THAT(ManifestError(R"({"style": ")" + std::string(100000, '(') + R"("})"), HasSubstr("/style: not a regular expression"));
  std::string deep(100000, '(');
  deep.append("a").append(100000, ')');
  EXPECT_LT(ManifestError(R"({"style": ")" + deep + R"("})").size(), 500u);  // taken or refused, as RE2 likes
  EXPECT_THAT(ManifestError(R"j({"style": "((((a{100}){100}){100}){100})"})j"), HasSubstr("/style: not a regular expression"));
  EXPECT_EQ(ManifestError(R"({"style": "^(a+)+$"})"), "");
}

TEST(Manifest, ManyStarsAgainstALongNameEndSoon) {
  DatasetManifest manifest;
  std::string stars = "*";
  for (int i = 0; i < 60; ++i) stars += "a*";
  manifest.include = {stars + "b"};
  EXPECT_FALSE(Includes(manifest, std::string(4000, 'a')));
  EXPECT_TRUE(Includes(manifest, std::string(4000, 'a') + "b"));
}

TEST(Manifest, AMissingFileIsNamed) {
  try {
    ReadManifest("/nowhere/set.json");
    FAIL();
  } catch (const DatasetError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/nowhere/set.json: cannot be opened: No such file"));
  }
}

}  // namespace
}  // namespace morphograph
