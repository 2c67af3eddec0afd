#include "api/evaluation_response.h"

#include <cmath>

#include "api/clip_response.h"
#include "api/problem.h"
#include "datasets/bvh_reader.h"
#include "datasets/clip_conversion.h"
#include "datasets/error_reason.h"

namespace morphograph {
namespace {

using nlohmann::ordered_json;

// Six significant digits: a curve is for looking at.
ordered_json Curve(const std::vector<double>& values) {
  ordered_json json = ordered_json::array();
  for (const double value : values) {
    if (value == 0 || !std::isfinite(value)) {
      json.push_back(value == 0 ? ordered_json(0) : ordered_json(nullptr));
      continue;
    }
    const double unit = std::pow(10.0, 5 - std::floor(std::log10(std::abs(value))));
    json.push_back(std::round(value * unit) / unit);
  }
  return json;
}

}  // namespace

ordered_json EvaluationJson(const MotionClip& clip, const ClipEvaluation& evaluation, int first_frame) {
  std::vector<PlantedFoot> contacts = evaluation.contacts;
  for (PlantedFoot& contact : contacts) {
    contact.interval.first += first_frame;
    contact.interval.last += first_frame;
  }
  return {{"clip", clip.name},
          {"first_frame", first_frame},
          {"frames", clip.frame_count()},
          {"frame_rate", clip.frame_rate_hz()},
          {"duration", clip.duration_s()},
          {"quality", QualityJson(evaluation.quality)},
          {"contacts", ContactsJson(contacts)},
          {"curves",
           {{"frame_rate", kEvaluationRateHz},
            {"contact_distance", Curve(evaluation.contact_distance_m)},
            {"frame_difference", Curve(evaluation.frame_difference)}}}};
}

ordered_json ComparisonJson(const SetComparison& comparison) {
  return {{"frechet", comparison.frechet},
          {"frechet_halves", comparison.frechet_halves},
          {"frechet_ratio", comparison.frechet_ratio},
          {"residual_ratio", comparison.residual_ratio},
          {"diversity", comparison.diversity},
          {"diversity_reference", comparison.diversity_reference},
          {"windows", comparison.windows},
          {"windows_reference", comparison.windows_reference}};
}

ordered_json EvaluateBvh(std::string_view bvh, const std::string& name) {
  // A stranger's file may not take more memory than its own size warrants. With these a clip takes some 400 MB at most.
  constexpr std::int64_t kMaxJointFrames = 4'000'000;
  BvhLimits limits;
  limits.max_values = 40'000'000;
  limits.max_joint_frames = kMaxJointFrames;
  ClipImportReport import;
  MotionClip clip = ImportClip(ParseBvh(bvh, name, limits), {}, &import);
  clip.name = name;
  const double longest_s = kMaxJointFrames / kEvaluationRateHz / clip.joint_count();
  if (clip.duration_s() > longest_s) {
    throw ProblemError(422, "the clip cannot be evaluated: it claims " + std::to_string(std::llround(clip.duration_s())) +
                                " s; at most " + std::to_string(std::llround(longest_s)) + " s of " +
                                std::to_string(clip.joint_count()) + " joints are taken");
  }
  try {
    return EvaluationJson(clip, EvaluateClip(clip), import.dropped_frames);
  } catch (const std::invalid_argument& unfit) {  // no leg roles, fewer than two frames
    throw ProblemError(422, "the clip cannot be evaluated: " + ReasonOf(unfit));
  }
}

}  // namespace morphograph
