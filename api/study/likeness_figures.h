#pragma once

#include <nlohmann/json.hpp>

#include "api/study/likeness.h"
#include "api/study/study_section.h"

namespace morphograph {

nlohmann::ordered_json LikenessJson(const Likeness& likeness);

/// Lines of the table: for all styles together and the worst of them, with whose it is.
void AddLikenessFigures(const LikenessCut& cut, const Likeness& overall, const LikenessByStyle& styles, StudySection* section);

/// Bars by style: Fréchet distance, classifier, diversity.
void AddLikenessCharts(const LikenessCut& cut, const Likeness& overall, const LikenessByStyle& styles, StudySection* section);

}  // namespace morphograph
