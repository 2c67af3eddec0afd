#pragma once

#include "api/study/study_context.h"
#include "api/study/study_section.h"

namespace morphograph {

/// Motion found again from four accelerometers (Tautges 2011): the priors of the energy against each other (6.2.5) and against the nearest neighbour, on clips that
/// no base holds.
StudySection StudySensors(StudyContext& context);

}  // namespace morphograph
