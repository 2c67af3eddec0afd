#include "api/clip_request.h"

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "api/json_guard.h"
#include "api/request/control_checks.h"
#include "api/request/control_reader.h"
#include "api/request/control_writer.h"
#include "api/request/output_reader.h"

namespace morphograph {
namespace {

using nlohmann::json;

constexpr double kMaxHeading_deg = 1e6;
constexpr std::size_t kMaxActions = 100;

// Fields of the contract that come with later releases.
const std::vector<std::string_view> kFutureFields = {"markers", "input"};

void ReadSeed(ObjectReader* reader, ClipRequest* request) {
  const json* value = reader->Take("seed");
  if (!value) return;
  // 2^64 and above, fractions and exponents all arrive as floating point, -1 as a signed integer.
  if (!value->is_number_unsigned()) {
    reader->findings()->Malformed(reader->At("seed"), "must be an integer from 0 to 18446744073709551615");
    return;
  }
  request->seed = value->get<std::uint64_t>();
}

// [{"action": "walk", "until": 3}, {"action": "run"}]: all but the last say until when.
void ReadActions(ObjectReader* reader, Findings* findings, ClipRequest* request) {
  const json* list = reader->List("actions", 2, kMaxActions, "actions");
  if (!list) return;
  if (request->action) findings->Malformed("/actions", "give either \"action\" or \"actions\"");
  double from_s = 0;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const std::string pointer = "/actions/" + std::to_string(i);
    if (!(*list)[i].is_object()) {
      findings->Malformed(pointer, "must be an object, not " + std::string((*list)[i].type_name()));
      continue;
    }
    ObjectReader part((*list)[i], pointer, findings);
    const auto action = part.Required("action", part.Text("action"), "one of the model's actions");
    const bool last = i + 1 == list->size();
    const std::optional<double> until_s = part.Finite("until");
    if (last && part.Has("until")) findings->Malformed(pointer + "/until", "the last action goes on to the clip's end");
    if (!last) part.Required("until", until_s, "seconds from the clip's start at which the next action begins");
    part.RefuseOthers();
    const std::string& before = request->changes.empty() ? request->action.value_or("") : request->changes.back().action;
    if (i > 0 && action && *action == before) findings->Malformed(pointer + "/action", "must be another one than the one before it");
    if (i == 0) {
      request->action = action;
    } else {
      request->changes.push_back({from_s, action.value_or("")});
    }
    if (!last && until_s && !(*until_s > from_s)) {
      findings->Malformed(pointer + "/until", i == 0 ? "must be above 0 seconds" : "must be after the \"until\" of the one before it");
    }
    from_s = until_s.value_or(from_s);
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
  request->start_position_m = reader.FloorPoint("position");
  request->start_heading_deg = reader.Finite("heading");
  request->start_from = ReadBoundary("from", &reader, findings);
  reader.RefuseOthers();
}

// How long a clip will be, roughly where that is not said: at an easy walk along the way that is asked for.
double ExpectedDuration_s(const ClipRequest& request) {
  if (request.duration_s) return *request.duration_s;
  if (request.steps) return *request.steps;
  const ControlTerms& control = request.control;
  if (control.goal && control.goal->time_s) return *control.goal->time_s;
  if (control.sensors && control.sensors->readings.times_s.size() >= 2) return control.sensors->readings.times_s.back() - control.sensors->readings.times_s.front();
  double way_m = 0;
  if (control.path) {
    way_m = LineLength(control.path->points_m);
  } else if (control.goal) {
    way_m = (control.goal->position_m - request.start_position_m.value_or(Eigen::Vector2d::Zero())).norm();
  }
  return std::max(5.0, way_m / 1.3);
}

void CheckExtent(const ClipRequest& request, Findings* findings) {
  if (request.duration_s && request.steps) findings->Malformed("/steps", "give either \"duration\" or \"steps\"");
  if (request.duration_s) {
    if (!(*request.duration_s > 0)) {
      findings->Malformed("/duration", "must be above 0 seconds");
    } else if (*request.duration_s > kMaxDuration_s) {
      findings->Unmeetable("/duration", "at most " + NumberText(kMaxDuration_s) + " seconds can be made");
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
      findings->Unmeetable("/output/frame_rate", "at least " + NumberText(kMinFrameRate_hz) + " frame per second");
    } else if (*request.output.frame_rate_hz > kMaxFrameRate_hz) {
      findings->Unmeetable("/output/frame_rate", "at most " + NumberText(kMaxFrameRate_hz) + " frames per second");
    }
  }
  if (findings->any()) return;
  // A step takes about half a second; a slow one stays below one.
  const double seconds = ExpectedDuration_s(request);
  const double rate_hz = request.output.frame_rate_hz.value_or(30);
  if (seconds * rate_hz > kMaxFrames) {
    const bool by_readings = request.control.sensors && !(request.control.goal && request.control.goal->time_s);
    const bool by_way = !request.duration_s && !request.steps && !by_readings;
    findings->Unmeetable(request.duration_s ? "/duration" : request.steps ? "/steps" : by_readings ? "/sensors/readings" : request.control.path ? "/path/points" : "/goal",
                         "a clip has at most " + std::to_string(kMaxFrames) + " frames; at " + NumberText(rate_hz) +
                             " frames per second at most " + NumberText(std::floor(kMaxFrames / rate_hz)) + " seconds" +
                             (by_way ? ", and this way takes about " + NumberText(std::round(seconds)) : ""));
  }
}

void CheckStart(const ClipRequest& request, Findings* findings) {
  // Again, since command line flags come here without a reader.
  if (request.start_position_m && !(request.start_position_m->cwiseAbs().maxCoeff() <= kMaxStartDistance_m))
    findings->Unmeetable("/start/position", "at most " + NumberText(kMaxStartDistance_m) + " m from the origin");
  if (!(std::abs(request.start_heading_deg.value_or(0)) <= kMaxHeading_deg))
    findings->Unmeetable("/start/heading", "at most " + NumberText(kMaxHeading_deg) + " degrees either way");
}

// A change of action against what else is asked for.
void CheckActions(const ClipRequest& request, Findings* findings) {
  if (request.changes.empty()) return;
  if (request.steps) findings->Unmeetable("/steps", "a clip that changes its action has a duration, not a number of steps");
  if (!request.control.empty()) {
    findings->Unmeetable("/actions", "a clip that changes its action cannot be told where to go or what to do on its way");
  }
  const double duration_s = request.duration_s.value_or(kDefaultDuration_s);
  for (std::size_t i = 0; i < request.changes.size(); ++i) {
    if (request.changes[i].at_s < duration_s) continue;
    findings->Unmeetable("/actions/" + std::to_string(i) + "/until", "the clip is over after " + NumberText(duration_s) + " seconds");
  }
}

void Check(const ClipRequest& request, const ClipRequestRules& rules, Findings* findings) {
  if (rules.model_required && request.model.empty() && !findings->any())
    findings->Malformed("/model", "required: the name of a model that is served");
  CheckExtent(request, findings);
  CheckStart(request, findings);
  CheckActions(request, findings);
  if (findings->any()) return;  // of a malformed request nothing more can be said
  ClipExtent extent{request.duration_s, request.steps, request.start_position_m};
  if (!extent.start_m && !request.control.path) extent.start_m = Eigen::Vector2d::Zero();
  CheckControlTerms(request.control, extent, findings);
}

ClipRequest ParseFields(std::string_view text, const ClipRequestRules& rules, int* count) {
  const json body = ParseUntrustedJson(text);
  Findings findings;
  ClipRequest request;
  if (!body.is_object()) {
    findings.Malformed("", std::string("must be an object, not ") + body.type_name());
    findings.ThrowIfAny();
  }
  ObjectReader reader(body, "", &findings);
  request.model = reader.Text("model").value_or("");
  ReadSeed(&reader, &request);
  request.action = reader.Text("action");
  ReadActions(&reader, &findings, &request);
  request.style = reader.Text("style");
  request.duration_s = reader.Finite("duration");
  request.steps = reader.Whole("steps", 1, kMaxSteps);
  if (const json* start = reader.Object("start")) ReadStart(*start, &findings, &request);
  request.end = ReadBoundary("end", &reader, &findings);
  ReadControlTerms(&reader, &request.control);
  if (const json* output = reader.Object("output")) request.output = ReadOutputFormat(*output, &findings);
  if (count) {
    const auto asked = reader.Required("count", reader.Whole("count", 1, kMaxVariants), "how many variants");
    *count = asked.value_or(1);
  } else if (reader.Take("count")) {
    findings.Malformed("/count", "belongs to POST /v1/variants; here one clip is made");
  }
  reader.RefuseOthers(kFutureFields);
  Check(request, rules, &findings);
  findings.ThrowIfAny();
  return request;
}

}  // namespace

ClipRequest ParseClipRequest(std::string_view text, const ClipRequestRules& rules) { return ParseFields(text, rules, nullptr); }

VariantsRequest ParseVariantsRequest(std::string_view text) {
  VariantsRequest request;
  request.clip = ParseFields(text, {}, &request.count);
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
  if (request.action && request.changes.empty()) out["action"] = *request.action;
  if (!request.changes.empty()) {
    auto& actions = out["actions"];
    actions.push_back({{"action", request.action.value_or("")}});
    for (const ActionFrom& change : request.changes) {
      actions.back()["until"] = change.at_s;
      actions.push_back({{"action", change.action}});
    }
  }
  if (request.style) out["style"] = *request.style;
  if (request.duration_s) out["duration"] = *request.duration_s;
  if (request.steps) out["steps"] = *request.steps;
  // Where there is a way to go, a start that is given is not the same as one left open, even at 0.
  const bool has_way = request.control.path || request.control.goal;
  const auto position_m = request.start_position_m;
  if (position_m && (has_way || *position_m != Eigen::Vector2d::Zero())) out["start"]["position"] = {position_m->x(), position_m->y()};
  if (const auto heading_deg = request.start_heading_deg; heading_deg && (has_way || *heading_deg != 0)) out["start"]["heading"] = *heading_deg;
  if (request.start_from != WalkBoundary::kWalking) out["start"]["from"] = WalkBoundaryName(request.start_from);
  if (request.end != WalkBoundary::kWalking) out["end"] = WalkBoundaryName(request.end);
  WriteControlTerms(request.control, &out);
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
  out.action = request.action;
  out.changes = request.changes;
  out.style = request.style;
  out.duration_s = request.duration_s;
  out.steps = request.steps;
  out.start.position_m = request.start_position_m.value_or(Eigen::Vector2d::Zero());
  out.start.heading_rad = request.start_heading_deg.value_or(0) * std::numbers::pi / 180.0;
  out.start_given = {.position = request.start_position_m.has_value(), .heading = request.start_heading_deg.has_value()};
  out.start_from = request.start_from;
  out.end = request.end;
  out.control = request.control;
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
