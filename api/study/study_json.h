#pragma once

#include <string>

#include "api/study/study.h"

namespace morphograph {

/// The study as JSON (`study.json`): options, data, notes, the table of figures, and each section's figures and data by its id. Numbers are
/// finite or null. Whatever depends on the machine is in the member "times".
std::string StudyJson(const StudyReport& report);

}  // namespace morphograph
