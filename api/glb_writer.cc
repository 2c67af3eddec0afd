#include "api/glb_writer.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace morphograph {
namespace {

using nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "glTF is little-endian");

constexpr int kFloat = 5126;  // component type
constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

void AppendWord(std::uint32_t word, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&word), sizeof word);
}

// Collects float arrays and their accessors.
class BufferBuilder {
 public:
  /// @param width  floats an element. @return the accessor's index.
  int Add(const std::vector<float>& values, int width, const char* type, bool with_bounds) {
    ordered_json accessor = {{"bufferView", views.size()},
                             {"componentType", kFloat},
                             {"count", values.size() / static_cast<std::size_t>(width)},
                             {"type", type}};
    if (with_bounds) {  // demanded of a sampler's times
      accessor["min"] = {*std::min_element(values.begin(), values.end())};
      accessor["max"] = {*std::max_element(values.begin(), values.end())};
    }
    views.push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", values.size() * sizeof(float)}});
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
    accessors.push_back(std::move(accessor));
    return static_cast<int>(accessors.size()) - 1;
  }

  std::string bytes;
  ordered_json views = ordered_json::array();
  ordered_json accessors = ordered_json::array();
};

// Order x, y, z, w as glTF has it; kept on one hemisphere, since viewers interpolate component by component.
std::vector<float> RotationValues(const MotionClip& clip, int joint, bool* moves) {
  std::vector<float> values;
  values.reserve(static_cast<std::size_t>(clip.frame_count()) * 4);
  Eigen::Quaterniond last = clip.rotation(0, joint);
  *moves = false;
  for (int frame = 0; frame < clip.frame_count(); ++frame) {
    Eigen::Quaterniond rotation = clip.rotation(frame, joint).normalized();
    if (rotation.dot(last) < 0) rotation.coeffs() = -rotation.coeffs();
    if (!rotation.isApprox(clip.rotation(0, joint), 1e-9)) *moves = true;
    for (const double part : {rotation.x(), rotation.y(), rotation.z(), rotation.w()})
      values.push_back(static_cast<float>(part));
    last = rotation;
  }
  return values;
}

ordered_json Vector(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

std::string WriteGlb(const MotionClip& clip) {
  if (clip.frame_count() < 1) throw std::invalid_argument("WriteGlb: the clip has no frame");
  const Skeleton& skeleton = clip.skeleton();
  BufferBuilder buffer;
  std::vector<float> times;
  for (int frame = 0; frame < clip.frame_count(); ++frame)
    times.push_back(static_cast<float>(frame / clip.frame_rate_hz()));
  const int time_accessor = buffer.Add(times, 1, "SCALAR", /*with_bounds=*/true);

  ordered_json nodes = ordered_json::array(), samplers = ordered_json::array(), channels = ordered_json::array();
  const auto animate = [&](int joint, const char* path, int values) {
    channels.push_back({{"sampler", samplers.size()}, {"target", {{"node", joint}, {"path", path}}}});
    samplers.push_back({{"input", time_accessor}, {"interpolation", "LINEAR"}, {"output", values}});
  };
  for (int joint = 0; joint < skeleton.joint_count(); ++joint) {
    const bool is_root = joint == skeleton.moving_root();
    const Eigen::Vector3d translation =
        is_root ? Eigen::Vector3d(clip.root_positions().col(0)) : skeleton.joint(joint).offset_m;
    const Eigen::Quaterniond rotation = clip.rotation(0, joint).normalized();
    ordered_json node = {{"name", skeleton.joint(joint).name},
                         {"translation", Vector(translation)},
                         {"rotation",
                          {static_cast<float>(rotation.x()), static_cast<float>(rotation.y()),
                           static_cast<float>(rotation.z()), static_cast<float>(rotation.w())}}};
    for (int child = joint + 1; child < skeleton.joint_count(); ++child)
      if (skeleton.parent(child) == joint) node["children"].push_back(child);
    nodes.push_back(std::move(node));

    bool moves = false;
    const std::vector<float> rotations = RotationValues(clip, joint, &moves);
    if (moves) animate(joint, "rotation", buffer.Add(rotations, 4, "VEC4", false));
    if (is_root) {
      std::vector<float> positions;
      for (int frame = 0; frame < clip.frame_count(); ++frame)
        for (int axis = 0; axis < 3; ++axis) positions.push_back(static_cast<float>(clip.root_positions()(axis, frame)));
      animate(joint, "translation", buffer.Add(positions, 3, "VEC3", false));
    }
  }

  const ordered_json document = {
      {"asset", {{"version", "2.0"}, {"generator", "Morphograph " MORPHOGRAPH_VERSION}}},
      {"scene", 0},
      {"scenes", ordered_json::array({{{"name", clip.name.empty() ? "clip" : clip.name}, {"nodes", ordered_json::array({0})}}})},
      {"nodes", nodes},
      {"animations", ordered_json::array({{{"name", clip.name.empty() ? "clip" : clip.name},
                                           {"channels", channels},
                                           {"samplers", samplers}}})},
      {"accessors", buffer.accessors},
      {"bufferViews", buffer.views},
      {"buffers", ordered_json::array({{{"byteLength", buffer.bytes.size()}}})}};
  std::string json = document.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  json.append((4 - json.size() % 4) % 4, ' ');  // chunks are whole words; floats already are

  std::string glb = "glTF";
  AppendWord(2, &glb);
  AppendWord(static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + buffer.bytes.size()), &glb);
  AppendWord(static_cast<std::uint32_t>(json.size()), &glb);
  AppendWord(kJsonChunk, &glb);
  glb += json;
  AppendWord(static_cast<std::uint32_t>(buffer.bytes.size()), &glb);
  AppendWord(kBinaryChunk, &glb);
  glb += buffer.bytes;
  return glb;
}

}  // namespace morphograph
