#include "synthesis/joint_spread.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "datasets/forward_kinematics.h"

namespace morphograph {
namespace {

std::vector<int> EvaluationJoints(const Skeleton& skeleton) {
  std::vector<int> joints;
  for (const JointRole role : EvaluationRoles()) {
    if (skeleton.roles().Has(role)) joints.push_back(skeleton.roles()[role]);
  }
  return joints;
}

// (3 x joints) of one frame.
Eigen::Matrix3Xd JointsAt(const MotionClip& clip, int frame, const std::vector<int>& joints, SampleFrame in) {
  const WorldPose pose = ForwardKinematics(clip, frame);
  Eigen::Matrix3Xd points(3, joints.size());
  for (std::size_t j = 0; j < joints.size(); ++j) points.col(static_cast<Eigen::Index>(j)) = pose.positions.col(joints[j]);
  if (in == SampleFrame::kWorld) return points;
  Eigen::Vector3d below_root = clip.root_positions().col(frame);
  below_root.y() = 0;
  const Eigen::Matrix3d body_from_world = Eigen::AngleAxisd(-HeadingRad(clip, frame), Eigen::Vector3d::UnitY()).toRotationMatrix();
  return body_from_world * (points.colwise() - below_root);
}

}  // namespace

JointSamples SampleJoints(const MotionClip& clip, int from, int to, int phases, SampleFrame frame) {
  if (from < 0 || to < from || to >= clip.frame_count()) throw std::invalid_argument("SampleJoints: frames are not inside the clip");
  if (phases < 2) throw std::invalid_argument("SampleJoints: needs two phases");
  const std::vector<int> joints = EvaluationJoints(clip.skeleton());
  const auto count = static_cast<Eigen::Index>(joints.size());
  JointSamples samples(3, count * phases);
  for (int p = 0; p < phases; ++p) {
    const double at = from + (to - from) * (p / static_cast<double>(phases - 1));
    const int before = static_cast<int>(std::floor(at)), after = std::min(before + 1, to);
    const Eigen::Matrix3Xd first = JointsAt(clip, before, joints, frame);
    const Eigen::Matrix3Xd second = after == before ? first : JointsAt(clip, after, joints, frame);
    samples.middleCols(p * count, count) = (first + (at - before) * (second - first)).cast<float>();
  }
  return samples;
}

double MeanPairwiseJointDistance(const std::vector<JointSamples>& samples) {
  double sum = 0;
  double pairs = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (samples[i].cols() != samples[k].cols()) throw std::invalid_argument("MeanPairwiseJointDistance: samples differ in size");
      sum += static_cast<double>((samples[i] - samples[k]).colwise().norm().mean());
      ++pairs;
    }
  }
  return pairs > 0 ? sum / pairs : 0;
}

}  // namespace morphograph
