#include "graph/internal/skeleton_json.h"

#include <stdexcept>
#include <string>

namespace morphograph::internal {
namespace {

using nlohmann::json;

// One letter a channel, in enum order: positions x y z, rotations X Y Z.
constexpr std::string_view kChannelLetters = "xyzXYZ";

json Vector(const Eigen::Vector3d& v) { return json::array({v.x(), v.y(), v.z()}); }

Eigen::Vector3d ToVector(const json& value) {
  return {value.at(0).get<double>(), value.at(1).get<double>(), value.at(2).get<double>()};
}

std::vector<Channel> ToChannels(const std::string& letters) {
  std::vector<Channel> channels;
  for (const char letter : letters) {
    const size_t at = kChannelLetters.find(letter);
    if (at == std::string_view::npos) throw std::invalid_argument("unknown channel in the skeleton");
    channels.push_back(static_cast<Channel>(at));
  }
  return channels;
}

}  // namespace

json SkeletonToJson(const Skeleton& skeleton) {
  json joints = json::array();
  for (const Joint& joint : skeleton.joints()) {
    std::string channels;
    for (const Channel channel : joint.channels) channels += kChannelLetters[static_cast<size_t>(channel)];
    json entry = {{"name", joint.name}, {"parent", joint.parent}, {"offset_m", Vector(joint.offset_m)}, {"channels", channels}};
    if (joint.end_site_m) entry["end_site_m"] = Vector(*joint.end_site_m);
    joints.push_back(std::move(entry));
  }
  json roles = json::object();
  for (int i = 0; i < kJointRoleCount; ++i) {
    const auto role = static_cast<JointRole>(i);
    if (skeleton.roles().Has(role)) roles[std::string(RoleName(role))] = skeleton.roles()[role];
  }
  return {{"joints", joints},
          {"roles", roles},
          {"metres_per_unit", skeleton.metres_per_unit()},
          {"up_axis", skeleton.up_axis() == UpAxis::kY ? "y" : "z"}};
}

std::shared_ptr<const Skeleton> SkeletonFromJson(const json& value) {
  std::vector<Joint> joints;
  for (const json& entry : value.at("joints")) {
    Joint joint;
    joint.name = entry.at("name").get<std::string>();
    joint.parent = entry.at("parent").get<int>();
    joint.offset_m = ToVector(entry.at("offset_m"));
    joint.channels = ToChannels(entry.at("channels").get<std::string>());
    if (entry.contains("end_site_m")) joint.end_site_m = ToVector(entry.at("end_site_m"));
    joints.push_back(std::move(joint));
  }
  RoleMap roles;
  for (const auto& [name, joint] : value.at("roles").items()) {
    const auto role = RoleFromName(name);
    const int index = joint.get<int>();
    if (!role || index < 0 || index >= static_cast<int>(joints.size())) throw std::invalid_argument("unknown role in the skeleton");
    roles.Set(*role, index);
  }
  const UpAxis up = value.at("up_axis").get<std::string>() == "y" ? UpAxis::kY : UpAxis::kZ;
  return std::make_shared<Skeleton>(std::move(joints), roles, value.at("metres_per_unit").get<double>(), up);
}

}  // namespace morphograph::internal
