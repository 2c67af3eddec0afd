#pragma once

#include "api/study/study_context.h"
#include "api/study/study_section.h"

namespace morphograph {

/// How well one step tells the next (Du 3.5), judged on clips left out: the Gaussian process in use, the RBF process alone, ridge regression, and
/// the mixture without any transition. Held-out likelihood, error, and calibration of the predicted variance.
/// @throws DatasetError when no transition of the clean clips has enough pairs.
StudySection StudyTransitions(StudyContext& context);

}  // namespace morphograph
