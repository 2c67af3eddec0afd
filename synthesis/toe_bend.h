#pragma once

#include "datasets/motion_clip.h"

namespace morphograph {

/// Bends toes that would go through the floor, y = 0, as they do late in a stance: the toe joint turns up until its tip, the end site,
/// is no deeper than half a centimetre. Recordings often hold toes stiff. Skeletons without such end sites stay as they are.
void BendToes(MotionClip* clip);

}  // namespace morphograph
