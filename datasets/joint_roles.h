#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace morphograph {

/// What a joint is in the body, whatever its skeleton calls it.
enum class JointRole {
  kHips,
  kSpine,
  kChest,
  kNeck,
  kHead,
  kLeftHip,
  kLeftKnee,
  kLeftAnkle,
  kLeftToe,  // ball of the foot
  kRightHip,
  kRightKnee,
  kRightAnkle,
  kRightToe,
  kLeftShoulder,  // where the upper arm starts, not the clavicle
  kLeftElbow,
  kLeftWrist,
  kRightShoulder,
  kRightElbow,
  kRightWrist,
};
inline constexpr int kJointRoleCount = 19;

/// Name of a role as requests and manifests write it, e.g. "left_wrist".
std::string_view RoleName(JointRole role);
std::optional<JointRole> RoleFromName(std::string_view name);

/// The same role on the other side of the body (hips stay hips).
JointRole MirroredRole(JointRole role);

/// Joint index of every role; -1 where the skeleton has none.
class RoleMap {
 public:
  RoleMap() { joints_.fill(-1); }
  int operator[](JointRole role) const { return joints_[static_cast<int>(role)]; }
  void Set(JointRole role, int joint) { joints_[static_cast<int>(role)] = joint; }
  bool Has(JointRole role) const { return (*this)[role] >= 0; }
  /// Role of a joint, if it has one.
  std::optional<JointRole> RoleOf(int joint) const;
  /// Roles of `required` that are missing, by name, for error messages.
  std::vector<std::string> Missing(const std::vector<JointRole>& required) const;

 private:
  std::array<int, kJointRoleCount> joints_;
};

/// The 14 joints that the evaluation measures (METHODS section 6): hips, both
/// hip joints, knees, ankles, balls of the feet, head, shoulders, wrists.
const std::vector<JointRole>& EvaluationRoles();

/// The roles that a walking model needs: hips, hip joints, knees, ankles, toes.
const std::vector<JointRole>& LocomotionRoles();

/// Finds roles by a table of known names (case, spaces, `_`, `-`, and prefixes such as
/// "mixamorig:" or "Bip01 " do not matter). Where two joints match a role, the first in hierarchy order
/// wins among the names that rank highest in the table; no joint gets two roles.
RoleMap DetectRoles(const std::vector<std::string>& joint_names);

}  // namespace morphograph
