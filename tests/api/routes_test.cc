// The whole interface over real sockets, with a model learned from synthetic walks.
#include "api/routes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "api/openapi.h"
#include "datasets/bvh_reader.h"
#include "tests/datasets/bvh_test_files.h"
#include "tests/support/raw_http.h"
#include "tests/support/small_model.h"
#include "tests/support/test_service.h"

namespace morphograph {
namespace {

using nlohmann::json;
using testing::Ask;
using testing::RawResponse;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class RoutesTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    app_ = new testing::TestService;
    app_->service.models.Add("walk", testing::SmallModel());
    app_->Start();
  }
  static void TearDownTestSuite() { delete app_; }
  // Whatever a test did, the server still makes clips.
  void TearDown() override { EXPECT_EQ(Post(R"({"model":"walk","seed":1,"steps":3})").status, 200); }

  static RawResponse Post(const std::string& body, const std::string& headers = "Content-Type: application/json\r\n") {
    return Ask(app_->port, "POST", "/v1/clips", headers, body);
  }
  static RawResponse Get(const std::string& path, const std::string& headers = "") {
    return Ask(app_->port, "GET", path, headers);
  }
  static void ExpectProblem(const RawResponse& response, int status) {
    EXPECT_EQ(response.status, status) << response.body;
    EXPECT_EQ(response.headers.at("content-type"), "application/problem+json");
    const json problem = json::parse(response.body);
    EXPECT_EQ(problem["status"], status);
    EXPECT_FALSE(problem["title"].get<std::string>().empty());
    EXPECT_FALSE(problem["detail"].get<std::string>().empty());
  }
  static std::string Pointer(const RawResponse& response) {
    return json::parse(response.body).at("errors").at(0).at("pointer");
  }

  static testing::TestService* app_;
};
testing::TestService* RoutesTest::app_ = nullptr;

TEST_F(RoutesTest, AClipIsABvhOfTheModelsSkeleton) {
  const RawResponse response = Post(R"({"model":"walk","seed":42,"duration":4})");
  ASSERT_EQ(response.status, 200) << response.body;
  EXPECT_EQ(response.headers.at("content-type"), "text/plain; charset=utf-8");
  EXPECT_EQ(response.headers.at("content-disposition"), "attachment; filename=\"walk-42.bvh\"");
  EXPECT_EQ(response.headers.at("morphograph-seed"), "42");
  EXPECT_EQ(response.headers.at("morphograph-model"), testing::SmallModel()->hash());
  const BvhDocument bvh = ParseBvh(response.body, "answer");
  EXPECT_EQ(bvh.nodes.size(), static_cast<std::size_t>(testing::SmallModel()->skeleton().joint_count()));
  EXPECT_NEAR((bvh.frame_count() - 1) * bvh.frame_time_s, 4.0, 0.05);
  EXPECT_EQ(bvh.nodes[0].channels.size(), 6u);
}

TEST_F(RoutesTest, TheSameRequestGivesTheSameBytesAndName) {
  const RawResponse first = Post(R"({"model":"walk","seed":7,"steps":6,"style":"slow"})");
  const RawResponse again = Post(R"({ "style":"slow", "steps":6, "seed":7, "model":"walk" })");
  EXPECT_EQ(first.body, again.body);
  EXPECT_EQ(first.headers.at("etag"), again.headers.at("etag"));
  EXPECT_EQ(first.headers.at("location"), again.headers.at("location"));
  EXPECT_NE(first.body, Post(R"({"model":"walk","seed":8,"steps":6,"style":"slow"})").body);
}

TEST_F(RoutesTest, ManyClientsAtOnceGetTheSameBytes) {
  const std::string request = R"({"model":"walk","seed":11,"duration":3})";
  const std::string expected = Post(request).body;
  std::vector<std::thread> clients;
  std::atomic<int> same{0};
  for (int i = 0; i < 8; ++i)
    clients.emplace_back([&] { for (int k = 0; k < 3; ++k) same += Post(request).body == expected; });
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(same, 24);
}

TEST_F(RoutesTest, AClipWithoutSeedCanBeHadAgainBySeedAndByLocation) {
  const RawResponse drawn = Post(R"({"model":"walk","steps":4})");
  ASSERT_EQ(drawn.status, 200);
  const std::string seed = drawn.headers.at("morphograph-seed");
  EXPECT_EQ(Post(R"({"model":"walk","steps":4,"seed":)" + seed + "}").body, drawn.body);
  EXPECT_EQ(Get(drawn.headers.at("location")).body, drawn.body);
  EXPECT_NE(Post(R"({"model":"walk","steps":4})").headers.at("morphograph-seed"), seed);
}

TEST_F(RoutesTest, LargeSeedsAreEchoedToTheLastDigit) {
  const RawResponse response = Post(R"({"model":"walk","steps":2,"seed":18446744073709551615})", "Accept: application/json\r\n");
  EXPECT_EQ(response.headers.at("morphograph-seed"), "18446744073709551615");
  EXPECT_THAT(response.body, HasSubstr("\"seed\":18446744073709551615"));
}

TEST_F(RoutesTest, TheReportHasTheFieldsOfTheContract) {
  const RawResponse response = Post(R"({"model":"walk","seed":3,"duration":5,"style":"brisk"})", "Accept: application/json\r\n");
  ASSERT_EQ(response.status, 200) << response.body;
  const json answer = json::parse(response.body);
  const json& report = answer.at("report");
  EXPECT_EQ(report["seed"], 3);
  EXPECT_EQ(report["style"], "brisk");
  EXPECT_EQ(report["model"]["name"], "walk");
  EXPECT_EQ(report["model"]["hash"], testing::SmallModel()->hash());
  const int frames = report["frames"];
  EXPECT_EQ(report["path"].size(), static_cast<std::size_t>(frames));
  EXPECT_EQ(ParseBvh(answer["bvh"].get<std::string>(), "bvh").frame_count(), frames);
  EXPECT_GT(report["steps"].size(), 4u);
  EXPECT_GT(report["contacts"].size(), 4u);
  EXPECT_TRUE(report["constraints"].empty());
  for (const char* measure : {"contact_distance", "foot_skate_cm_s", "penetration", "naturalness", "log_likelihood"})
    EXPECT_TRUE(report["quality"][measure].is_number()) << measure;
  const RawResponse again = Get(response.headers.at("location") + "/report");
  EXPECT_EQ(json::parse(again.body), report);
}

TEST_F(RoutesTest, StartAndOutputAreObeyed) {
  const RawResponse response = Post(
      R"({"model":"walk","seed":3,"steps":4,"start":{"position":[2,-1],"heading":90},
          "output":{"unit":"m","frame_rate":60}})");
  ASSERT_EQ(response.status, 200) << response.body;
  const BvhDocument bvh = ParseBvh(response.body, "answer");
  EXPECT_NEAR(bvh.frame_time_s, 1.0 / 60, 1e-6);
  EXPECT_NEAR(bvh.values(0, 0), 2, 0.05);
  EXPECT_NEAR(bvh.values(2, 0), -1, 0.05);
  const int last = bvh.frame_count() - 1;
  EXPECT_GT(bvh.values(0, last) - 2, 5 * std::abs(bvh.values(2, last) + 1));  // walks towards +X
  const RawResponse centimetres = Post(R"({"model":"walk","seed":3,"steps":4,"output":{"unit":"cm"}})");
  EXPECT_NEAR(ParseBvh(centimetres.body, "cm").values(1, 0), 95, 25);  // a hip's height
}

TEST_F(RoutesTest, AnswersNotModifiedToWhoHasTheClip) {
  const RawResponse made = Post(R"({"model":"walk","seed":5,"steps":3})");
  const std::string location = made.headers.at("location");
  const RawResponse unchanged = Get(location, "If-None-Match: " + made.headers.at("etag") + "\r\n");
  EXPECT_EQ(unchanged.status, 304);
  EXPECT_EQ(unchanged.body, "");
  EXPECT_EQ(Get(location, "If-None-Match: \"other\"\r\n").status, 200);
  // Another form of the clip has another tag.
  EXPECT_EQ(Get(location, "Accept: application/json\r\nIf-None-Match: " + made.headers.at("etag") + "\r\n").status, 200);
}

TEST_F(RoutesTest, NegotiatesTheForm) {
  const std::string request = R"({"model":"walk","seed":5,"steps":3})";
  EXPECT_THAT(Post(request, "Accept: model/gltf-binary\r\n").body, StartsWith("glTF"));
  EXPECT_THAT(Post(request, "Accept: text/html, */*;q=0.1\r\n").body, StartsWith("HIERARCHY"));
  ExpectProblem(Post(request, "Accept: image/png\r\n"), 406);
  ExpectProblem(Post(request, "Content-Type: text/xml\r\n"), 415);
  ExpectProblem(Post(request, "Content-Type: application/x-www-form-urlencoded\r\n"), 415);
  EXPECT_EQ(Post(request, "Content-Type: application/json; charset=utf-8\r\n").status, 200);
}

TEST_F(RoutesTest, BadRequestsSayWhatIsWrong) {
  ExpectProblem(Post(""), 400);
  ExpectProblem(Post("{\"model\":\"wa"), 400);
  ExpectProblem(Post("[]"), 400);
  ExpectProblem(Post(std::string(10'000, '[') + std::string(10'000, ']')), 400);
  for (const auto& [body, pointer] :
       std::map<std::string, std::string>{{R"({"model":"walk","seed":-1})", "/seed"},
                                          {R"({"model":"walk","seed":18446744073709551616})", "/seed"},
                                          {R"({"model":"walk","duration":"long"})", "/duration"},
                                          {R"({"model":"walk","colour":"red"})", "/colour"},
                                          {R"({"model":"walk","sensors":{"rate":60}})", "/sensors/placements"}}) {
    const RawResponse response = Post(body);
    ExpectProblem(response, 400);
    EXPECT_EQ(Pointer(response), pointer);
  }
}

TEST_F(RoutesTest, UnknownThingsAre404) {
  const RawResponse model = Post(R"({"model":"dance"})");
  ExpectProblem(model, 404);
  EXPECT_EQ(Pointer(model), "/model");
  EXPECT_THAT(model.body, HasSubstr("walk"));  // says what is served
  ExpectProblem(Get("/v1/clips/0123456789abcdef"), 404);
  ExpectProblem(Get("/v1/models/dance"), 404);
  ExpectProblem(Get("/v1/models/dance/graph"), 404);
  ExpectProblem(Get("/v2/clips"), 404);
  ExpectProblem(Get("/v1/jobs/1"), 404);
  ExpectProblem(Ask(app_->port, "PUT", "/v1/clips"), 405);
  ExpectProblem(Get("/v1/clips"), 405);
}

TEST_F(RoutesTest, WhatCannotBeMetIs422AndNamesWhatCould) {
  const RawResponse style = Post(R"({"model":"walk","style":"moonwalk"})");
  ExpectProblem(style, 422);
  EXPECT_EQ(Pointer(style), "/style");
  EXPECT_THAT(style.body, HasSubstr("brisk"));
  const RawResponse length = Post(R"({"model":"walk","duration":601})");
  ExpectProblem(length, 422);
  EXPECT_THAT(length.body, HasSubstr("600"));
}

TEST_F(RoutesTest, AClipGoesWhereItIsAskedTo) {
  const RawResponse made = Post(
      R"({"model":"walk","seed":3,"style":"brisk","path":{"points":[[1,1],[1,5]],"tolerance":0.2},
          "constraints":[{"type":"keep_out","circle":{"center":[4,3],"radius":0.5}}]})",
      "Accept: application/json\r\n");
  ASSERT_EQ(made.status, 200) << made.body;
  const json report = json::parse(made.body)["report"];
  EXPECT_NEAR(report["path"].front()[0], 1, 0.25);
  EXPECT_NEAR(report["path"].back()[1], 5, 0.3);
  std::set<std::string> pointers;
  for (const json& outcome : report["constraints"]) {
    EXPECT_EQ(outcome["met"], true) << outcome;
    EXPECT_LE(outcome["residual"], outcome["tolerance"]) << outcome;
    pointers.insert(outcome["pointer"]);
  }
  EXPECT_THAT(pointers, ::testing::IsSupersetOf({"/path", "/constraints/0"}));
  EXPECT_EQ(report["constraints"].back()["index"], 0);
  const json schemas = json::parse(OpenApiJson())["components"]["schemas"];
  for (const json& outcome : report["constraints"]) {
    for (const auto& [name, value] : outcome.items()) EXPECT_TRUE(schemas["ConstraintOutcome"]["properties"].contains(name)) << name;
  }
  // The same clip again by its address.
  EXPECT_EQ(json::parse(Get(made.headers.at("location") + "/report").body), report);
}

TEST_F(RoutesTest, EveryPartThatCannotBeMetIsNamed) {
  const RawResponse tight = Post(R"({"model":"walk","style":"brisk","path":{"points":[[0,0],[0,1.5],[1.5,1.5],[1.5,3],[0,3],[0,4.5]],"tolerance":0.01}})");
  ExpectProblem(tight, 422);
  EXPECT_THAT(Pointer(tight), StartsWith("/path"));
  const RawResponse joint = Post(
      R"({"model":"walk","duration":4,"constraints":[{"type":"heading","time":1,"value":0},{"type":"position","joint":"tail","time":1,"value":[0,1,0]}]})");
  ExpectProblem(joint, 422);
  EXPECT_THAT(Pointer(joint), StartsWith("/constraints/1"));
  const RawResponse late = Post(R"({"model":"walk","duration":4,"constraints":[{"type":"heading","time":5,"value":0},{"type":"look_at","from":1,"to":9,"value":[0,1,3]}]})");
  ExpectProblem(late, 422);
  EXPECT_EQ(json::parse(late.body)["errors"].size(), 2u);
}

TEST_F(RoutesTest, AClipStartsAndStopsWhereTheModelCan) {
  const RawResponse whole =
      Post(R"({"model":"walk","seed":3,"duration":6,"style":"slow","start":{"from":"standing"},"end":"standing"})",
           "Accept: application/json\r\n");
  ASSERT_EQ(whole.status, 200) << whole.body;
  const json report = json::parse(whole.body)["report"];
  EXPECT_THAT(report["steps"].front()["primitive"].get<std::string>(), ::testing::EndsWith("_first_start"));
  EXPECT_THAT(report["steps"].back()["primitive"].get<std::string>(), ::testing::EndsWith("_end"));
  EXPECT_NEAR(report["duration"].get<double>(), 6, 0.8);
  const json model = json::parse(Get("/v1/models/walk").body);
  ASSERT_EQ(model["boundaries"].size(), 2u);
  for (const json& boundaries : model["boundaries"]) {
    EXPECT_EQ(boundaries["start_from"], json({"walking", "standing"})) << boundaries["style"];
    EXPECT_EQ(boundaries["end"], json({"walking", "standing"})) << boundaries["style"];
  }
  const RawResponse slow = Post(R"({"model":"walk","start":{"from":"slow_step"}})");
  ExpectProblem(slow, 422);
  EXPECT_EQ(Pointer(slow), "/start/from");
  EXPECT_THAT(slow.body, HasSubstr("styles that can"));
  const RawResponse end = Post(R"({"model":"walk","style":"brisk","end":"slow_step"})");
  ExpectProblem(end, 422);
  EXPECT_EQ(Pointer(end), "/end");
  EXPECT_THAT(end.body, HasSubstr("it can end in: walking, standing"));
  const RawResponse few = Post(R"({"model":"walk","steps":1,"start":{"from":"standing"},"end":"standing"})");
  ExpectProblem(few, 422);
  EXPECT_EQ(Pointer(few), "/steps");
  EXPECT_THAT(few.body, HasSubstr("the nearest has 3"));
}

TEST_F(RoutesTest, StartAndEndInsideTheWalkAreTheDefault) {
  const RawResponse plain = Post(R"({"model":"walk","seed":7,"steps":6})");
  const RawResponse told = Post(R"({"model":"walk","seed":7,"steps":6,"start":{"from":"walking"},"end":"walking"})");
  EXPECT_EQ(plain.body, told.body);
  EXPECT_EQ(plain.headers.at("location"), told.headers.at("location"));
}

TEST_F(RoutesTest, LargeBodiesAreRefused) {
  ExpectProblem(Post("{\"model\":\"" + std::string(kMaxClipRequestBytes, 'x') + "\"}"), 413);
}

TEST_F(RoutesTest, EvaluatesClipsThatItMade) {
  const std::string bvh = Post(R"({"model":"walk","seed":9,"duration":6})").body;
  const RawResponse response = Ask(app_->port, "POST", "/v1/evaluations", "Content-Type: text/plain\r\n", bvh);
  ASSERT_EQ(response.status, 200) << response.body;
  const json evaluation = json::parse(response.body);
  EXPECT_LT(evaluation["quality"]["contact_distance"], 0.05);
  EXPECT_GT(evaluation["contacts"].size(), 6u);
  EXPECT_EQ(evaluation["curves"]["frame_difference"].size(), evaluation["frames"].get<std::size_t>() - 1);
}

TEST_F(RoutesTest, EvaluationRefusesWhatIsNoUsefulBvh) {
  const auto evaluate = [&](const std::string& body, const std::string& headers = "Content-Type: text/plain\r\n") {
    return Ask(app_->port, "POST", "/v1/evaluations", headers, body);
  };
  ExpectProblem(evaluate(""), 400);
  ExpectProblem(evaluate("{}", "Content-Type: application/json\r\n"), 415);
  const RawResponse broken = evaluate("HIERARCHY\nROOT hips\n{\n  OFFSET 0 zero 0\n}\n");
  ExpectProblem(broken, 400);
  EXPECT_THAT(broken.body, HasSubstr("body:4:"));
  const std::string tail = "{ OFFSET 0 0 0 CHANNELS 3 Xrotation Yrotation Zrotation End Site { OFFSET 0 1 0 } }\nMOTION\n";
  ExpectProblem(evaluate("HIERARCHY\nROOT pole\n" + tail + "Frames: 3\nFrame Time: 0.1\n0 0 0\n0 0 1\n0 0 2\n"), 422);
  ExpectProblem(evaluate("HIERARCHY\nROOT pole\n" + tail + "Frames: 1000000000\nFrame Time: 0.1\n0 0 0\n"), 400);
  // A few bytes may not ask for gigabytes: by frames that last for days, or by joints that no channel moves.
  const RawResponse slow = evaluate("HIERARCHY\nROOT pole\n" + tail + "Frames: 3\nFrame Time: 1000000\n0 0 0\n0 0 1\n0 0 2\n");
  ExpectProblem(slow, 400);
  EXPECT_THAT(slow.body, HasSubstr("frame time"));
  const RawResponse wide = evaluate(testing::ManyJointsWithoutChannels(2000, 2001));
  ExpectProblem(wide, 400);
  EXPECT_THAT(wide.body, HasSubstr("joints"));
  const RawResponse long_clip = evaluate(testing::ManyJointsWithoutChannels(400, 3000, "1"));
  ExpectProblem(long_clip, 422);
  EXPECT_THAT(long_clip.body, HasSubstr("at most"));
  for (const RawResponse& refused : {evaluate(testing::ManyJointsWithoutChannels(3, 4)), evaluate(testing::ManyJointsWithoutChannels(3, 1))}) {
    ExpectProblem(refused, 422);
    EXPECT_THAT(refused.body, ::testing::Not(::testing::ContainsRegex("DetectContacts|PrepareEvaluation")));
  }
  const std::string whole = Post(R"({"model":"walk","seed":9,"steps":2})").body;
  for (std::size_t cut = 0; cut < 3000; cut += 311) ExpectProblem(evaluate(whole.substr(0, cut)), 400);
}

TEST_F(RoutesTest, DescribesItsModels) {
  const json models = json::parse(Get("/v1/models").body)["models"];
  ASSERT_EQ(models.size(), 1u);
  EXPECT_EQ(models[0]["name"], "walk");
  EXPECT_THAT(models[0]["styles"].get<std::vector<std::string>>(), ::testing::UnorderedElementsAre("brisk", "slow"));
  EXPECT_EQ(json::parse(Get("/v1/models/walk").body)["hash"], testing::SmallModel()->hash());
  EXPECT_EQ(Get("/v1/models/" + testing::SmallModel()->hash()).status, 200);
  const RawResponse graph = Get("/v1/models/walk/graph");
  const json parsed = json::parse(graph.body);
  EXPECT_GE(parsed["primitives"].size(), 4u);
  for (const json& edge : parsed["edges"]) {
    EXPECT_LT(edge["from"], parsed["primitives"].size());
    EXPECT_GT(edge["probability"], 0);
  }
  const RawResponse dot = Get("/v1/models/walk/graph", "Accept: text/vnd.graphviz\r\n");
  EXPECT_THAT(dot.headers.at("content-type"), StartsWith("text/vnd.graphviz"));
  EXPECT_THAT(dot.body, StartsWith("digraph"));
  ExpectProblem(Get("/v1/models/walk/graph", "Accept: image/svg+xml\r\n"), 406);
  EXPECT_EQ(Get("/v1/models/walk/graph", "If-None-Match: " + graph.headers.at("etag") + "\r\n").status, 304);
}

TEST_F(RoutesTest, TellsItsHealth) {
  EXPECT_EQ(Get("/livez").status, 200);
  EXPECT_EQ(Get("/readyz").status, 200);
  app_->service.ready = false;
  ExpectProblem(Get("/readyz"), 503);
  app_->service.ready = true;
  EXPECT_THAT(Get("/metrics").body, HasSubstr("morphograph_clip_seconds_count"));
}

TEST_F(RoutesTest, ServesThePageUnderAStrictPolicy) {
  const RawResponse page = Get("/");
  EXPECT_EQ(page.status, 200);
  EXPECT_THAT(page.headers.at("content-type"), StartsWith("text/html"));
  EXPECT_THAT(page.headers.at("content-security-policy"), HasSubstr("default-src 'self'"));
  EXPECT_EQ(page.headers.at("x-content-type-options"), "nosniff");
  EXPECT_EQ(Get("/", "If-None-Match: " + page.headers.at("etag") + "\r\n").status, 304);
}

TEST_F(RoutesTest, OpenApiDescribesEveryRouteAndNoOther) {
  const json openapi = json::parse(Get("/openapi.json").body);
  EXPECT_EQ(openapi["openapi"], "3.1.0");
  std::set<std::string> described, existing;
  for (const auto& [path, item] : openapi["paths"].items()) {
    for (const char* method : {"get", "post", "delete", "put", "patch"}) {
      if (!item.contains(method)) continue;
      described.insert(std::string(method) + " " + path);
      EXPECT_FALSE(item[method]["responses"].empty());
    }
  }
  for (const Route& route : app_->router->routes()) {
    std::string method = route.method;
    for (char& c : method) c = static_cast<char>(std::tolower(c));
    const bool page_file = route.pattern.find('.') != std::string::npos && route.pattern != "/openapi.json";
    if (!page_file) existing.insert(method + " " + route.pattern);
  }
  EXPECT_EQ(described, existing);
}

TEST_F(RoutesTest, OpenApiReferencesResolve) {
  const json openapi = json::parse(OpenApiJson());
  int references = 0;
  const std::function<void(const json&)> walk = [&](const json& node) {
    if (node.is_object() && node.contains("$ref")) {
      ++references;
      EXPECT_TRUE(openapi.contains(json::json_pointer(node["$ref"].get<std::string>().substr(1)))) << node["$ref"];
    }
    if (node.is_structured())
      for (const json& child : node) walk(child);
  };
  walk(openapi);
  EXPECT_GT(references, 50);
}

TEST_F(RoutesTest, RealAnswersFitTheDescription) {
  // Every member of an answer is described, and every required member is there.
  const json schemas = json::parse(OpenApiJson())["components"]["schemas"];
  const auto fits = [&](const json& answer, const json& schema) {
    for (const auto& [name, value] : answer.items()) EXPECT_TRUE(schema["properties"].contains(name)) << name;
    for (const auto& name : schema["required"]) EXPECT_TRUE(answer.contains(name.get<std::string>())) << name;
  };
  const json clip = json::parse(Post(R"({"model":"walk","seed":1,"steps":3})", "Accept: application/json\r\n").body);
  fits(clip, schemas["ClipAnswer"]);
  fits(clip["report"], schemas["Report"]);
  fits(clip["report"]["quality"], schemas["Quality"]);
  fits(clip["report"]["contacts"][0], schemas["Contact"]);
  fits(json::parse(Get("/v1/models/walk").body), schemas["Model"]);
  const json graph = json::parse(Get("/v1/models/walk/graph").body);
  const json& extra = schemas["Graph"]["allOf"][1]["properties"];
  fits(graph["primitives"][0], extra["primitives"]["items"]);
  fits(graph["edges"][0], extra["edges"]["items"]);
  fits(json::parse(Post("{}").body), schemas["Problem"]);
}

TEST(Routes, TheReportNamesTheModelAsItWasAskedFor) {
  testing::TestService app;
  app.service.models.Add("walk", testing::SmallModel());
  app.service.models.Add("stroll", testing::SmallModel());  // its file says "walk"
  app.Start();
  const RawResponse clip = Ask(app.port, "POST", "/v1/clips", "Accept: application/json\r\n", R"({"model":"stroll","seed":1,"steps":2})");
  ASSERT_EQ(clip.status, 200) << clip.body;
  EXPECT_EQ(json::parse(clip.body)["report"]["model"]["name"], "stroll");
  const RawResponse report = Ask(app.port, "GET", clip.headers.at("location") + "/report");
  EXPECT_EQ(json::parse(report.body)["model"]["name"], "stroll");
}

}  // namespace
}  // namespace morphograph
