// POST /v1/variants
#include <memory>

#include "api/clip_response.h"
#include "api/content_negotiation.h"
#include "api/internal/limited_places.h"
#include "api/problem.h"
#include "api/routes.h"
#include "api/routes/request_parts.h"
#include "api/variants_response.h"

namespace morphograph {
namespace {

constexpr const char* kNdjson = "application/x-ndjson";
// Sets of clips, each up to VariantOptions::max_joint_frames.
internal::LimitedPlaces set_places(2, "other variants are being made; try again");

[[noreturn]] void RefuseStopped(LongWork::Stop reason) {
  if (reason == LongWork::Stop::kLate)
    throw ProblemError(Problem{503, "making these variants takes too long; ask for fewer at a time", {}, 5, {}});
  throw ProblemError(Problem{503, "the server stops", {}, 5, {}});  // or the client has gone, and nobody reads this
}

HttpResponse CreateVariants(Service* service, const HttpRequest& request) {
  if (ChooseMediaType(request.Header("Accept"), {kNdjson, "application/jsonl", "application/json"}) < 0)
    throw ProblemError(406, "variants are given as application/x-ndjson");
  const VariantsRequest asked = ParseVariantsRequest(ClipRequestText(request));
  const std::shared_ptr<const ServedModel> model = FindServed(service->models, asked.clip.model);
  ClipRequest clip = asked.clip;
  if (!clip.seed) clip.seed = DrawSeed();

  struct Answer {
    internal::LimitedPlaces::Place place{&set_places};
    VariantSet set;
    std::size_t at = 0;
  };
  const auto answer = std::make_shared<Answer>();
  VariantOptions options;
  options.count = asked.count;
  if (LongWork* work = request.work) {
    options.threads = work->workers();
    options.begin = [work](int worker) { return work->TakeTurn(worker); };
    options.end = [work](int worker) { work->EndTurn(worker); };
  }
  try {
    options.sensor_steps = SensorStepsOf(service, *model);
    answer->set = MakeVariants(*model->graph, ToSynthesisRequest(clip), options);
  } catch (const VariantsTooLarge& large) {
    throw ProblemError(Problem{422, "the request cannot be met", {{"/count", large.what()}}, {}, {}});
  } catch (const VariantsCancelled&) {
    RefuseStopped(request.work->stop());
  }
  for (ClipVariant& variant : answer->set.variants) variant.report.model_name = model->name;

  HttpResponse response;
  response.Set("Content-Type", kNdjson);
  response.Set("Cache-Control", "no-store");
  response.Set("Morphograph-Seed", std::to_string(*clip.seed));
  response.Set("Morphograph-Model", model->graph->hash());
  response.more = [answer, output = clip.output]() -> std::string {
    auto& [place, set, at] = *answer;
    if (at > set.variants.size()) return {};
    if (at == set.variants.size()) return ++at, "{\"summary\":" + VariantSummaryJson(set.summary) + "}\n";
    const std::string line = VariantLine(set.variants[at], output) + "\n";
    set.variants[at++] = {};  // its memory is free again
    return line;
  };
  return response;
}

}  // namespace

std::vector<Route> VariantRoutes(Service* service) {
  return {{"POST", "/v1/variants", [=](const HttpRequest& request) { return CreateVariants(service, request); }, kMaxClipRequestBytes}};
}

}  // namespace morphograph
