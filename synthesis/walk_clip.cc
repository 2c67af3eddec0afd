#include "synthesis/walk_clip.h"

#include <algorithm>
#include <cmath>

#include "synthesis/foot_lock.h"
#include "synthesis/step_joiner.h"
#include "synthesis/step_track.h"
#include "synthesis/toe_bend.h"

namespace morphograph {
namespace {

std::vector<StepTrack> LayOut(const MotionGraph& graph, const std::vector<DrawnStep>& walk, int frames, double rate_hz) {
  std::vector<StepTrack> tracks;
  for (size_t k = 0; k < walk.size(); ++k) {
    if (walk[k].start > frames) break;
    const auto fade = [&](size_t a, size_t b) {
      return CrossFadeHalfWidth(walk[a].end - walk[a].start, walk[b].end - walk[b].start, rate_hz);
    };
    // One frame more than the cross-fade: increments look to the next frame.
    const double before = k > 0 ? fade(k - 1, k) + 1 : 0;
    const double after = k + 1 < walk.size() ? fade(k, k + 1) + 2 : 0;
    const int first = k > 0 ? std::max(0, static_cast<int>(std::floor(walk[k].start - before))) : 0;
    // The last step, where it ends the walk, is followed by its margin.
    const int last = k + 1 < walk.size() ? std::min(frames, static_cast<int>(std::ceil(walk[k].end + after))) : frames;
    const MotionPrimitive& primitive = graph.primitive(walk[k].step.primitive);
    const ContactProfile contacts = walk[k].contacts ? *walk[k].contacts : primitive.Contacts(walk[k].step.latent);
    tracks.push_back(LayOutStep(primitive.style_index, walk[k].shape, contacts, walk[k].start, rate_hz, first, std::max(first, last)));
    ToLogMaps(graph.layout(), graph.styles()[primitive.style_index].mean_rotations, &tracks.back());
  }
  return tracks;
}

// Where the feet of a walk touch the floor: as in its first action, and as low as in any.
FeetGeometry FeetOf(const MotionGraph& graph, const std::vector<DrawnStep>& walk) {
  const auto feet_of = [&](const DrawnStep& step) -> const FeetGeometry& {
    return graph.styles()[static_cast<size_t>(graph.primitive(step.step.primitive).style_index)].feet;
  };
  FeetGeometry feet = feet_of(walk.front());
  for (const DrawnStep& step : walk) {
    for (int side = 0; side < 2; ++side) {
      feet.heel_lowest_m[side] = std::min(feet.heel_lowest_m[side], feet_of(step).heel_lowest_m[side]);
      feet.ball_lowest_m[side] = std::min(feet.ball_lowest_m[side], feet_of(step).ball_lowest_m[side]);
    }
  }
  return feet;
}

}  // namespace

MotionClip MakeWalkClip(const MotionGraph& graph, const std::vector<DrawnStep>& walk, int frames, double frame_rate_hz,
                        const StartPose& start, const SynthesisVariant& variant) {
  const GraphStyle& style = graph.styles()[graph.primitive(walk.at(0).step.primitive).style_index];
  JoinedSteps joined = JoinSteps(graph, LayOut(graph, walk, frames, frame_rate_hz), frames, frame_rate_hz, start, variant.cross_fade);
  if (variant.foot_lock) LockFeet(FeetOf(graph, walk), graph.layout(), joined.contacts, {}, &joined.clip);
  BendToes(&joined.clip);
  joined.clip.style = style.name;
  return std::move(joined.clip);
}

}  // namespace morphograph
