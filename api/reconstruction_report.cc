#include "api/reconstruction_report.h"

#include <nlohmann/json.hpp>

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
