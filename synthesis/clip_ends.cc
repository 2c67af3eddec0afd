#include "synthesis/clip_ends.h"

namespace morphograph {

std::vector<MotionClip> WithoutEnds(const std::vector<MotionClip>& clips, int frames) {
  constexpr int kSecond = 30;
  std::vector<MotionClip> kept;
  for (const MotionClip& clip : clips) {
    const int left = clip.frame_count() - 2 * frames;
    if (left >= kSecond) kept.push_back(clip.Slice(frames, left));
  }
  return kept;
}

}  // namespace morphograph
