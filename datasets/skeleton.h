#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/joint_roles.h"

namespace morphograph {

enum class Channel { kXPosition, kYPosition, kZPosition, kXRotation, kYRotation, kZRotation };
enum class UpAxis { kY, kZ };

struct Joint {
  std::string name;
  int parent = -1;                                  // -1: the hierarchy's first joint
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();  // from the parent, rest pose
  std::optional<Eigen::Vector3d> end_site_m;        // End Site of a leaf, where the file has one
  std::vector<Channel> channels;                    // as the source file orders them
};

/// Immutable, checked joint hierarchy in metres, Y up.
///
/// Guarantees: at least one joint, exactly one without parent and that one first,
/// parents precede children, names not empty and unique, offsets finite. Nothing
/// downstream checks this again.
///
/// The *moving root* is the joint that carries the body through the world: the hips where the
/// skeleton has them, else joint 0. Joints above it (bnr's `joint_Root`) stand still at the origin.
class Skeleton {
 public:
  /// @param metres_per_unit  unit of the source file; written clips use it again.
  /// @param up_axis  up axis of the source file; offsets here are already Y up.
  /// @throws std::invalid_argument naming the joint when a guarantee does not hold.
  Skeleton(std::vector<Joint> joints, RoleMap roles, double metres_per_unit, UpAxis up_axis);

  int joint_count() const { return static_cast<int>(joints_.size()); }
  const Joint& joint(int index) const { return joints_[index]; }
  const std::vector<Joint>& joints() const { return joints_; }
  int parent(int index) const { return joints_[index].parent; }
  const RoleMap& roles() const { return roles_; }
  int moving_root() const { return moving_root_; }
  double metres_per_unit() const { return metres_per_unit_; }
  UpAxis up_axis() const { return up_axis_; }

  /// Index of the joint of that name or -1.
  int Find(std::string_view name) const;
  /// A role's name ("left_wrist") or a joint's own name; -1 when neither.
  int FindRoleOrName(std::string_view name) const;
  /// True for the moving root and everything below it.
  bool IsBody(int index) const { return is_body_[index]; }
  /// Hip joint to ankle along the bones, mean of both legs; 0 without leg roles.
  double leg_length_m() const { return leg_length_m_; }

 private:
  std::vector<Joint> joints_;
  RoleMap roles_;
  double metres_per_unit_;
  UpAxis up_axis_;
  int moving_root_ = 0;
  std::vector<char> is_body_;
  double leg_length_m_ = 0;
};

}  // namespace morphograph
