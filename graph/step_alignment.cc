#include "graph/step_alignment.h"

#include <algorithm>
#include <stdexcept>

#include "datasets/forward_kinematics.h"
#include "primitives/frame_distance.h"
#include "primitives/step_vector.h"

namespace morphograph {
namespace {

// Instants of a step that are compared when it is aligned: sub-frame at 30 frames a second.
constexpr int kAlignmentFrames = 25;
// Draws the fitted warp towards uniform time, so that the stairs of a whole-frame path stay out.
constexpr double kWarpRegularisation = 1e-3;
// Candidates for the reference segment, spread evenly over the class.
constexpr int kReferenceCandidates = 40;

using PoseClouds = std::vector<Eigen::Matrix3Xd>;

// Joint positions at kAlignmentFrames instants of a step, uniform in time.
PoseClouds AlignmentPoses(const StepSampler& sampler, const PoseLayout& layout, const MeanRotations& means) {
  Eigen::VectorXd frames(kAlignmentFrames);
  for (int i = 0; i < kAlignmentFrames; ++i) {
    frames[i] = sampler.span().FrameAt(static_cast<double>(i) / (kAlignmentFrames - 1));
  }
  const Eigen::MatrixXd poses = sampler.PosesAt(frames);
  std::vector<Eigen::Quaterniond> rotations(means);
  PoseClouds clouds;
  WorldPose pose;
  for (int i = 0; i < kAlignmentFrames; ++i) {
    for (size_t n = 0; n < layout.active_joints().size(); ++n) {
      const int joint = layout.active_joints()[n];
      rotations[joint] = layout.RotationOf(n, means[joint], poses.block<3, 1>(3 + 3 * static_cast<Eigen::Index>(n), i));
    }
    ForwardKinematics(layout.skeleton(), rotations.data(), poses.block<3, 1>(0, i), &pose);
    clouds.push_back(pose.positions);
  }
  return clouds;
}

// Index of the segment with the least mean distance to the others, time taken as uniform. First of equals.
int PickReference(const std::vector<PoseClouds>& clouds, const std::vector<int>& eligible, const Eigen::VectorXd& weights) {
  const int count = std::min(kReferenceCandidates, static_cast<int>(eligible.size()));
  std::vector<int> candidates;
  for (int i = 0; i < count; ++i) candidates.push_back(eligible[static_cast<size_t>(i) * eligible.size() / count]);
  Eigen::MatrixXd distances = Eigen::MatrixXd::Zero(count, count);
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count; ++b) {
      for (int i = 0; i < kAlignmentFrames; i += 4) {
        distances(a, b) += FrameDistance(clouds[candidates[a]][i], clouds[candidates[b]][i], weights);
      }
      distances(b, a) = distances(a, b);
    }
  }
  return candidates[ChooseReference(distances)];
}

TimeWarp Align(const PoseClouds& reference, const PoseClouds& test, const Eigen::VectorXd& weights) {
  const Eigen::MatrixXd cost = FrameDistanceMatrix(reference, test, weights);
  return TimeWarp::Fit(DynamicTimeWarp(cost), kAlignmentFrames, kAlignmentFrames, kWarpKnots, kWarpRegularisation);
}

}  // namespace

AlignedClass AlignClass(const std::vector<PreparedClip>& clips, const std::vector<TrainingStep>& steps, const StepClass& members,
                        const PoseLayout& layout, const MeanRotations& means) {
  const int count = static_cast<int>(members.members.size());
  const Eigen::VectorXd distance_weights = FrameDistanceWeights(layout.skeleton());
  AlignedClass aligned;
  std::vector<StepSampler> samplers;
  std::vector<PoseClouds> clouds;
  for (int i = 0; i < count; ++i) {
    const TrainingStep& step = steps[members.members[i]];
    samplers.emplace_back(clips[step.clip].clip, layout, means, step.span);
    clouds.push_back(AlignmentPoses(samplers.back(), layout, means));
    if (step.steady) aligned.steady.push_back(i);
  }
  if (aligned.steady.empty()) throw std::invalid_argument("AlignClass: " + members.primitive + " has no steady step");
  aligned.reference = PickReference(clouds, aligned.steady, distance_weights);
  aligned.vectors.resize(layout.channels() * kPhaseSamples + kTimingValues, count);
  for (int i = 0; i < count; ++i) {
    aligned.warps.push_back(Align(clouds[aligned.reference], clouds[i], distance_weights));
    aligned.vectors.col(i) = samplers[i].Vector(aligned.warps[i]);
  }
  return aligned;
}

}  // namespace morphograph
