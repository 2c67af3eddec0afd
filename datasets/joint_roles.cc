#include "datasets/joint_roles.h"

#include <algorithm>

namespace morphograph {
namespace {

constexpr std::array<std::string_view, kJointRoleCount> kRoleNames = {
    "hips",       "spine",      "chest",      "neck",          "head",
    "left_hip",   "left_knee",  "left_ankle", "left_toe",      "right_hip",
    "right_knee", "right_ankle", "right_toe", "left_shoulder", "left_elbow",
    "left_wrist", "right_shoulder", "right_elbow", "right_wrist"};

// Known names in normalised form, best first; `*` stands for the side, "l" or "r". Sided roles are listed for the left.
// Order of the rows matters: a joint gets one role, so a lone "Chest" is the chest and not the spine. Rigs met here: CMU (ASF
// and its BVH conversions), Mixamo, MotionBuilder, LAFAN1, 3ds Max biped, Unreal, Blender, Xsens, Rokoko, SMPL, Poser.
struct RoleNames {
  JointRole role;
  std::vector<std::string_view> names;
};

const std::vector<RoleNames>& KnownNames() {
  static const std::vector<RoleNames> table = {
      {JointRole::kHips, {"hips", "pelvis", "hip", "root"}},
      {JointRole::kChest,
       {"chest4", "chest3", "spine3", "spine03", "t8", "spine2", "spine02", "chest2", "upperchest", "spine1", "spine01",
        "chest", "thorax", "upperback"}},
      {JointRole::kSpine,
       {"spine", "lowerback", "spine0", "spine1", "spine01", "l5", "l3", "chest", "torso", "abdomen"}},
      {JointRole::kNeck, {"neck", "neck1", "neck01", "lowerneck"}},
      {JointRole::kHead, {"head"}},
      {JointRole::kLeftHip, {"*upleg", "upleg*", "*hip", "hip*", "*thigh", "thigh*", "*femur", "*upperleg", "upperleg*"}},
      {JointRole::kLeftKnee,
       {"*knee", "knee*", "*lowerleg", "lowerleg*", "*lowleg", "lowleg*", "*shin", "shin*", "*calf", "calf*", "*tibia", "*leg",
        "leg*"}},
      {JointRole::kLeftAnkle, {"*ankle", "ankle*", "*foot", "foot*"}},
      {JointRole::kLeftToe,
       {"*toebase", "toebase*", "*toe", "toe*", "*toes", "toes*", "*toe0", "*ball", "ball*", "*forefoot", "*foot"}},
      {JointRole::kLeftShoulder,
       {"*arm", "*upperarm", "upperarm*", "*uparm", "uparm*", "arm*", "*humerus", "*shoulder", "shoulder*", "*shldr"}},
      {JointRole::kLeftElbow,
       {"*forearm", "forearm*", "*elbow", "elbow*", "*lowerarm", "lowerarm*", "*lowarm", "lowarm*", "*radius"}},
      {JointRole::kLeftWrist, {"*wrist", "wrist*", "*hand", "hand*"}},
  };
  return table;
}

// What rigs put before every name.
constexpr std::string_view kRigPrefixes[] = {"mixamorig", "valvebiped", "ccbase", "bip"};

// Lower case letters and digits only; "left"/"right" shortened to "l"/"r"; namespaces and rig prefixes dropped.
std::string Normalised(std::string_view name) {
  const size_t mark = name.find_last_of(":|");
  if (mark != std::string_view::npos) name.remove_prefix(mark + 1);
  std::string text;
  for (const char c : name) {
    const char lower = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    if ((lower >= 'a' && lower <= 'z') || (lower >= '0' && lower <= '9')) text += lower;
  }
  for (const std::string_view prefix : kRigPrefixes) {
    if (!text.starts_with(prefix)) continue;
    size_t end = prefix.size();
    while (end < text.size() && text[end] >= '0' && text[end] <= '9') ++end;  // "mixamorig1", "bip001"
    if (end < text.size()) text.erase(0, end);
  }
  for (const auto& [word, letter] : {std::pair<std::string_view, char>{"left", 'l'}, {"right", 'r'}}) {
    const size_t at = text.find(word);
    if (at != std::string::npos) text.replace(at, word.size(), 1, letter);
  }
  return text;
}

std::string OnSide(std::string_view name, char side) {
  std::string text(name);
  std::replace(text.begin(), text.end(), '*', side);
  return text;
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
  std::vector<char> taken(names.size(), 0);
  const auto assign = [&](JointRole role, const std::vector<std::string_view>& wanted, char side) {
    for (const std::string_view want : wanted) {
      const std::string name = OnSide(want, side);
      for (size_t joint = 0; joint < names.size(); ++joint) {
        if (taken[joint] || names[joint] != name) continue;
        roles.Set(role, static_cast<int>(joint));
        taken[joint] = 1;
        return;
      }
    }
  };
  for (const RoleNames& entry : KnownNames()) {
    assign(entry.role, entry.names, 'l');
    if (MirroredRole(entry.role) != entry.role) assign(MirroredRole(entry.role), entry.names, 'r');
  }
  return roles;
}

}  // namespace morphograph
