#include "api/reconstruction_stream.h"

#include <limits>

#include "api/json_guard.h"
#include "api/request/findings.h"
#include "api/request/object_reader.h"
#include "api/rounded_json.h"
#include "synthesis/unsatisfiable_request.h"

namespace morphograph {
namespace {

using nlohmann::ordered_json;

std::unique_ptr<PoseEstimator> StartOrRefuse(const Reconstructor& reconstructor) {
  std::unique_ptr<PoseEstimator> estimator = reconstructor.Start();
  if (!estimator) throw UnsatisfiableRequest("/method", "'" + std::string(MethodName(reconstructor.method())) + "' needs all readings at once; olng, olng_kernels, rbf, rbf_lle, gaussian and markers go frame by frame");
  return estimator;
}

LiveRepairOptions RepairOptions(const Reconstructor& reconstructor) {
  LiveRepairOptions options;
  options.kind = reconstructor.method() == ReconstructionMethod::kMarkers ? ReadingsKind::kMarkers : ReadingsKind::kAccelerations;
  options.rate_hz = kReconstructionRate_hz;
  return options;
}

}  // namespace

ReconstructionStream::ReconstructionStream(std::shared_ptr<const Reconstructor> reconstructor)
    : reconstructor_(std::move(reconstructor)),
      estimator_(StartOrRefuse(*reconstructor_)),
      repair_(static_cast<int>(reconstructor_->sensors().size()), RepairOptions(*reconstructor_)),
      assembler_(*reconstructor_->base()) {}

std::string ReconstructionStream::Push(std::string_view line) {
  if (line.find_first_not_of(" \t\r\n") == std::string_view::npos) return {};
  const nlohmann::json document = ParseUntrustedJson(line);
  Findings findings("the line");
  if (!document.is_object()) {
    findings.Malformed("", "must be an object with \"time\" and \"readings\"");
    findings.ThrowIfAny();
  }
  ObjectReader reader(document, "", &findings);
  const std::optional<double> time_s = reader.Required("time", reader.Bounded("time", {-1e9, 1e9, "s"}), "seconds");
  const std::size_t width = 3 * reconstructor_->sensors().size();
  const nlohmann::json* values = reader.List("readings", width, width, "numbers, three a sensor");
  if (!values && !reader.Has("readings")) findings.Malformed("/readings", "required: three numbers a sensor, null where lost");
  reader.RefuseOthers();
  Eigen::VectorXd sample(static_cast<Eigen::Index>(width));
  for (std::size_t i = 0; values && i < width; ++i) {
    const nlohmann::json& value = (*values)[i];
    if (!value.is_number() && !value.is_null()) findings.Malformed("/readings/" + std::to_string(i), "must be a number, or null where it was lost");
    sample[static_cast<Eigen::Index>(i)] = value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
  }
  findings.ThrowIfAny();
  return Lines(repair_.Push(*time_s, sample));
}

std::string ReconstructionStream::Finish() { return Lines(repair_.Finish()); }

std::string ReconstructionStream::Lines(const std::vector<Eigen::VectorXd>& samples) {
  std::string lines;
  const Skeleton& skeleton = reconstructor_->base()->skeleton();
  for (const Eigen::VectorXd& sample : samples) {
    const PlacedPose pose = assembler_.Add(estimator_->Next(sample));
    ordered_json rotations = ordered_json::object();
    for (int j = 0; j < skeleton.joint_count(); ++j) {
      if (!skeleton.IsBody(j)) continue;
      const Eigen::Quaterniond& q = pose.rotations[static_cast<std::size_t>(j)];
      rotations[skeleton.joint(j).name] = {Decimals5(q.w()), Decimals5(q.x()), Decimals5(q.y()), Decimals5(q.z())};
    }
    const ordered_json line = {{"time", Decimals5(static_cast<double>(frames_++) / kReconstructionRate_hz)},
                               {"root", {Decimals5(pose.root_m.x()), Decimals5(pose.root_m.y()), Decimals5(pose.root_m.z())}},
                               {"rotations", std::move(rotations)}};
    lines += line.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
  }
  return lines;
}

}  // namespace morphograph
