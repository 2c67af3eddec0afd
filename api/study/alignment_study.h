#pragma once

#include "api/study/study_context.h"
#include "api/study/study_section.h"

namespace morphograph {

/// Alignment of steps to their class's reference (Du 4.3, Table 4.3, Fig. 3.7, 4.9-4.11): path difference and variance of speed under
/// weighted and unweighted frame distance, clean and noisy; what other weights, and one transform for a whole step, would give.
/// @throws DatasetError when the clips hold too few steps.
StudySection StudyAlignment(StudyContext& context);

}  // namespace morphograph
