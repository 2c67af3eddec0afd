#pragma once

#include <string>

#include "datasets/motion_clip.h"

namespace morphograph {

/// The clip as binary glTF 2.0 (GLB): a node a joint, in metres, Y up, and one animation with linear rotation channels for
/// every joint that turns and a translation channel for the moving root. There is no mesh.
/// @throws std::invalid_argument for a clip without frames.
std::string WriteGlb(const MotionClip& clip);

}  // namespace morphograph
