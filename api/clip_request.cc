#include "api/clip_request.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "api/json_guard.h"
#include "api/problem.h"

namespace morphograph {
namespace {

using nlohmann::json;

constexpr double kMaxHeading_deg = 1e6;

// Fields of the contract that come with later releases.
constexpr std::array<std::string_view, 9> kFutureFields = {"goal",    "path",     "speed", "constraints", "sensors",
                                                           "markers", "keep_out", "count", "input"};

std::string Number(double value) { return json(value).dump(); }

// Collects what is wrong; malformed fields (400) outrank values that cannot be met (422).
class Findings {
 public:
  void Malformed(std::string pointer, std::string detail) {
    malformed_ = true;
    errors_.push_back({std::move(pointer), std::move(detail)});
  }
  void Unmeetable(std::string pointer, std::string detail) {
    errors_.push_back({std::move(pointer), std::move(detail)});
  }
  bool any() const { return !errors_.empty(); }
  bool full() const { return errors_.size() >= kMost; }
  void ThrowIfAny() const {
    if (errors_.empty()) return;
    Problem problem;
    problem.status = malformed_ ? 400 : 422;
    problem.detail = malformed_ ? "the clip request is malformed" : "the clip request cannot be met";
    problem.errors = errors_;
    throw ProblemError(std::move(problem));
  }

 private:
  static constexpr std::size_t kMost = 20;
  bool malformed_ = false;
  std::vector<FieldError> errors_;
};

// Typed access to the members of one object; whatever is not asked for is unknown.
class ObjectReader {
 public:
  ObjectReader(const json& object, std::string pointer, Findings* findings)
      : object_(object), pointer_(std::move(pointer)), findings_(findings) {}

  /// The member, or null when it is absent.
  const json* Take(std::string_view name) {
    known_.push_back(name);
    const auto found = object_.find(name);
    return found == object_.end() ? nullptr : &*found;
  }
  std::string At(std::string_view name) const { return PointerTo(pointer_, name); }

  std::optional<double> Finite(std::string_view name) {
    const json* value = Take(name);
    if (!value) return std::nullopt;
    if (!value->is_number()) {
      findings_->Malformed(At(name), std::string("must be a number, not ") + value->type_name());
      return std::nullopt;
    }
    return value->get<double>();  // the parser has refused numbers past a double's range
  }

  std::optional<std::string> Text(std::string_view name) {
    const json* value = Take(name);
    if (!value) return std::nullopt;
    if (!value->is_string()) {
      findings_->Malformed(At(name), std::string("must be a string, not ") + value->type_name());
      return std::nullopt;
    }
    const auto& text = value->get_ref<const std::string&>();
    if (text.empty() || text.size() > 200) {
      findings_->Malformed(At(name), "must have 1 to 200 bytes");
      return std::nullopt;
    }
    return text;
  }

  /// A nested object, or null when it is absent or not an object.
  const json* Object(std::string_view name) {
    const json* value = Take(name);
    if (value && !value->is_object()) {
      findings_->Malformed(At(name), std::string("must be an object, not ") + value->type_name());
      return nullptr;
    }
    return value;
  }

  /// Whatever was not taken is an error.
  void RefuseOthers(bool top_level) {
    for (const auto& item : object_.items()) {
      if (findings_->full()) return;
      if (std::find(known_.begin(), known_.end(), item.key()) != known_.end()) continue;
      const bool future =
          top_level && std::find(kFutureFields.begin(), kFutureFields.end(), item.key()) != kFutureFields.end();
      findings_->Malformed(At(item.key()), future ? "this field does not exist yet in this version" : "unknown field");
    }
  }

 private:
  const json& object_;
  std::string pointer_;
  Findings* findings_;
  std::vector<std::string_view> known_;
};

void ReadSeed(ObjectReader* reader, Findings* findings, ClipRequest* request) {
  const json* value = reader->Take("seed");
  if (!value) return;
  // 2^64 and above, fractions and exponents all arrive as floating point, -1 as a signed integer.
  if (!value->is_number_unsigned()) {
    findings->Malformed(reader->At("seed"), "must be an integer from 0 to 18446744073709551615");
    return;
  }
  request->seed = value->get<std::uint64_t>();
}

void ReadSteps(ObjectReader* reader, Findings* findings, ClipRequest* request) {
  const json* value = reader->Take("steps");
  if (!value) return;
  if (!value->is_number_integer()) {
    findings->Malformed(reader->At("steps"), "must be an integer");
    return;
  }
  // Clamped, since an int cannot hold every JSON integer; CheckClipRequest refuses both ends.
  constexpr int kTooMany = std::numeric_limits<int>::max();
  if (value->is_number_unsigned()) {
    const auto steps = value->get<std::uint64_t>();
    request->steps = steps > static_cast<std::uint64_t>(kTooMany) ? kTooMany : static_cast<int>(steps);
  } else {
    request->steps = 0;
  }
}

// "walking", "slow_step" or "standing".
WalkBoundary ReadBoundary(std::string_view name, ObjectReader* reader, Findings* findings) {
  const auto text = reader->Text(name);
  const auto boundary = text ? ParseWalkBoundary(*text) : WalkBoundary::kWalking;
  if (!boundary) findings->Malformed(reader->At(name), "must be \"walking\", \"slow_step\" or \"standing\"");
  return boundary.value_or(WalkBoundary::kWalking);
}

void ReadStart(const json& object, Findings* findings, ClipRequest* request) {
  ObjectReader reader(object, "/start", findings);
  if (const json* position = reader.Take("position")) {
    if (!position->is_array() || position->size() != 2 || !(*position)[0].is_number() || !(*position)[1].is_number()) {
      findings->Malformed("/start/position", "must be two numbers, [x, z] in metres");
    } else {
      for (int axis = 0; axis < 2; ++axis) request->start_position_m[axis] = (*position)[axis].get<double>();
    }
  }
  if (const auto heading = reader.Finite("heading")) request->start_heading_deg = *heading;
  request->start_from = ReadBoundary("from", &reader, findings);
  reader.RefuseOthers(/*top_level=*/false);
}

void ReadOutput(const json& object, Findings* findings, ClipRequest* request) {
  ObjectReader reader(object, "/output", findings);
  request->output.frame_rate_hz = reader.Finite("frame_rate");
  if (const auto channels = reader.Text("channels")) {
    if (*channels == "portable") {
      request->output.channels = OutputChannels::kPortable;
    } else if (*channels == "source") {
      request->output.channels = OutputChannels::kSource;
    } else {
      findings->Malformed("/output/channels", "must be \"portable\" or \"source\"");
    }
  }
  if (const auto unit = reader.Text("unit")) {
    if (*unit == "source") {
      request->output.unit = OutputUnit::kSource;
    } else if (*unit == "m") {
      request->output.unit = OutputUnit::kMetre;
    } else if (*unit == "cm") {
      request->output.unit = OutputUnit::kCentimetre;
    } else {
      findings->Malformed("/output/unit", "must be \"m\", \"cm\" or \"source\"");
    }
  }
  reader.RefuseOthers(/*top_level=*/false);
}

void CheckExtent(const ClipRequest& request, Findings* findings) {
  if (request.duration_s && request.steps) findings->Malformed("/steps", "give either \"duration\" or \"steps\"");
  if (request.duration_s) {
    if (!(*request.duration_s > 0)) {
      findings->Malformed("/duration", "must be above 0 seconds");
    } else if (*request.duration_s > kMaxDuration_s) {
      findings->Unmeetable("/duration", "at most " + Number(kMaxDuration_s) + " seconds can be made");
    }
  }
  if (request.steps) {
    if (*request.steps < 1) {
      findings->Malformed("/steps", "must be at least 1");
    } else if (*request.steps > kMaxSteps) {
      findings->Unmeetable("/steps", "at most " + std::to_string(kMaxSteps) + " steps can be made");
    }
  }
  if (request.output.frame_rate_hz) {
    if (!(*request.output.frame_rate_hz > 0)) {
      findings->Malformed("/output/frame_rate", "must be above 0 frames per second");
    } else if (*request.output.frame_rate_hz < kMinFrameRate_hz) {
      findings->Unmeetable("/output/frame_rate", "at least " + Number(kMinFrameRate_hz) + " frame per second");
    } else if (*request.output.frame_rate_hz > kMaxFrameRate_hz) {
      findings->Unmeetable("/output/frame_rate", "at most " + Number(kMaxFrameRate_hz) + " frames per second");
    }
  }
  if (findings->any()) return;
  // A step takes about half a second; a slow one stays below one.
  const double seconds = request.duration_s ? *request.duration_s : request.steps ? double{1.0 * *request.steps} : 5.0;
  const double rate_hz = request.output.frame_rate_hz.value_or(30);
  if (seconds * rate_hz > kMaxFrames) {
    findings->Unmeetable(request.duration_s ? "/duration" : "/steps",
                         "a clip has at most " + std::to_string(kMaxFrames) + " frames; at " + Number(rate_hz) +
                             " frames per second at most " + Number(std::floor(kMaxFrames / rate_hz)) + " seconds");
  }
}

void CheckStart(const ClipRequest& request, Findings* findings) {
  for (const double metres : request.start_position_m) {
    if (!(std::abs(metres) <= kMaxStartDistance_m)) {
      findings->Unmeetable("/start/position", "at most " + Number(kMaxStartDistance_m) + " m from the origin");
      break;
    }
  }
  if (!(std::abs(request.start_heading_deg) <= kMaxHeading_deg))
    findings->Unmeetable("/start/heading", "at most " + Number(kMaxHeading_deg) + " degrees either way");
}

void Check(const ClipRequest& request, const ClipRequestRules& rules, Findings* findings) {
  if (rules.model_required && request.model.empty() && !findings->any())
    findings->Malformed("/model", "required: the name of a model that is served");
  CheckExtent(request, findings);
  CheckStart(request, findings);
}

}  // namespace

ClipRequest ParseClipRequest(std::string_view text, const ClipRequestRules& rules) {
  const json body = ParseUntrustedJson(text);
  Findings findings;
  ClipRequest request;
  if (!body.is_object()) {
    findings.Malformed("", std::string("must be an object, not ") + body.type_name());
    findings.ThrowIfAny();
  }
  ObjectReader reader(body, "", &findings);
  request.model = reader.Text("model").value_or("");
  ReadSeed(&reader, &findings, &request);
  request.style = reader.Text("style");
  request.duration_s = reader.Finite("duration");
  ReadSteps(&reader, &findings, &request);
  if (const json* start = reader.Object("start")) ReadStart(*start, &findings, &request);
  request.end = ReadBoundary("end", &reader, &findings);
  if (const json* output = reader.Object("output")) ReadOutput(*output, &findings, &request);
  reader.RefuseOthers(/*top_level=*/true);
  Check(request, rules, &findings);
  findings.ThrowIfAny();
  return request;
}

void CheckClipRequest(const ClipRequest& request, const ClipRequestRules& rules) {
  Findings findings;
  Check(request, rules, &findings);
  findings.ThrowIfAny();
}

std::string CanonicalJson(const ClipRequest& request) {
  nlohmann::ordered_json out = nlohmann::ordered_json::object();
  if (!request.model.empty()) out["model"] = request.model;
  if (request.seed) out["seed"] = *request.seed;
  if (request.style) out["style"] = *request.style;
  if (request.duration_s) out["duration"] = *request.duration_s;
  if (request.steps) out["steps"] = *request.steps;
  const double* position_m = request.start_position_m;
  if (position_m[0] != 0 || position_m[1] != 0) out["start"]["position"] = {position_m[0], position_m[1]};
  if (request.start_heading_deg != 0) out["start"]["heading"] = request.start_heading_deg;
  if (request.start_from != WalkBoundary::kWalking) out["start"]["from"] = WalkBoundaryName(request.start_from);
  if (request.end != WalkBoundary::kWalking) out["end"] = WalkBoundaryName(request.end);
  if (request.output.frame_rate_hz) out["output"]["frame_rate"] = *request.output.frame_rate_hz;
  if (request.output.channels == OutputChannels::kSource) out["output"]["channels"] = "source";
  if (request.output.unit != OutputUnit::kSource)
    out["output"]["unit"] = request.output.unit == OutputUnit::kMetre ? "m" : "cm";
  return out.dump();
}

SynthesisRequest ToSynthesisRequest(const ClipRequest& request) {
  if (!request.seed) throw std::invalid_argument("ToSynthesisRequest: the request has no seed");
  SynthesisRequest out;
  out.seed = *request.seed;
  out.style = request.style;
  out.duration_s = request.duration_s;
  out.steps = request.steps;
  out.start.position_m = {request.start_position_m[0], request.start_position_m[1]};
  out.start.heading_rad = request.start_heading_deg * std::numbers::pi / 180.0;
  out.start_from = request.start_from;
  out.end = request.end;
  out.frame_rate_hz = request.output.frame_rate_hz;
  return out;
}

std::optional<std::uint64_t> ParseSeed(std::string_view text) {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (error != std::errc() || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return seed;  // from_chars takes no sign and no space for unsigned types
}

}  // namespace morphograph
