#include "datasets/joint_roles.h"

#include <algorithm>
#include <cctype>

namespace morphograph {
namespace {

constexpr std::array<std::string_view, kJointRoleCount> kRoleNames = {
    "hips",       "spine",      "chest",      "neck",          "head",
    "left_hip",   "left_knee",  "left_ankle", "left_toe",      "right_hip",
    "right_knee", "right_ankle", "right_toe", "left_shoulder", "left_elbow",
    "left_wrist", "right_shoulder", "right_elbow", "right_wrist"};

// Known names in normalised form, best first. Sided roles hold the left names only, `L` standing for the side.
struct RoleNames {
  JointRole role;
  bool sided;
  std::vector<std::string_view> names;
};

const std::vector<RoleNames>& KnownNames() {
  static const std::vector<RoleNames> table = {
      {JointRole::kHips, false, {"hips", "hip", "pelvis", "root"}},
      {JointRole::kSpine, false, {"spine", "lowerback", "spine0", "chest", "torso", "abdomen"}},
      {JointRole::kChest, false, {"chest4", "chest3", "spine3", "spine2", "chest2", "spine1", "chest", "thorax"}},
      {JointRole::kNeck, false, {"neck", "neck1"}},
      {JointRole::kHead, false, {"head"}},
      {JointRole::kLeftHip, true, {"lupleg", "lhip", "upperlegl", "lthigh", "thighl", "lfemur", "lupperleg"}},
      {JointRole::kLeftKnee, true, {"lknee", "lowerlegl", "lleg", "llowleg", "lshin", "shinl", "calfl", "lcalf", "ltibia", "llowerleg"}},
      {JointRole::kLeftAnkle, true, {"lankle", "footl", "lfoot"}},
      {JointRole::kLeftToe, true, {"ltoebase", "ltoe", "toesl", "toel", "ltoes", "lball", "balll"}},
      {JointRole::kLeftShoulder, true, {"larm", "upperarml", "luparm", "lupperarm", "lhumerus", "lshoulder", "shoulderl"}},
      {JointRole::kLeftElbow, true, {"lforearm", "lowerarml", "lelbow", "llowarm", "llowerarm", "forearml", "lradius"}},
      {JointRole::kLeftWrist, true, {"lhand", "handl", "lwrist"}},
  };
  return table;
}

// Lower case letters and digits only; "left"/"right" shortened to "l"/"r"; namespace prefixes dropped.
std::string Normalised(std::string_view name) {
  const size_t colon = name.rfind(':');
  if (colon != std::string_view::npos) name.remove_prefix(colon + 1);
  std::string text;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c))) {
      text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  for (const auto& [word, letter] : {std::pair<std::string_view, char>{"left", 'l'}, {"right", 'r'}}) {
    const size_t at = text.find(word);
    if (at != std::string::npos) text.replace(at, word.size(), 1, letter);
  }
  return text;
}

std::string RightName(std::string_view left) {
  std::string name(left);
  if (name.front() == 'l' && name != "lowerlegl" && name != "lowerarml") {
    name.front() = 'r';
  } else {
    name.back() = 'r';
  }
  return name;
}

int FirstMatch(const std::vector<std::string>& names, const std::vector<std::string>& wanted) {
  for (const std::string& want : wanted) {
    for (size_t joint = 0; joint < names.size(); ++joint) {
      if (names[joint] == want) return static_cast<int>(joint);
    }
  }
  return -1;
}

}  // namespace

std::string_view RoleName(JointRole role) { return kRoleNames[static_cast<int>(role)]; }

std::optional<JointRole> RoleFromName(std::string_view name) {
  for (int i = 0; i < kJointRoleCount; ++i) {
    if (kRoleNames[i] == name) return static_cast<JointRole>(i);
  }
  return std::nullopt;
}

JointRole MirroredRole(JointRole role) {
  std::string name(RoleName(role));
  if (name.starts_with("left_")) {
    name.replace(0, 4, "right");
  } else if (name.starts_with("right_")) {
    name.replace(0, 5, "left");
  } else {
    return role;
  }
  return *RoleFromName(name);
}

std::optional<JointRole> RoleMap::RoleOf(int joint) const {
  for (int i = 0; i < kJointRoleCount; ++i) {
    if (joints_[i] == joint && joint >= 0) return static_cast<JointRole>(i);
  }
  return std::nullopt;
}

std::vector<std::string> RoleMap::Missing(const std::vector<JointRole>& required) const {
  std::vector<std::string> missing;
  for (const JointRole role : required) {
    if (!Has(role)) missing.emplace_back(RoleName(role));
  }
  return missing;
}

const std::vector<JointRole>& EvaluationRoles() {
  static const std::vector<JointRole> roles = {
      JointRole::kHips,         JointRole::kLeftHip,       JointRole::kRightHip,  JointRole::kLeftKnee,
      JointRole::kRightKnee,    JointRole::kLeftAnkle,     JointRole::kRightAnkle, JointRole::kLeftToe,
      JointRole::kRightToe,     JointRole::kHead,          JointRole::kLeftShoulder,
      JointRole::kRightShoulder, JointRole::kLeftWrist,    JointRole::kRightWrist};
  return roles;
}

const std::vector<JointRole>& LocomotionRoles() {
  static const std::vector<JointRole> roles = {
      JointRole::kHips,     JointRole::kLeftHip,  JointRole::kLeftKnee,  JointRole::kLeftAnkle, JointRole::kLeftToe,
      JointRole::kRightHip, JointRole::kRightKnee, JointRole::kRightAnkle, JointRole::kRightToe};
  return roles;
}

RoleMap DetectRoles(const std::vector<std::string>& joint_names) {
  std::vector<std::string> names;
  for (const std::string& name : joint_names) names.push_back(Normalised(name));
  RoleMap roles;
  for (const RoleNames& entry : KnownNames()) {
    std::vector<std::string> left(entry.names.begin(), entry.names.end());
    roles.Set(entry.role, FirstMatch(names, left));
    if (!entry.sided) continue;
    std::vector<std::string> right;
    for (const std::string& name : left) right.push_back(RightName(name));
    roles.Set(MirroredRole(entry.role), FirstMatch(names, right));
  }
  return roles;
}

}  // namespace morphograph
