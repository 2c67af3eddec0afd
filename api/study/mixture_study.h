#pragma once

#include "api/study/study_context.h"
#include "api/study/study_section.h"

namespace morphograph {

/// Mixtures over reduced steps (Du 3.4, 4.4, Fig. 3.10, 4.14): Bayesian information criterion against the number of Gaussians, after weighted
/// and plain PCA, clean and noisy; full, tied and diagonal covariances by the criterion and by the likelihood of steps left out.
/// @throws DatasetError when the clips hold too few steps.
StudySection StudyMixture(StudyContext& context);

}  // namespace morphograph
