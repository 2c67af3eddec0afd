#pragma once

#include "api/study/study_context.h"
#include "api/study/study_section.h"

namespace morphograph {

/// Key frames found by feature and by labelled examples (Du 4.2, Fig. 4.7, 4.8): precision, extraction rate and distortion against the least
/// step time, clean and noisy, and the time that both take.
///
/// Where no clip is labelled, the key frames found by feature in the clean clips stand in for labels: then it is told how much noise and step
/// time change what is found, not whether it is true.
StudySection StudyKeyframes(StudyContext& context);

}  // namespace morphograph
