#include "graph/recorded_motion.h"

#include "graph/training_set.h"
#include "primitives/rotation_math.h"

namespace morphograph {

std::string RecordedMotion::Problem(const PoseLayout& layout) const {
  if (roots.rows() != 3 || rotations.rows() != roots.cols() || rotations.cols() != 3 * static_cast<Eigen::Index>(layout.active_joints().size()))
    return "recordings do not fit the pose layout";
  Eigen::Index next = 0;
  for (const RecordedClip& clip : clips) {
    if (clip.first != next || clip.frames < 2 || !(clip.frame_rate_hz > 0)) return "a recorded clip is of the wrong size";
    next += clip.frames;
  }
  if (next != roots.cols()) return "recorded clips do not make up the frames";
  for (const RecordedStep& step : steps) {
    if (step.clip < 0 || step.clip >= static_cast<int>(clips.size()) || !(step.start_frame >= 0) || !(step.end_frame > step.start_frame) ||
        step.end_frame > clips[static_cast<std::size_t>(step.clip)].frames - 1)
      return "a recorded step lies outside of its clip";
  }
  return {};
}

RecordedMotion RecordMotion(const TrainingSet& set) {
  RecordedMotion motion;
  std::vector<int> places(set.clips.size(), -1);  // in `motion.clips`
  int frames = 0;
  for (std::size_t c = 0; c < set.clips.size(); ++c) {
    if (set.clips[c].made) continue;
    const MotionClip& clip = set.clips[c].clip;
    places[c] = static_cast<int>(motion.clips.size());
    motion.clips.push_back({clip.name, clip.style, clip.frame_rate_hz(), frames, clip.frame_count()});
    frames += clip.frame_count();
  }
  const std::vector<int>& active = set.layout.active_joints();
  motion.roots.resize(3, frames);
  motion.rotations.resize(frames, 3 * static_cast<Eigen::Index>(active.size()));
  for (std::size_t c = 0; c < set.clips.size(); ++c) {
    if (places[c] < 0) continue;
    const MotionClip& clip = set.clips[c].clip;
    const int first = motion.clips[static_cast<std::size_t>(places[c])].first;
    motion.roots.middleCols(first, clip.frame_count()) = clip.root_positions().cast<float>();
    for (int f = 0; f < clip.frame_count(); ++f) {
      for (std::size_t n = 0; n < active.size(); ++n)
        motion.rotations.block<1, 3>(first + f, 3 * static_cast<Eigen::Index>(n)) = LogMap(clip.rotation(f, active[n])).cast<float>().transpose();
    }
  }
  for (const TrainingStep& step : set.steps) {
    const int clip = places[static_cast<std::size_t>(step.clip)];
    if (clip < 0 || !(IsWalkStep(step) || step.slow_step)) continue;
    const bool left = IsWalking(step.end) ? step.end == KeyframeLabel::kLeftStance : step.start == KeyframeLabel::kRightStance;
    motion.steps.push_back({clip, step.span.start_frame, step.span.end_frame, left});
  }
  return motion;
}

std::vector<MotionClip> RecordedClips(const RecordedMotion& motion, const PoseLayout& layout, const MeanRotations& rest) {
  const std::vector<int>& active = layout.active_joints();
  const int root = layout.skeleton().moving_root();
  std::vector<MotionClip> clips;
  for (const RecordedClip& recorded : motion.clips) {
    MotionClip clip(layout.shared_skeleton(), recorded.frame_rate_hz, recorded.frames);
    clip.name = recorded.name;
    clip.style = recorded.style;
    clip.root_positions() = motion.roots.middleCols(recorded.first, recorded.frames).cast<double>();
    for (int f = 0; f < recorded.frames; ++f) {
      for (int j = 0; j < clip.joint_count(); ++j) {
        if (j != root && layout.skeleton().IsBody(j)) clip.rotation(f, j) = rest[static_cast<std::size_t>(j)];
      }
      for (std::size_t n = 0; n < active.size(); ++n)
        clip.rotation(f, active[n]) = ExpMap(motion.rotations.block<1, 3>(recorded.first + f, 3 * static_cast<Eigen::Index>(n)).transpose().cast<double>());
    }
    clips.push_back(std::move(clip));
  }
  return clips;
}

}  // namespace morphograph
