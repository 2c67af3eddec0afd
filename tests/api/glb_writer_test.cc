#include "api/glb_writer.h"

#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "datasets/forward_kinematics.h"
#include "datasets/synthetic_gait.h"

namespace morphograph {
namespace {

using nlohmann::json;

/// Just enough of a glTF reader to play the animation back.
struct ReadGlb {
  explicit ReadGlb(const std::string& glb) {
    EXPECT_EQ(glb.substr(0, 4), "glTF");
    EXPECT_EQ(Word(glb, 4), 2u);
    EXPECT_EQ(Word(glb, 8), glb.size());
    const std::uint32_t json_size = Word(glb, 12);
    EXPECT_EQ(glb.substr(16, 4), "JSON");
    EXPECT_EQ(json_size % 4, 0u);
    document = json::parse(glb.substr(20, json_size));
    const std::size_t binary = 20 + json_size;
    EXPECT_EQ(glb.substr(binary + 4, 4), std::string("BIN\0", 4));
    bytes = glb.substr(binary + 8);
    EXPECT_EQ(Word(glb, binary), bytes.size());
    EXPECT_EQ(document["buffers"][0]["byteLength"], bytes.size());
  }
  static std::uint32_t Word(const std::string& text, std::size_t at) {
    std::uint32_t word;
    std::memcpy(&word, text.data() + at, sizeof word);
    return word;
  }
  std::vector<float> Values(int accessor) const {
    const json& view = document["bufferViews"][document["accessors"][accessor]["bufferView"].get<std::size_t>()];
    std::vector<float> values(view["byteLength"].get<std::size_t>() / sizeof(float));
    std::memcpy(values.data(), bytes.data() + view["byteOffset"].get<std::size_t>(), values.size() * sizeof(float));
    return values;
  }
  json document;
  std::string bytes;
};

TEST(GlbWriter, PlayedBackItPutsEveryJointWhereTheClipHasIt) {
  SyntheticGaitOptions options;
  options.steps = 4;
  const MotionClip clip = GenerateGait(options);
  const ReadGlb glb(WriteGlb(clip));
  EXPECT_EQ(glb.document["asset"]["version"], "2.0");
  const json& nodes = glb.document["nodes"];
  const json& animation = glb.document["animations"][0];
  ASSERT_EQ(nodes.size(), static_cast<std::size_t>(clip.joint_count()));

  for (const int frame : {0, clip.frame_count() / 2, clip.frame_count() - 1}) {
    std::vector<Eigen::Isometry3d> local(nodes.size(), Eigen::Isometry3d::Identity());
    std::vector<Eigen::Vector3d> translation(nodes.size());
    std::vector<Eigen::Quaterniond> rotation(nodes.size());
    for (std::size_t j = 0; j < nodes.size(); ++j) {
      const json& t = nodes[j]["translation"];
      const json& r = nodes[j]["rotation"];
      translation[j] = Eigen::Vector3d(t[0].get<double>(), t[1].get<double>(), t[2].get<double>());
      rotation[j] = Eigen::Quaterniond(r[3].get<double>(), r[0].get<double>(), r[1].get<double>(), r[2].get<double>());
    }
    for (const json& channel : animation["channels"]) {
      const json& sampler = animation["samplers"][channel["sampler"].get<std::size_t>()];
      const auto times = glb.Values(sampler["input"]), values = glb.Values(sampler["output"]);
      EXPECT_NEAR(times[static_cast<std::size_t>(frame)], frame / clip.frame_rate_hz(), 1e-5);
      const auto joint = channel["target"]["node"].get<std::size_t>();
      if (channel["target"]["path"] == "rotation") {
        const float* q = &values[static_cast<std::size_t>(frame) * 4];
        rotation[joint] = Eigen::Quaterniond(q[3], q[0], q[1], q[2]);
      } else {
        const float* p = &values[static_cast<std::size_t>(frame) * 3];
        translation[joint] = Eigen::Vector3d(p[0], p[1], p[2]);
      }
    }
    std::vector<Eigen::Isometry3d> world(nodes.size(), Eigen::Isometry3d::Identity());
    for (std::size_t j = 0; j < nodes.size(); ++j) {  // parents come first
      world[j] = world[j] * Eigen::Translation3d(translation[j]) * rotation[j];
      if (!nodes[j].contains("children")) continue;
      for (const json& child : nodes[j]["children"]) world[child.get<std::size_t>()] = world[j];
    }
    const WorldPose pose = ForwardKinematics(clip, frame);
    for (std::size_t j = 0; j < nodes.size(); ++j) {
      EXPECT_NEAR((world[j].translation() - pose.positions.col(static_cast<int>(j))).norm(), 0, 1e-5)
          << nodes[j]["name"] << " in frame " << frame;
    }
  }
}

TEST(GlbWriter, RotationsStayOnOneHemisphere) {
  SyntheticGaitOptions options;
  options.steps = 3;
  const ReadGlb glb(WriteGlb(GenerateGait(options)));
  for (const json& sampler : glb.document["animations"][0]["samplers"]) {
    const int output = sampler["output"];
    if (glb.document["accessors"][output]["type"] != "VEC4") continue;
    const auto values = glb.Values(output);
    for (std::size_t i = 4; i < values.size(); i += 4) {
      float dot = 0;
      for (std::size_t k = 0; k < 4; ++k) dot += values[i + k] * values[i + k - 4];
      EXPECT_GT(dot, 0.5f);
    }
  }
}

TEST(GlbWriter, RefusesAClipWithoutFrames) {
  const MotionClip clip = GenerateGait({});
  EXPECT_THROW(WriteGlb(clip.Slice(0, 0)), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
