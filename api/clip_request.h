#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "synthesis/synthesis_types.h"

namespace morphograph {

enum class OutputChannels { kPortable, kSource };
enum class OutputUnit { kSource, kMetre, kCentimetre };

/// How a clip is to be written.
struct OutputFormat {
  std::optional<double> frame_rate_hz;  // the model's own when empty
  OutputChannels channels = OutputChannels::kPortable;
  OutputUnit unit = OutputUnit::kSource;
};

/// A clip request (CONTRACT.md, "Clip request") as the client wrote it: metres, seconds, and degrees but for `control`.
struct ClipRequest {
  std::string model;  // empty only where the caller has one already
  std::optional<std::uint64_t> seed;
  std::optional<std::string> action;  // the model's own when empty; of a clip that changes its action, the first
  std::vector<ActionFrom> changes;    // "actions" but for the first: each from where the one before it is over
  std::optional<std::string> style;
  std::optional<double> duration_s;
  std::optional<int> steps;
  std::optional<Eigen::Vector2d> start_position_m;  // x, z; the origin, or with a path its first point, when empty
  std::optional<double> start_heading_deg;          // 0, or with a path or a goal along the way, when empty
  WalkBoundary start_from = WalkBoundary::kWalking;
  WalkBoundary end = WalkBoundary::kWalking;
  ControlTerms control;  // radians, as the synthesiser takes them
  OutputFormat output;
};

/// Longest clip served, in frames at whatever rate was asked for; other bounds are the synthesiser's (synthesis_types.h).
inline constexpr int kMaxFrames = 40'000;

/// Most variants of one request.
inline constexpr int kMaxVariants = 1000;

struct ClipRequestRules {
  bool model_required = true;  // false where a model is given by other means
};

/// Parses and checks a clip request.
///
/// All fields that are wrong are reported at once, each with its JSON pointer.
/// @throws ProblemError: 400 when malformed (not JSON, unknown field, wrong type), 422 when well formed but outside
///   what can be made, with the nearest value that could.
ClipRequest ParseClipRequest(std::string_view json, const ClipRequestRules& rules = {});

/// A request for variants: a clip request with "count".
struct VariantsRequest {
  ClipRequest clip;
  int count = 1;  // 1 to kMaxVariants
};

/// As ParseClipRequest(), which takes no "count".
VariantsRequest ParseVariantsRequest(std::string_view json);

/// The same checks on a request that was put together otherwise (command line flags).
void CheckClipRequest(const ClipRequest& request, const ClipRequestRules& rules = {});

/// The request as one line of JSON: fixed field order, no spaces, defaults left out, shortest numbers that read
/// back the same. Parsing it gives the request again.
std::string CanonicalJson(const ClipRequest& request);

/// What the synthesiser is asked; `request.seed` must be set.
SynthesisRequest ToSynthesisRequest(const ClipRequest& request);

/// A seed as text: digits of a 64-bit unsigned integer and nothing else. Empty when it is anything else.
std::optional<std::uint64_t> ParseSeed(std::string_view text);

}  // namespace morphograph
