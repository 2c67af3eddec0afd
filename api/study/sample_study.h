#pragma once

#include "api/study/study_context.h"
#include "api/study/study_section.h"

namespace morphograph {

// The parts of the study that look at synthesised clips. Each runs on any set of clips; what the data do not allow is left out and said.

/// Contact distance and naturalness of captured and synthesised steps, clean and noisy (Du 4.5: Fig. 4.17-4.21, Tables 4.4 and 4.5), foot
/// skate, acceleration and jerk.
StudySection StudyFeetAndFlow(StudyContext& context);

/// How synthesised clips compare with captured ones as sets: Fréchet distance, diversity, a classifier; trained on all clips, and trained on
/// one half and judged on the other.
StudySection StudyLikeness(StudyContext& context);

/// Whether walks of 200 steps keep mean and spread of the captured steps.
StudySection StudyLongWalks(StudyContext& context);

/// What becomes of the samples when a part of the method is left out.
StudySection StudyAblations(StudyContext& context);

}  // namespace morphograph
