#include "api/reconstruction_stream.h"

#include <limits>
#include <stdexcept>

#include "api/json_guard.h"
#include "api/request/findings.h"
#include "api/request/object_reader.h"
#include "api/rounded_json.h"
#include "datasets/error_reason.h"
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

// What a stream cannot be made of lies in its times: numbers are checked before.
template <typename Repair>
std::vector<Eigen::VectorXd> OrRefuse(Repair repair) {
  try {
    return repair();
  } catch (const std::invalid_argument& unfit) {
    Findings findings("the line");
    findings.Malformed("/time", ReasonOf(unfit));
    findings.ThrowIfAny();
    throw;
  }
}

std::vector<std::string> NamesOf(const std::vector<Placement>& sensors) {
  std::vector<std::string> names;
  for (const Placement& sensor : sensors) names.push_back(sensor.name);
  return names;
}

}  // namespace

ReconstructionStream::ReconstructionStream(std::shared_ptr<const Reconstructor> reconstructor)
    : reconstructor_(std::move(reconstructor)),
      estimator_(StartOrRefuse(*reconstructor_)),
      repair_(NamesOf(reconstructor_->sensors()), RepairOptions(*reconstructor_)),
      assembler_(*reconstructor_->base()) {
  if (reconstructor_->method() != ReconstructionMethod::kMarkers) usual_ = reconstructor_->base()->accelerations().cast<double>().rowwise().mean();
}

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
  return Lines(OrRefuse([&] { return repair_.Push(*time_s, sample); }), false);
}

std::string ReconstructionStream::Finish() {
  return Lines(OrRefuse([&] { return repair_.Finish(); }), true);
}

std::string ReconstructionStream::Lines(const std::vector<Eigen::VectorXd>& samples, bool last) {
  std::string lines;
  const std::vector<int> dead = usual_.size() > 0 ? repair_.dead_sensors() : std::vector<int>();
  const Skeleton& skeleton = reconstructor_->base()->skeleton();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    Eigen::VectorXd sample = samples[i];
    for (const int s : dead) sample.segment<3>(3 * s) = usual_.segment<3>(3 * s);
    const PlacedPose pose = assembler_.Add(estimator_->Next(sample));
    ordered_json rotations = ordered_json::object();
    for (int j = 0; j < skeleton.joint_count(); ++j) {
      if (!skeleton.IsBody(j)) continue;
      const Eigen::Quaterniond& q = pose.rotations[static_cast<std::size_t>(j)];
      rotations[skeleton.joint(j).name] = {Decimals5(q.w()), Decimals5(q.x()), Decimals5(q.y()), Decimals5(q.z())};
    }
    ordered_json line = {{"time", Decimals5(static_cast<double>(frames_++) / kReconstructionRate_hz)},
                         {"root", {Decimals5(pose.root_m.x()), Decimals5(pose.root_m.y()), Decimals5(pose.root_m.z())}},
                         {"rotations", std::move(rotations)}};
    if ((!last || i + 1 == samples.size()) && told_ < repair_.notes().size()) {
      line["notes"] = std::vector<std::string>(repair_.notes().begin() + static_cast<std::ptrdiff_t>(told_), repair_.notes().end());
      told_ = repair_.notes().size();
    }
    lines += line.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
  }
  return lines;
}

}  // namespace morphograph
