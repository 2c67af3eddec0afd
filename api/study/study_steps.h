#pragma once

#include <string>
#include <vector>

#include "api/study/study_context.h"
#include "graph/step_alignment.h"
#include "graph/training_set.h"

namespace morphograph {

/// The captured steps of a study on one timeline, class by class, as training makes them.
struct StudySteps {
  TrainingSet set;
  std::vector<int> classes;           // of `set.classes`: those of steps between two landings; a few of them in a quick study
  std::vector<AlignedClass> aligned;  // of each of `classes`

  const StepClass& members(size_t i) const { return set.classes[classes[i]]; }
  std::string Name(size_t i) const;  // "left_walk (elderly)"
  /// Positions in the class of the steady steps whose clips are in a half of the study's clips.
  std::vector<int> Half(const StudyContext& context, size_t i, int half) const;
};

/// The captured clips, cut into steps and sorted into classes. @throws DatasetError when they hold too few steps.
TrainingSet StudyTrainingSet(const StudyContext& context, StudyData data);

/// @throws DatasetError when the clips hold too few steps.
StudySteps FindStudySteps(const StudyContext& context, StudyData data);

inline const char* DataName(StudyData data) { return data == StudyData::kClean ? "clean" : "noisy"; }

}  // namespace morphograph
