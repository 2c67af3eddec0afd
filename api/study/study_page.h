#pragma once

#include <string>

#include "api/study/study.h"

namespace morphograph {

/// The study as one HTML page (`index.html`) that needs nothing else: no script, no font, no request. First what was run and the table
/// beside the published figures, then the sections with their drawings.
std::string StudyPage(const StudyReport& report);

}  // namespace morphograph
