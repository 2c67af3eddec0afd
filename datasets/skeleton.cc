#include "datasets/skeleton.h"

#include <cmath>
#include <stdexcept>
#include <unordered_set>

namespace morphograph {
namespace {

void CheckJoints(const std::vector<Joint>& joints) {
  if (joints.empty()) throw std::invalid_argument("Skeleton: no joints");
  std::unordered_set<std::string> names;
  for (size_t i = 0; i < joints.size(); ++i) {
    const Joint& joint = joints[i];
    if (joint.name.empty()) throw std::invalid_argument("Skeleton: joint " + std::to_string(i) + " has no name");
    if (!names.insert(joint.name).second) {
      throw std::invalid_argument("Skeleton: two joints are called '" + joint.name + "'");
    }
    const bool is_first = i == 0;
    if (is_first != (joint.parent < 0) || joint.parent >= static_cast<int>(i)) {
      throw std::invalid_argument("Skeleton: parent of joint '" + joint.name + "' must precede it");
    }
    if (!joint.offset_m.allFinite() || (joint.end_site_m && !joint.end_site_m->allFinite())) {
      throw std::invalid_argument("Skeleton: offset of joint '" + joint.name + "' is not finite");
    }
  }
}

}  // namespace

Skeleton::Skeleton(std::vector<Joint> joints, RoleMap roles, double metres_per_unit, UpAxis up_axis)
    : joints_(std::move(joints)), roles_(roles), metres_per_unit_(metres_per_unit), up_axis_(up_axis) {
  CheckJoints(joints_);
  if (!(metres_per_unit > 0 && std::isfinite(metres_per_unit))) {
    throw std::invalid_argument("Skeleton: metres per unit must be positive");
  }
  for (int r = 0; r < kJointRoleCount; ++r) {
    const JointRole role = static_cast<JointRole>(r);
    if (roles_[role] < joint_count()) continue;
    throw std::invalid_argument("Skeleton: role '" + std::string(RoleName(role)) + "' is given to joint " +
                                std::to_string(roles_[role]) + " of " + std::to_string(joint_count()));
  }
  if (roles_.Has(JointRole::kHips)) moving_root_ = roles_[JointRole::kHips];
  is_body_.assign(joints_.size(), 0);
  for (int i = 0; i < joint_count(); ++i) {
    is_body_[i] = i == moving_root_ || (joints_[i].parent >= 0 && is_body_[joints_[i].parent]);
  }
  double length = 0;
  int legs = 0;
  for (const auto& [hip, ankle] : {std::pair{JointRole::kLeftHip, JointRole::kLeftAnkle},
                                   std::pair{JointRole::kRightHip, JointRole::kRightAnkle}}) {
    if (!roles_.Has(hip) || !roles_.Has(ankle)) continue;
    for (int i = roles_[ankle]; i > roles_[hip]; i = joints_[i].parent) length += joints_[i].offset_m.norm();
    ++legs;
  }
  if (legs > 0) leg_length_m_ = length / legs;
}

int Skeleton::Find(std::string_view name) const {
  for (int i = 0; i < joint_count(); ++i) {
    if (joints_[i].name == name) return i;
  }
  return -1;
}

int Skeleton::FindRoleOrName(std::string_view name) const {
  if (const auto role = RoleFromName(name); role && roles_.Has(*role)) return roles_[*role];
  return Find(name);
}

}  // namespace morphograph
