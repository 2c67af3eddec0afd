#pragma once

#include "api/study/study_context.h"
#include "api/study/study_section.h"

namespace morphograph {

/// Reduction of step vectors (Du 4.4, Fig. 4.12, 4.13; Xie 5.1.3): weighted squared error and variance kept against the number of
/// components, by weighted and by plain PCA and by locally linear embedding, on the steps taught and on steps of clips left out, clean and
/// noisy. @throws DatasetError when the clips hold too few steps.
StudySection StudyReduction(StudyContext& context);

}  // namespace morphograph
