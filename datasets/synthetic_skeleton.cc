#include "datasets/synthetic_skeleton.h"

#include <stdexcept>

namespace morphograph {

SyntheticFoot::SyntheticFoot(double stature_m)
    : ankle_height_m(0.045 * stature_m),
      ball_height_m(0.020 * stature_m),
      ball_ahead_m(0.078 * stature_m),
      heel_behind_m(0.028 * stature_m),
      toe_length_m(0.040 * stature_m),
      tip_height_m(0.008 * stature_m) {}

std::shared_ptr<const Skeleton> SyntheticSkeleton(double stature_m) {
  if (!(stature_m > 0.5 && stature_m < 3)) throw std::invalid_argument("SyntheticSkeleton: stature must be 0.5 to 3 m");
  const SyntheticFoot foot(stature_m);
  std::vector<Joint> joints;
  // Offsets in fractions of stature; `x` points to the left of the body.
  const auto add = [&](const char* name, int parent, double x, double y, double z) {
    Joint joint;
    joint.name = name;
    joint.parent = parent;
    joint.offset_m = stature_m * Eigen::Vector3d(x, y, z);
    joint.channels = {Channel::kZRotation, Channel::kYRotation, Channel::kXRotation};
    if (parent < 0) {
      joint.channels.insert(joint.channels.begin(), {Channel::kXPosition, Channel::kYPosition, Channel::kZPosition});
    }
    joints.push_back(joint);
    return static_cast<int>(joints.size()) - 1;
  };
  const auto end = [&](double x_m, double y_m, double z_m) { joints.back().end_site_m = Eigen::Vector3d(x_m, y_m, z_m); };

  const int hips = add("Hips", -1, 0, 0, 0);
  for (const auto& [side, sign] : {std::pair<std::string, double>{"Left", 1.0}, {"Right", -1.0}}) {
    const int thigh = add((side + "UpLeg").c_str(), hips, sign * 0.050, -0.020, 0);
    const int shin = add((side + "Leg").c_str(), thigh, 0, -0.245, 0);
    const int ankle = add((side + "Foot").c_str(), shin, 0, -0.243, 0);
    add((side + "ToeBase").c_str(), ankle, 0, (foot.ball_height_m - foot.ankle_height_m) / stature_m,
        foot.ball_ahead_m / stature_m);
    end(0, foot.tip_height_m - foot.ball_height_m, foot.toe_length_m);
  }
  const int spine = add("Spine", hips, 0, 0.060, -0.010);
  const int chest = add("Spine1", spine, 0, 0.090, 0);
  const int neck = add("Neck", chest, 0, 0.155, 0);
  add("Head", neck, 0, 0.055, 0.010);
  end(0, 0.110 * stature_m, 0);
  for (const auto& [side, sign] : {std::pair<std::string, double>{"Left", 1.0}, {"Right", -1.0}}) {
    const int clavicle = add((side + "Shoulder").c_str(), chest, sign * 0.020, 0.130, 0);
    const int arm = add((side + "Arm").c_str(), clavicle, sign * 0.090, 0, 0);
    const int forearm = add((side + "ForeArm").c_str(), arm, sign * 0.175, 0, 0);
    add((side + "Hand").c_str(), forearm, sign * 0.146, 0, 0);
    end(sign * 0.100 * stature_m, 0, 0);
  }

  std::vector<std::string> names;
  for (const Joint& joint : joints) names.push_back(joint.name);
  const RoleMap roles = DetectRoles(names);
  return std::make_shared<Skeleton>(std::move(joints), roles, /*metres_per_unit=*/0.01, UpAxis::kY);
}

}  // namespace morphograph
