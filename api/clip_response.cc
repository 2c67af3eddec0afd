#include "api/clip_response.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "api/content_hash.h"
#include "api/repair_report.h"
#include "api/request/angles.h"
#include "api/rounded_json.h"
#include "datasets/bvh_writer.h"
#include "datasets/clip_conversion.h"
#include "synthesis/control/sensor_guide.h"

namespace morphograph {
namespace {

using nlohmann::ordered_json;

ordered_json ConstraintsJson(const std::vector<ControlOutcome>& outcomes) {
  ordered_json list = ordered_json::array();
  for (const ControlOutcome& outcome : outcomes) {
    ordered_json& json = list.emplace_back(ordered_json::object());
    if (outcome.index) json["index"] = *outcome.index;
    json["pointer"] = outcome.pointer;
    json["met"] = outcome.met;
    const bool is_angle = outcome.unit == "rad";
    json["residual"] = Decimals5(is_angle ? DegreesFromRadians(outcome.residual) : outcome.residual);
    if (std::isfinite(outcome.tolerance)) json["tolerance"] = Decimals5(is_angle ? DegreesFromRadians(outcome.tolerance) : outcome.tolerance);
    json["unit"] = is_angle ? "deg" : outcome.unit;
    if (outcome.reached.size() == 1) {
      json["reached"] = Decimals5(is_angle ? DegreesFromRadians(outcome.reached[0]) : outcome.reached[0]);
    } else if (!outcome.reached.empty()) {
      for (const double value : outcome.reached) json["reached"].push_back(Decimals5(value));
    }
  }
  return list;
}

// A JSON string. BVH is nearly always printable ASCII and line ends, which need no look at each byte's encoding; anything
// else (a joint's name in another script) is left to the library, at about ten times the cost.
void AppendString(const std::string& text, std::string* json) {
  const bool plain = std::all_of(text.begin(), text.end(), [](char c) {
    return c == '\n' || (c >= ' ' && c < 0x7F && c != '"' && c != '\\');
  });
  if (!plain) {
    *json += nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    return;
  }
  json->reserve(json->size() + text.size() + text.size() / 64);
  *json += '"';
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    json->append(text, at, end - at);
    if (end < text.size()) *json += "\\n";
    at = end + 1;
  }
  *json += '"';
}

}  // namespace

std::string ClipId(const std::string& model_hash, const ClipRequest& request) {
  ClipRequest named_by_content = request;
  named_by_content.model = model_hash;
  return ContentHash("morphograph " MORPHOGRAPH_VERSION "\n" + CanonicalJson(named_by_content));
}

std::string ClipBvh(const MotionClip& clip, const OutputFormat& output) {
  ClipExportOptions options;
  options.source_channels = output.channels == OutputChannels::kSource;
  if (output.unit == OutputUnit::kMetre) options.metres_per_unit = 1.0;
  if (output.unit == OutputUnit::kCentimetre) options.metres_per_unit = 0.01;
  return WriteBvh(ExportClip(clip, options));
}

ordered_json QualityJson(const ClipQuality& quality) {
  ordered_json json = {{"contact_distance", quality.contact_distance_m},
                       {"foot_skate_cm_s", quality.foot_skate_cm_s},
                       {"penetration", quality.penetration_m},
                       {"naturalness", quality.naturalness}};
  if (quality.log_likelihood) json["log_likelihood"] = *quality.log_likelihood;
  return json;
}

ordered_json ContactsJson(const std::vector<PlantedFoot>& contacts) {
  ordered_json json = ordered_json::array();
  for (const PlantedFoot& contact : contacts) {
    json.push_back({{"foot", FootName(contact.interval.foot)},
                    {"from", contact.interval.first},
                    {"to", contact.interval.last},
                    {"position", FloorPointJson(contact.position_m)}});
  }
  return json;
}

std::string ReportJson(const SynthesisReport& report) {
  ordered_json json = {{"seed", report.seed},
                       {"model", {{"name", report.model_name}, {"hash", report.model_hash}}},
                       {"action", report.action},
                       {"actions", ordered_json::array()},
                       {"style", report.style},
                       {"duration", report.duration_s},
                       {"frames", report.frames}};
  for (const ActionSpan& span : report.actions) json["actions"].push_back({{"action", span.action}, {"from", span.from}});
  if (report.actions.empty()) json.erase("actions");
  auto& steps = json["steps"] = ordered_json::array();
  for (const StepReport& step : report.steps) {
    steps.push_back({{"primitive", step.primitive},
                     {"from", step.from},
                     {"to", step.to},
                     {"log_likelihood", Decimals5(step.log_likelihood)}});
  }
  json["contacts"] = ContactsJson(report.contacts);
  auto& path = json["path"] = ordered_json::array();
  for (const Eigen::Vector2d& point : report.path_m) path.push_back(FloorPointJson(point));
  json["constraints"] = ConstraintsJson(report.constraints);
  if (report.sensors) {
    std::vector<std::string> used;
    for (const Placement& placement : report.sensors->placements) used.push_back(placement.name);
    json["sensors"] = RepairJson(used, report.sensors->repaired);
  }
  json["quality"] = QualityJson(report.quality);
  return json.dump();
}

std::string ClipJson(const std::string& bvh, const std::string& report_json) {
  std::string json = "{\"bvh\":";
  AppendString(bvh, &json);
  json += ",\"report\":";
  json += report_json;
  json += '}';
  return json;
}

std::uint64_t DrawSeed() {
  std::random_device entropy;
  // 53 bits: clients whose numbers are doubles (a browser's JSON) can hold the seed that they are told.
  return ((std::uint64_t{entropy()} << 32) | entropy()) >> 11;
}

std::string ClipFileName(const std::string& model_name, std::uint64_t seed, const std::string& extension) {
  std::string name;
  for (const char c : model_name.substr(0, 64)) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    name += plain ? c : '_';
  }
  return name + "-" + std::to_string(seed) + extension;
}

}  // namespace morphograph
