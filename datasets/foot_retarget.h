#pragma once

#include "datasets/motion_clip.h"

namespace morphograph {

/// Puts the feet of a retargeted clip where the source's are: people's legs differ in length, and one person's left from the right, so that
/// the same turns of the joints leave feet that stood hanging, or sunk, by centimetres.
///
/// The body is lifted so that both balls together come as low as they do in the source. Then each leg is bent or stretched: ankles go the source's
/// way over the floor, `scale` times as far, and balls rise as many times as high over where they are low, which becomes one height for both:
/// where one ball stands a centimetre over the other on a level floor, that is how the source's joints were placed in its feet. Feet stay turned
/// as they are. A leg is never stretched by more than most of what it is bent.
///
/// Where either skeleton has not two legs that can be bent the body alone is lifted, by the lower ball.
///
/// @param scale  length of the target's legs over that of the source's.
/// @param moved  on the target skeleton, frame by frame the same poses, its root's path scaled.
void PlaceFeetAsIn(const MotionClip& source, double scale, MotionClip* moved);

}  // namespace morphograph
