#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "api/clip_request.h"
#include "synthesis/synthesis_types.h"

namespace morphograph {

/// Name of a clip: hash of program version, model and canonical request, so that the same clip has the same name in
/// every process. The request's seed must be set.
std::string ClipId(const std::string& model_hash, const ClipRequest& request);

/// BVH text of a clip in the form asked for.
std::string ClipBvh(const MotionClip& clip, const OutputFormat& output);

/// The report of CONTRACT.md. Lengths are rounded to 0.01 mm, angles are degrees.
std::string ReportJson(const SynthesisReport& report);

/// `{"bvh": …, "report": …}` from the two texts.
std::string ClipJson(const std::string& bvh, const std::string& report_json);

/// The `quality` object, shared with evaluations.
nlohmann::ordered_json QualityJson(const ClipQuality& quality);

/// The `contacts` array, shared with evaluations.
nlohmann::ordered_json ContactsJson(const std::vector<PlantedFoot>& contacts);

/// A seed nobody has asked for before, from the system's entropy.
std::uint64_t DrawSeed();

/// "walk-42.bvh": a file name of harmless characters.
std::string ClipFileName(const std::string& model_name, std::uint64_t seed, const std::string& extension);

}  // namespace morphograph
