#include "datasets/rest_frames.h"

#include <algorithm>

namespace morphograph {
namespace {

// A jump is told from motion by the frames behind it.
constexpr int kFollowing = 20;
constexpr int kFewestFollowing = 2;
constexpr double kJumpRatio = 4;
constexpr double kJump_rad = 0.05;     // mean over the joints
constexpr double kHeld_rad = 1e-4;

// Mean turn of the joints between two frames, the root's own turn left out.
double PoseChange(const MotionClip& clip, int from, int to) {
  double sum = 0;
  int joints = 0;
  for (int j = 0; j < clip.joint_count(); ++j) {
    if (j == clip.skeleton().moving_root()) continue;
    sum += clip.rotation(from, j).angularDistance(clip.rotation(to, j));
    ++joints;
  }
  return joints > 0 ? sum / joints : 0;
}

bool RootUnset(const MotionClip& clip, int frame) {
  const Eigen::Quaterniond& rotation = clip.rotation(frame, clip.skeleton().moving_root());
  return clip.root_positions().col(frame).isZero(0) && rotation.vec().isZero(0);
}

}  // namespace

int CountLeadingRestFrames(const MotionClip& clip) {
  const int frames = clip.frame_count();
  int unset = 0;
  while (unset < frames && RootUnset(clip, unset)) ++unset;
  if (unset == frames) return 0;

  int held = unset + 1;
  while (held < frames && PoseChange(clip, unset, held) < kHeld_rad) ++held;
  if (frames - held <= kFewestFollowing) return unset;
  const double jump = PoseChange(clip, held - 1, held);
  double largest = 0;
  for (int f = held; f + 1 < std::min(frames, held + 1 + kFollowing); ++f) {
    largest = std::max(largest, PoseChange(clip, f, f + 1));
  }
  return jump > kJump_rad && jump > kJumpRatio * largest ? held : unset;
}

}  // namespace morphograph
