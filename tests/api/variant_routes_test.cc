// POST /v1/variants over real sockets, with a model learned from synthetic walks.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "tests/support/raw_http.h"
#include "tests/support/small_model.h"
#include "tests/support/test_service.h"

namespace morphograph {
namespace {

using nlohmann::json;
using testing::Ask;
using testing::RawResponse;
using ::testing::HasSubstr;

ServerOptions OneWorker() {
  ServerOptions options;
  options.threads = 1;
  return options;
}

class VariantRoutesTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    app_ = new testing::TestService;
    app_->service.models.Add("walk", testing::SmallModel());
    app_->Start();
  }
  static void TearDownTestSuite() { delete app_; }

  static RawResponse Post(const std::string& body, const std::string& headers = "Content-Type: application/json\r\n") {
    return Ask(app_->port, "POST", "/v1/variants", headers, body);
  }
  static std::vector<json> Lines(const std::string& body) {
    std::vector<json> lines;
    for (std::size_t at = 0; at < body.size();) {
      const std::size_t end = body.find('\n', at);
      if (end == std::string::npos) ADD_FAILURE() << "the last line has no end";
      lines.push_back(json::parse(body.substr(at, end - at)));
      at = end == std::string::npos ? body.size() : end + 1;
    }
    return lines;
  }
  static void ExpectProblem(const RawResponse& response, int status, const std::string& pointer) {
    EXPECT_EQ(response.status, status) << response.body;
    const json problem = json::parse(response.body);
    EXPECT_EQ(problem.at("status"), status);
    if (pointer.empty()) return;
    EXPECT_EQ(problem.at("errors").at(0).at("pointer"), pointer);
  }

  static testing::TestService* app_;
};
testing::TestService* VariantRoutesTest::app_ = nullptr;

TEST_F(VariantRoutesTest, GivesALineAVariantRankedAndASummary) {
  const RawResponse response = Post(R"({"model":"walk","seed":42,"steps":6,"style":"brisk","count":9})");
  ASSERT_EQ(response.status, 200) << response.body;
  EXPECT_EQ(response.headers.at("content-type"), "application/x-ndjson");
  EXPECT_EQ(response.headers.at("transfer-encoding"), "chunked");
  EXPECT_EQ(response.headers.at("morphograph-seed"), "42");
  const std::vector<json> lines = Lines(response.body);
  ASSERT_EQ(lines.size(), 10u);
  double last = std::numeric_limits<double>::infinity();
  std::set<int> seen;
  for (int i = 0; i < 9; ++i) {
    const json& line = lines[static_cast<std::size_t>(i)];
    EXPECT_EQ(line.size(), 4u);
    EXPECT_EQ(line["seed"], 42 + line["index"].get<int>());
    EXPECT_EQ(line["report"]["seed"], line["seed"]);
    EXPECT_EQ(line["report"]["model"]["name"], "walk");
    const double per_step = line["report"]["quality"]["log_likelihood"].get<double>() / static_cast<double>(line["report"]["steps"].size());
    EXPECT_LE(per_step, last + 1e-9);
    last = per_step;
    seen.insert(line["index"].get<int>());
    const RawResponse alone = Ask(app_->port, "POST", "/v1/clips", "", R"({"model":"walk","steps":6,"style":"brisk","seed":)" + line["seed"].dump() + "}");
    EXPECT_EQ(line["bvh"], alone.body);
  }
  EXPECT_EQ(seen.size(), 9u);
  const json& summary = lines.back().at("summary");
  EXPECT_EQ(summary["asked"], 9);
  EXPECT_EQ(summary["made"], 9);
  EXPECT_EQ(summary["unmet"], 0);
  EXPECT_GT(summary["duration"]["min"], 1);
  EXPECT_GT(summary["spread"]["clips"], 0);
  EXPECT_GT(summary["swept_area"]["area"], 1);
  EXPECT_GT(summary["swept_area"]["polygons"][0]["outline"].size(), 6u);
  EXPECT_FALSE(summary.contains("arrival_time"));
}

TEST_F(VariantRoutesTest, TheSameRequestGivesTheSameBytes) {
  const std::string request = R"({"model":"walk","seed":3,"steps":4,"count":5})";
  const std::string first = Post(request).body;
  EXPECT_EQ(Post(request).body, first);
  testing::TestService alone(OneWorker());
  alone.service.models.Add("walk", testing::SmallModel());
  alone.Start();
  EXPECT_EQ(Ask(alone.port, "POST", "/v1/variants", "", request).body, first);
}

TEST_F(VariantRoutesTest, RefusesWhatIsWrong) {
  ExpectProblem(Post(R"({"model":"walk","steps":4})"), 400, "/count");
  ExpectProblem(Post(R"({"model":"walk","count":0})"), 400, "/count");
  ExpectProblem(Post(R"({"model":"walk","count":1001})"), 422, "/count");
  ExpectProblem(Post(R"({"model":"dance","count":2})"), 404, "/model");
  ExpectProblem(Post(R"({"model":"walk","count":2})", "Content-Type: text/xml\r\n"), 415, "");
  ExpectProblem(Post(R"({"model":"walk","count":2})", "Accept: text/plain\r\n"), 406, "");
  ExpectProblem(Post(R"({"model":"walk","count":2,"style":"moonwalk"})"), 422, "/style");
  ExpectProblem(Post(R"({"model":"walk","count":1000,"duration":60})"), 422, "/count");  // more than is held at a time
}

TEST(VariantRoutes, OthersComeToTheirTurnEvenWithOneWorker) {
  testing::TestService app(OneWorker());
  app.service.models.Add("walk", testing::SmallModel());
  app.Start();
  std::atomic<bool> done = false;
  std::thread many([&] {
    EXPECT_EQ(Ask(app.port, "POST", "/v1/variants", "", R"({"model":"walk","seed":1,"duration":6,"count":150})").status, 200);
    done = true;
  });
  int answered = 0;
  while (!done && answered < 30) {
    EXPECT_EQ(Ask(app.port, "POST", "/v1/clips", "", R"({"model":"walk","seed":1,"steps":3})").status, 200);
    ++answered;
  }
  many.join();
  EXPECT_GT(answered, 10);
}

TEST_F(VariantRoutesTest, OldClientsGetItInOnePiece) {
  testing::RawConnection client(app_->port);
  const std::string body = R"({"model":"walk","seed":3,"steps":4,"count":2})";
  client.Send("POST /v1/variants HTTP/1.0\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  const RawResponse response = client.Read().value_or(RawResponse{});
  EXPECT_EQ(response.status, 200);
  EXPECT_EQ(response.headers.count("transfer-encoding"), 0u);
  EXPECT_EQ(Lines(response.body).size(), 3u);
}

TEST(VariantRoutes, StopWhenTheClientHasGoneOrTheTimeIsOver) {
  ServerOptions hurried = OneWorker();
  hurried.work_timeout = std::chrono::seconds(0);
  testing::TestService late(hurried);
  late.service.models.Add("walk", testing::SmallModel());
  late.Start();
  const RawResponse response = Ask(late.port, "POST", "/v1/variants", "", R"({"model":"walk","steps":4,"count":2})");
  EXPECT_EQ(response.status, 503) << response.body;
  EXPECT_THAT(response.body, HasSubstr("too long"));
  EXPECT_EQ(response.headers.count("retry-after"), 1u);

  testing::TestService app(OneWorker());
  app.service.models.Add("walk", testing::SmallModel());
  app.Start();
  {
    testing::RawConnection client(app.port);
    const std::string body = R"({"model":"walk","seed":3,"duration":10,"count":900})";
    client.Send("POST /v1/variants HTTP/1.1\r\nHost: here\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  // Gone long before it was through: the only worker is free again.
  const auto asked = std::chrono::steady_clock::now();
  while (app.service.metrics.queued > 0 && std::chrono::steady_clock::now() - asked < std::chrono::seconds(20))
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_LT(std::chrono::steady_clock::now() - asked, std::chrono::seconds(1));
}

}  // namespace
}  // namespace morphograph
