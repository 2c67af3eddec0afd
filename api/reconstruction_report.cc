#include "api/reconstruction_report.h"

#include <nlohmann/json.hpp>
#include <numbers>

#include "api/clip_response.h"
#include "api/repair_report.h"
#include "api/rounded_json.h"

namespace morphograph {

std::string ReconstructionReportJson(ReconstructionMethod method, const ReconstructedReadings& made, const std::optional<ReconstructionQuality>& errors) {
  using nlohmann::ordered_json;
  const Reconstruction& reconstruction = made.reconstruction;
  ordered_json report = ordered_json::parse(ReportJson(reconstruction.report));
  report.erase("seed");
  if (method != ReconstructionMethod::kGraph) {
    report.erase("steps");
    report.erase("constraints");
  }
  ordered_json about = {{"method", std::string(MethodName(method))}};
  about.update(RepairJson(made.sensors, made.repaired));
  about["latency_ms"] = {{"mean", Decimals5(reconstruction.latency_ms_mean)}, {"p95", Decimals5(reconstruction.latency_ms_p95)}};
  if (reconstruction.residual_m_s2) about["residual"] = Decimals5(*reconstruction.residual_m_s2);
  if (made.alignment) {
    const SensorTurns& found = *made.alignment;
    ordered_json sensors = ordered_json::array();
    for (std::size_t s = 0; s < found.sensors.size(); ++s) {
      const Eigen::Quaterniond& q = found.sensors[s].told_from_worn;
      sensors.push_back({{"sensor", made.sensors[s]},
                         {"angle", Decimals5(found.sensors[s].turn_rad() * 180 / std::numbers::pi)},
                         {"orientation", {Decimals5(q.w()), Decimals5(q.x()), Decimals5(q.y()), Decimals5(q.z())}},
                         {"delay", Decimals5(found.sensors[s].delay_s)}});
    }
    about["alignment"] = {{"standing", {Decimals5(found.standing.from_s), Decimals5(found.standing.to_s)}}, {"standing_found", !found.told}, {"standing_in_recordings", !found.guessed}, {"sensors", std::move(sensors)}};
  }
  if (errors) {
    about["errors"] = {{"frames", errors->frames},
                       {"position_rms_cm", {{"mean", Decimals5(errors->position_rms_cm)}, {"p95", Decimals5(errors->position_rms_p95_cm)}}},
                       {"angle", Decimals5(errors->angle_deg)},
                       {"normalised_rms", Decimals5(errors->normalised_rms)},
                       {"velocity_cm_s", Decimals5(errors->velocity_error_cm_s)},
                       {"jerk_ratio", Decimals5(errors->jerk_ratio)},
                       {"contact_agreement", Decimals5(errors->contact_agreement)}};
  }
  report["reconstruction"] = std::move(about);
  return report.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace morphograph
