#include "tests/benchmarks/segment_anatomy.h"

#include <Eigen/SVD>

#include "datasets/contact_detector.h"
#include "datasets/forward_kinematics.h"

namespace morphograph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Directions of a segment of the body in the world, in columns: left, up, forwards. Pelvis: along the hip joints, and up. Shank: from ankle to knee, and forwards as the foot points.
Matrix3d PelvisAxes(const Vector3d& left_hip, const Vector3d& right_hip) {
  const Vector3d left = (left_hip - right_hip).normalized();
  const Vector3d up = (Vector3d::UnitY() - left.y() * left).normalized();
  Matrix3d axes;
  axes << left, up, left.cross(up);
  return axes;
}
Matrix3d ShankAxes(const Vector3d& knee, const Vector3d& ankle, const Vector3d& foot_forwards) {
  const Vector3d up = (knee - ankle).normalized(), left = up.cross(foot_forwards).normalized();
  Matrix3d axes;
  axes << left, up, left.cross(up);
  return axes;
}
// Of a foot that stands flat: up is up.
Matrix3d FlatFootAxes(const Vector3d& foot_forwards) {
  const Vector3d forwards = Vector3d(foot_forwards.x(), 0, foot_forwards.z()).normalized();
  Matrix3d axes;
  axes << Vector3d::UnitY().cross(forwards), Vector3d::UnitY(), forwards;
  return axes;
}

// Sums over frames.
class AnatomySums {
 public:
  void Add(const Matrix3d& world_from_segment, const Vector3d& origin, const Matrix3d& world_from_body, const Vector3d& world_joint) {
    sums_.segment_from_body += world_from_segment.transpose() * world_from_body;
    sums_.joint += world_from_segment.transpose() * (world_joint - origin);
    ++samples_;
  }
  SegmentAnatomy Mean() const {
    const Eigen::JacobiSVD<Matrix3d> svd(sums_.segment_from_body, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return {svd.matrixU() * svd.matrixV().transpose(), sums_.joint / samples_};
  }

 private:
  SegmentAnatomy sums_;
  int samples_ = 0;
};

}  // namespace

SegmentAnatomy AnatomyOf(const BodySensor& sensor, const NeuraRecording& neura, const SegmentMotion& segment) {
  const Readings& markers = neura.markers;
  const std::string joint = sensor.joint, side = joint.starts_with("left") ? "L" : "R";
  const auto at = [&](const std::string& name, int i) { return Vector3d(markers.values.col(i).segment<3>(RowOf(markers, name))); };
  AnatomySums anatomy;
  // Feet lie flat while the person stands, before the walk.
  const bool foot = joint.ends_with("ankle");
  const int first = foot ? 50 : neura.walk_first, last = foot ? neura.walk_first - 50 : neura.walk_last;
  for (int i = first; i <= last; ++i) {
    const Matrix3d& world_from_segment = segment.rotations[static_cast<std::size_t>(i)];
    const Vector3d origin = segment.positions.col(i);
    if (joint == "hips") {
      anatomy.Add(world_from_segment, origin, PelvisAxes(at("LHJC", i), at("RHJC", i)), (at("LHJC", i) + at("RHJC", i)) / 2);
      continue;
    }
    const Vector3d forwards = at(side + "TOE", i) - at(side + "HEE", i);
    if (foot) anatomy.Add(world_from_segment, origin, FlatFootAxes(forwards), at(side + "AJC", i));
    else anatomy.Add(world_from_segment, origin, ShankAxes(at(side + "KJC", i), at(side + "AJC", i), forwards), at(side + "KJC", i));
  }
  return anatomy.Mean();
}

SegmentAnatomy AnatomyOf(const std::string& joint_name, const std::vector<MotionClip>& clips) {
  constexpr std::size_t kEvery = 8;  // clips enough for a mean
  const Skeleton& skeleton = clips.front().skeleton();
  const RoleMap& roles = skeleton.roles();
  const int joint = skeleton.FindRoleOrName(joint_name);
  const bool left = joint_name.starts_with("left"), foot = joint_name.ends_with("ankle");
  const int knee = roles[left ? JointRole::kLeftKnee : JointRole::kRightKnee], ankle = roles[left ? JointRole::kLeftAnkle : JointRole::kRightAnkle];
  const int toe = roles[left ? JointRole::kLeftToe : JointRole::kRightToe];
  AnatomySums anatomy;
  for (std::size_t c = 0; c < clips.size(); c += kEvery) {
    const MotionClip& clip = clips[c];
    const ContactTrack contacts = DetectContacts(clip);
    for (int f = 0; f < clip.frame_count(); ++f) {
      const WorldPose pose = ForwardKinematics(clip, f);
      const Matrix3d world_from_joint = pose.rotations[static_cast<std::size_t>(joint)].toRotationMatrix();
      const Vector3d origin = pose.positions.col(joint);
      if (joint_name == "hips") {
        const Vector3d left_hip = pose.positions.col(roles[JointRole::kLeftHip]), right_hip = pose.positions.col(roles[JointRole::kRightHip]);
        anatomy.Add(world_from_joint, origin, PelvisAxes(left_hip, right_hip), (left_hip + right_hip) / 2);
        continue;
      }
      const Vector3d forwards = pose.positions.col(toe) - pose.positions.col(ankle);
      if (!foot) anatomy.Add(world_from_joint, origin, ShankAxes(pose.positions.col(knee), pose.positions.col(ankle), forwards), origin);
      else if (contacts.planted(left ? 0 : 2, f) && contacts.planted(left ? 1 : 3, f)) anatomy.Add(world_from_joint, origin, FlatFootAxes(forwards), origin);
    }
  }
  return anatomy.Mean();
}

// Where the sensor sits on the model's body, by where it sits on the person's.
Placement PlacementOf(const BodySensor& sensor, const SensorAlignment& alignment, const SegmentAnatomy& person, const SegmentAnatomy& model, double scale) {
  Placement placement{sensor.name, sensor.joint};
  const Matrix3d model_from_person = model.segment_from_body * person.segment_from_body.transpose();
  placement.joint_from_sensor = Eigen::Quaterniond(Matrix3d(model_from_person * alignment.segment_from_sensor.toRotationMatrix()));
  placement.offset_m = model.joint + scale * (model_from_person * (alignment.offset_m - person.joint));
  return placement;
}

}  // namespace morphograph
