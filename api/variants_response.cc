#include "api/variants_response.h"

#include <nlohmann/json.hpp>

#include "api/clip_response.h"
#include "api/rounded_json.h"

namespace morphograph {
namespace {

using nlohmann::ordered_json;

ordered_json RangeJson(const MeasuredRange& range) {
  return {{"min", Decimals5(range.min)}, {"mean", Decimals5(range.mean)}, {"max", Decimals5(range.max)}};
}

ordered_json RingJson(const std::vector<Eigen::Vector2d>& corners_m) {
  ordered_json ring = ordered_json::array();
  for (const Eigen::Vector2d& corner : corners_m) ring.push_back(FloorPointJson(corner));
  return ring;
}

}  // namespace

std::string VariantLine(const ClipVariant& variant, const OutputFormat& output) {
  const std::string clip = ClipJson(ClipBvh(variant.clip, output), ReportJson(variant.report));
  return "{\"index\":" + std::to_string(variant.index) + ",\"seed\":" + std::to_string(variant.report.seed) + "," + clip.substr(1);
}

std::string VariantSummaryJson(const VariantSummary& summary) {
  ordered_json json = {{"asked", summary.asked}, {"made", summary.made}, {"unmet", summary.asked - summary.made}};
  json["duration"] = RangeJson(summary.duration_s);
  if (summary.arrival_s) json["arrival_time"] = RangeJson(*summary.arrival_s);
  if (summary.path_deviation_mean_m) {
    json["path_deviation"] = {{"mean", Decimals5(*summary.path_deviation_mean_m)}, {"max", Decimals5(*summary.path_deviation_max_m)}};
  }
  json["spread"] = {{"clips", Decimals5(summary.clip_spread_m)}, {"steps", Decimals5(summary.step_spread_m)}};
  const SweptArea& area = summary.swept_area;
  ordered_json& swept = json["swept_area"] = {
      {"area", Decimals5(area.area_m2)}, {"margin", area.margin_m}, {"resolution", area.resolution_m}, {"polygons", ordered_json::array()}};
  for (const FloorRegion& region : area.regions) {
    ordered_json holes = ordered_json::array();
    for (const auto& hole : region.holes_m) holes.push_back(RingJson(hole));
    swept["polygons"].push_back({{"outline", RingJson(region.outline_m)}, {"holes", std::move(holes)}});
  }
  return json.dump();
}

}  // namespace morphograph
