#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "synthesis/evaluation.h"

namespace morphograph {

/// What `evaluate --json` and `POST /v1/evaluations` say of a clip: name, length, quality, contacts, and the curves that
/// the figures are taken from.
/// @param first_frame  frame of the file that is the clip's first: leading rest rows are not part of a clip. Contacts come in frames of the
///   file, like key frames do; curves have a rate of their own and begin at the clip's first frame.
nlohmann::ordered_json EvaluationJson(const MotionClip& clip, const ClipEvaluation& evaluation, int first_frame);

/// How the whole set compares with the reference.
nlohmann::ordered_json ComparisonJson(const SetComparison& comparison);

/// Parses, imports and evaluates BVH text.
/// @throws DatasetError on bad text; ProblemError (422) where the clip cannot be judged: no legs, too short.
nlohmann::ordered_json EvaluateBvh(std::string_view bvh, const std::string& name);

}  // namespace morphograph
