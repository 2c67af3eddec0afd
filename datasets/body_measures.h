#pragma once

#include <string>

#include "datasets/motion_clip.h"

namespace morphograph {

/// What the size and the posture of a body tell about the axes and the unit of a file.
struct BodyMeasures {
  UpAxis up_axis = UpAxis::kY;
  double metres_per_unit = 1;
  std::string up_note;    // why the up axis is a guess, else empty
  std::string unit_note;  // why the unit is a guess, else empty
};

/// Measures a clip whose lengths and axes are still the source's.
///
/// Up axis: the axis along which hips (or head) lie above the ankles on average. Unit: the one of metre,
/// centimetre, millimetre, inch and 1/0.45 inch (the ASF/AMC scale of the CMU database) that makes the legs most like
/// a grown person's; where none fits, the unit that makes them exactly so. `skeleton` gives bone offsets.
BodyMeasures MeasureBody(const MotionClip& clip, const Skeleton& skeleton);

}  // namespace morphograph
