#include "api/clip_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "api/problem.h"

namespace morphograph {
namespace {

using ::testing::HasSubstr;

Problem ProblemOf(std::string_view json, const ClipRequestRules& rules = {}) {
  try {
    ParseClipRequest(json, rules);
  } catch (const ProblemError& error) {
    return error.problem();
  }
  ADD_FAILURE() << "was accepted: " << json;
  return {};
}

// The one error of a request, as "status pointer".
std::string Verdict(std::string_view json) {
  const Problem problem = ProblemOf(json);
  EXPECT_EQ(problem.errors.size(), 1u) << json;
  return std::to_string(problem.status) + " " + (problem.errors.empty() ? "" : problem.errors[0].pointer);
}

TEST(ClipRequest, NeedsNothingButAModel) {
  const ClipRequest request = ParseClipRequest(R"({"model":"walk"})");
  EXPECT_EQ(request.model, "walk");
  EXPECT_FALSE(request.seed || request.style || request.duration_s || request.steps || request.output.frame_rate_hz);
}

TEST(ClipRequest, ReadsEveryField) {
  const ClipRequest request = ParseClipRequest(R"({
    "model": "walk", "seed": 42, "style": "elderly", "duration": 8.0,
    "start": {"position": [1.5, -2], "heading": 90},
    "output": {"frame_rate": 60, "channels": "source", "unit": "cm"}})");
  EXPECT_EQ(request.seed, 42u);
  EXPECT_EQ(request.style, "elderly");
  EXPECT_EQ(request.duration_s, 8.0);
  EXPECT_EQ(request.output.channels, OutputChannels::kSource);
  EXPECT_EQ(request.output.unit, OutputUnit::kCentimetre);
  const SynthesisRequest synthesis = ToSynthesisRequest(request);
  EXPECT_EQ(synthesis.start.position_m, Eigen::Vector2d(1.5, -2));
  EXPECT_NEAR(synthesis.start.heading_rad, std::numbers::pi / 2, 1e-15);
  EXPECT_EQ(synthesis.frame_rate_hz, 60.0);
}

TEST(ClipRequest, ReadsWhatAClipBeginsOutOfAndEndsIn) {
  const ClipRequest plain = ParseClipRequest(R"({"model":"walk"})");
  EXPECT_EQ(plain.start_from, WalkBoundary::kWalking);
  EXPECT_EQ(plain.end, WalkBoundary::kWalking);
  const ClipRequest request = ParseClipRequest(R"({"model":"walk","seed":3,"start":{"from":"standing"},"end":"slow_step"})");
  EXPECT_EQ(ToSynthesisRequest(request).start_from, WalkBoundary::kStanding);
  EXPECT_EQ(ToSynthesisRequest(request).end, WalkBoundary::kSlowStep);
  EXPECT_EQ(CanonicalJson(request), R"({"model":"walk","seed":3,"start":{"from":"standing"},"end":"slow_step"})");
  // What is asked by default has the name (and so the address) that it always had.
  EXPECT_EQ(CanonicalJson(ParseClipRequest(R"({"model":"walk","start":{"from":"walking"},"end":"walking"})")), R"({"model":"walk"})");
  EXPECT_EQ(Verdict(R"({"model":"walk","start":{"from":"sitting"}})"), "400 /start/from");
  EXPECT_EQ(Verdict(R"({"model":"walk","start":{"from":true}})"), "400 /start/from");
  EXPECT_EQ(Verdict(R"({"model":"walk","end":{"heading":0}})"), "400 /end");
  EXPECT_EQ(Verdict(R"({"model":"walk","end":"Standing"})"), "400 /end");
}

TEST(ClipRequest, WhateverIsLetInCanBeMade) {
  // At every bound, and a hair inside and outside of it: the synthesiser has nothing to object to what was accepted.
  const auto accepted = [](const std::string& fields) {
    try {
      ClipRequest request = ParseClipRequest("{\"model\":\"walk\",\"seed\":1," + fields + "}");
      EXPECT_EQ(ToSynthesisRequest(request).FirstProblem(), std::nullopt) << fields;
      return true;
    } catch (const ProblemError&) {
      return false;
    }
  };
  const std::string position = "\"start\":{\"position\":[", rate = "\"duration\":1,\"output\":{\"frame_rate\":";
  EXPECT_TRUE(accepted("\"duration\":600"));
  EXPECT_FALSE(accepted("\"duration\":600.001"));
  EXPECT_TRUE(accepted("\"steps\":1000"));
  EXPECT_FALSE(accepted("\"steps\":1001"));
  EXPECT_TRUE(accepted(rate + "1}"));
  EXPECT_FALSE(accepted(rate + "0.999}"));
  EXPECT_TRUE(accepted(rate + "240}"));
  EXPECT_FALSE(accepted(rate + "240.1}"));
  EXPECT_TRUE(accepted(position + "10000,-10000]}"));
  EXPECT_FALSE(accepted(position + "10000.1,0]}"));
}

TEST(ClipRequest, TakesEverySeedOf64BitsWithoutLoss) {
  for (const std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{9007199254740993},  // 2^53 + 1: no double holds it
                                   std::uint64_t{9223372036854775808u}, ~std::uint64_t{0}}) {
    const std::string text = std::to_string(seed);
    EXPECT_EQ(ParseClipRequest(R"({"model":"walk","seed":)" + text + "}").seed, seed);
    EXPECT_EQ(ParseSeed(text), seed);
  }
}

TEST(ClipRequest, RefusesSeedsThatAreNotUnsigned64BitIntegers) {
  for (const char* seed : {"-1", "18446744073709551616", "1.5", "1e3", "1.0", "-0", "\"7\"", "null", "true", "[1]"})
    EXPECT_EQ(Verdict(std::string(R"({"model":"walk","seed":)") + seed + "}"), "400 /seed") << seed;
  for (const char* seed : {"", "-1", "+1", " 1", "1 ", "1.5", "1e3", "0x10", "18446744073709551616", "seven"})
    EXPECT_FALSE(ParseSeed(seed)) << seed;
}

TEST(ClipRequest, PointsAtTheFieldThatIsWrong) {
  EXPECT_EQ(Verdict("{}"), "400 /model");
  EXPECT_EQ(Verdict("[]"), "400 ");
  EXPECT_EQ(Verdict(R"({"model":7})"), "400 /model");
  EXPECT_EQ(Verdict(R"({"model":""})"), "400 /model");
  EXPECT_EQ(Verdict(R"({"model":"walk","style":null})"), "400 /style");
  EXPECT_EQ(Verdict(R"({"model":"walk","duration":"8"})"), "400 /duration");
  EXPECT_EQ(Verdict(R"({"model":"walk","duration":0})"), "400 /duration");
  EXPECT_EQ(Verdict(R"({"model":"walk","duration":-3})"), "400 /duration");
  EXPECT_EQ(Verdict(R"({"model":"walk","steps":2.5})"), "400 /steps");
  EXPECT_EQ(Verdict(R"({"model":"walk","steps":-7})"), "400 /steps");
  EXPECT_EQ(Verdict(R"({"model":"walk","steps":3,"duration":2})"), "400 /steps");
  EXPECT_EQ(Verdict(R"({"model":"walk","start":[0,0]})"), "400 /start");
  EXPECT_EQ(Verdict(R"({"model":"walk","start":{"position":[0]}})"), "400 /start/position");
  EXPECT_EQ(Verdict(R"({"model":"walk","start":{"position":[0,"1"]}})"), "400 /start/position");
  EXPECT_EQ(Verdict(R"({"model":"walk","start":{"heading":"north"}})"), "400 /start/heading");
  EXPECT_EQ(Verdict(R"({"model":"walk","output":{"unit":"feet"}})"), "400 /output/unit");
  EXPECT_EQ(Verdict(R"({"model":"walk","output":{"channels":""}})"), "400 /output/channels");
  EXPECT_EQ(Verdict(R"({"model":"walk","output":{"frame_rate":0}})"), "400 /output/frame_rate");
}

TEST(ClipRequest, RefusesUnknownFieldsAtEveryLevel) {
  EXPECT_EQ(Verdict(R"({"model":"walk","Seed":1})"), "400 /Seed");
  EXPECT_EQ(Verdict(R"({"model":"walk","start":{"facing":1}})"), "400 /start/facing");
  EXPECT_EQ(Verdict(R"({"model":"walk","output":{"fps":1}})"), "400 /output/fps");
  EXPECT_EQ(Verdict(R"({"model":"walk","a/b~c":1})"), "400 /a~1b~0c");
}

TEST(ClipRequest, SaysThatALaterFieldDoesNotExistYet) {
  for (const std::string field : {"markers", "input"}) {
    const Problem problem = ProblemOf(R"({"model":"walk",")" + field + R"(":{}})");
    EXPECT_EQ(problem.status, 400);
    ASSERT_EQ(problem.errors.size(), 1u);
    EXPECT_EQ(problem.errors[0].pointer, "/" + field);
    EXPECT_THAT(problem.errors[0].detail, HasSubstr("does not exist yet"));
  }
}

TEST(ClipRequest, NamesTheNearestValueThatCouldBeMet) {
  const Problem problem = ProblemOf(R"({"model":"walk","duration":1e6})");
  EXPECT_EQ(problem.status, 422);
  EXPECT_EQ(problem.errors.at(0).pointer, "/duration");
  EXPECT_THAT(problem.errors[0].detail, HasSubstr("at most 600"));
  EXPECT_EQ(Verdict(R"({"model":"walk","steps":1001})"), "422 /steps");
  EXPECT_EQ(Verdict(R"({"model":"walk","steps":18446744073709551615})"), "422 /steps");
  EXPECT_EQ(Verdict(R"({"model":"walk","output":{"frame_rate":241}})"), "422 /output/frame_rate");
  EXPECT_EQ(Verdict(R"({"model":"walk","output":{"frame_rate":0.5}})"), "422 /output/frame_rate");
  EXPECT_EQ(Verdict(R"({"model":"walk","duration":600,"output":{"frame_rate":240}})"), "422 /duration");
  EXPECT_EQ(Verdict(R"({"model":"walk","start":{"position":[1e9,0]}})"), "422 /start/position");
}

TEST(ClipRequest, ReportsAllThatIsWrongAtOnce) {
  const Problem problem = ProblemOf(R"({"seed":-1,"steps":"2","colour":"red"})");
  EXPECT_EQ(problem.errors.size(), 3u);
}

TEST(ClipRequest, KeepsTheAnswerShortWhateverWasSent) {
  std::string body = R"({"model":"walk")";
  for (int i = 0; i < 5000; ++i) body += ",\"" + std::to_string(i) + std::string(100, 'x') + "\":0";
  const Problem problem = ProblemOf(body + "}");
  EXPECT_LE(problem.errors.size(), 20u);
  EXPECT_LE(ProblemJson(problem).size(), 4096u);
}

TEST(ClipRequest, CanonicalJsonReadsBackTheSame) {
  const std::string spaced = R"( {"output":{"unit":"m","frame_rate":29.97}, "seed":18446744073709551615,
      "start":{"heading":0.1,"position":[0,1e-3]}, "duration":3, "model":"walk", "style":"proud"} )";
  const ClipRequest request = ParseClipRequest(spaced);
  const std::string canonical = CanonicalJson(request);
  EXPECT_EQ(canonical, R"({"model":"walk","seed":18446744073709551615,"style":"proud","duration":3.0,)"
                       R"("start":{"position":[0.0,0.001],"heading":0.1},"output":{"frame_rate":29.97,"unit":"m"}})");
  EXPECT_EQ(CanonicalJson(ParseClipRequest(canonical)), canonical);
}

TEST(ClipRequest, NamesAnAction) {
  const ClipRequest request = ParseClipRequest(R"({"model":"walk","seed":3,"action":"run","style":"proud"})");
  EXPECT_EQ(ToSynthesisRequest(request).action, "run");
  EXPECT_EQ(CanonicalJson(request), R"({"model":"walk","seed":3,"action":"run","style":"proud"})");
  EXPECT_EQ(ToSynthesisRequest(ParseClipRequest(R"({"model":"walk","seed":3})")).action, std::nullopt);
  EXPECT_EQ(Verdict(R"({"model":"walk","action":7})"), "400 /action");
  EXPECT_EQ(Verdict(R"({"model":"walk","action":""})"), "400 /action");
}

TEST(ClipRequest, NamesActionsOneAfterTheOther) {
  const std::string text = R"({"model":"walk","seed":3,"actions":[{"action":"walk","until":2.5},{"action":"run","until":3.5},{"action":"walk"}]})";
  const ClipRequest request = ParseClipRequest(text);
  EXPECT_EQ(CanonicalJson(request), text);
  const SynthesisRequest asked = ToSynthesisRequest(request);
  EXPECT_EQ(asked.action, "walk");
  ASSERT_EQ(asked.changes.size(), 2u);
  EXPECT_EQ(asked.changes[0].action, "run");
  EXPECT_EQ(asked.changes[0].at_s, 2.5);
  EXPECT_EQ(asked.changes[1].at_s, 3.5);
  const auto verdict = [](const std::string& actions, const std::string& more = "") {
    return Verdict(R"({"model":"walk",)" + more + R"("actions":)" + actions + "}");
  };
  EXPECT_EQ(verdict(R"([{"action":"walk"}])"), "400 /actions");
  EXPECT_EQ(verdict(R"([{"action":"walk","until":2},{"action":"run"}])", R"("action":"run",)"), "400 /actions");
  EXPECT_EQ(verdict(R"([{"action":"walk"},{"action":"run"}])"), "400 /actions/0/until");
  EXPECT_EQ(verdict(R"([{"action":"walk","until":0},{"action":"run"}])"), "400 /actions/0/until");
  EXPECT_EQ(verdict(R"([{"action":"walk","until":2},{"action":"run","until":3}])"), "400 /actions/1/until");
  EXPECT_EQ(verdict(R"([{"action":"walk","until":2},{"action":"run","until":2},{"action":"walk"}])"), "400 /actions/1/until");
  EXPECT_EQ(verdict(R"([{"action":"walk","until":2},{"action":"walk"}])"), "400 /actions/1/action");
  EXPECT_EQ(verdict(R"([{"action":"walk","until":2,"at":3},{"action":"run"}])"), "400 /actions/0/at");
  EXPECT_EQ(verdict(R"([3,{"action":"run"}])"), "400 /actions/0");
  EXPECT_EQ(verdict(R"([{"action":"walk","until":5},{"action":"run"}])"), "422 /actions/0/until");
  EXPECT_EQ(verdict(R"([{"action":"walk","until":2},{"action":"run"}])", R"("steps":9,)"), "422 /steps");
  EXPECT_EQ(verdict(R"([{"action":"walk","until":2},{"action":"run"}])", R"("goal":{"position":[0,4]},)"), "422 /actions");
}

TEST(ClipRequest, ModelMayBeLeftOutWhereTheCallerHasOne) {
  EXPECT_NO_THROW(ParseClipRequest(R"({"steps":2})", {.model_required = false}));
}

}  // namespace
}  // namespace morphograph
