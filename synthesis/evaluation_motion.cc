#include "synthesis/evaluation_motion.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "datasets/forward_kinematics.h"
#include "datasets/resample.h"

namespace morphograph {

EvaluationMotion PrepareEvaluation(const MotionClip& clip) {
  if (!clip.shared_skeleton()) throw std::invalid_argument("PrepareEvaluation: the clip has no skeleton");
  if (clip.frame_count() < 2) {
    throw std::invalid_argument("PrepareEvaluation: at least 2 frames are needed, not " +
                                std::to_string(clip.frame_count()));
  }
  // Frame times of files carry rounding (0.0083333 s), so nearly 30 is 30.
  if (std::abs(clip.frame_rate_hz() - kEvaluationRateHz) > 1e-3 * kEvaluationRateHz) {
    const MotionClip resampled = Resample(clip, kEvaluationRateHz);
    if (resampled.frame_count() < 2) {
      throw std::invalid_argument("PrepareEvaluation: the clip is shorter than two frames at 30 fps");
    }
    return PrepareEvaluation(resampled);
  }
  EvaluationMotion motion;
  motion.skeleton = clip.shared_skeleton();
  std::vector<WorldPose> poses = WorldPoses(clip);
  for (int f = 0; f < clip.frame_count(); ++f) {
    if (poses[static_cast<size_t>(f)].positions.allFinite()) continue;
    throw std::invalid_argument("PrepareEvaluation: frame " + std::to_string(f) + " of '" + clip.name +
                                "' is not finite");
  }
  motion.contacts = DetectContacts(clip, poses);
  motion.joint_positions.reserve(poses.size());
  for (WorldPose& pose : poses) motion.joint_positions.push_back(std::move(pose.positions));
  motion.ground = FitGroundPlane(motion.contacts, kEvaluationRateHz);
  return motion;
}

}  // namespace morphograph
