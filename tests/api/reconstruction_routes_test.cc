// POST /v1/reconstructions over real sockets, with a model learned from synthetic walks.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "api/problem.h"
#include "datasets/bvh_reader.h"
#include "datasets/clip_conversion.h"
#include "datasets/virtual_sensors.h"
#include "synthesis/sensors/reconstruction.h"
#include "tests/support/raw_http.h"
#include "tests/support/small_model.h"
#include "tests/support/test_service.h"

namespace morphograph {
namespace {

using nlohmann::json;
using testing::RawResponse;
using ::testing::HasSubstr;
using ::testing::Not;

class ReconstructionRoutesTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    app_ = new testing::TestService;
    app_->service.models.Add("walk", testing::SmallModelWithRecordings());
    app_->Start();
  }
  static void TearDownTestSuite() { delete app_; }

  static RawResponse Post(const json& body, const std::string& accept = "") {
    return testing::Ask(app_->port, "POST", "/v1/reconstructions", "Content-Type: application/json\r\n" + (accept.empty() ? "" : "Accept: " + accept + "\r\n"), body.dump());
  }
  static MotionClip Walk() {
    SyntheticGaitOptions options;
    options.seed = 99;
    options.frame_rate_hz = 30;
    options.steps = 10;
    options.speed_m_s = 1.4;
    return GenerateGait(options);
  }
  static json Request(const std::string& method) {
    const std::vector<Placement> sensors = PlacementsAtJoints({"left_wrist", "right_wrist", "left_ankle", "right_ankle"});
    const Readings readings = VirtualAccelerations(Walk(), sensors, 60);
    json request = {{"model", "walk"}, {"method", method}, {"sensors", {{"rate", 60}}}};
    for (const Placement& sensor : sensors) request["sensors"]["placements"].push_back({{"joint", sensor.joint}});
    for (Eigen::Index i = 0; i < readings.values.cols(); ++i) {
      const Eigen::VectorXd row = readings.values.col(i);
      request["sensors"]["readings"].push_back(std::vector<double>(row.data(), row.data() + row.size()));
    }
    return request;
  }
  static void ExpectProblem(const RawResponse& response, int status, const std::string& pointer) {
    EXPECT_EQ(response.status, status) << response.body;
    EXPECT_EQ(json::parse(response.body).at("errors").at(0).at("pointer"), pointer) << response.body;
  }

  static testing::TestService* app_;
};
testing::TestService* ReconstructionRoutesTest::app_ = nullptr;

TEST_F(ReconstructionRoutesTest, GivesAClipThatComesNearTheTruth) {
  std::set<std::string> clips;
  for (const std::string method : {"graph", "olng", "olng_kernels", "rbf_lle"}) {
    const RawResponse response = Post(Request(method), "application/json");
    ASSERT_EQ(response.status, 200) << response.body;
    const json answer = json::parse(response.body);
    EXPECT_TRUE(clips.insert(answer.at("bvh")).second) << method << " gives what another gives";
    const MotionClip clip = ImportClip(ParseBvh(answer.at("bvh").get<std::string>(), "answer"));
    EXPECT_LT(CompareClips(clip, Walk()).position_rms_cm, 8) << method;
    const json& report = answer.at("report");
    EXPECT_EQ(report.at("frames"), clip.frame_count());
    EXPECT_EQ(report.at("reconstruction").at("method"), method);
    EXPECT_EQ(report.at("reconstruction").at("sensors").size(), 4u);
    EXPECT_EQ(report.contains("steps"), method == "graph");
    EXPECT_EQ(report.at("reconstruction").at("dead_sensors").size(), 0u);
  }
}

TEST_F(ReconstructionRoutesTest, GivesBvhAndTheSameBytesAgain) {
  const RawResponse first = Post(Request("graph")), again = Post(Request("graph"));
  ASSERT_EQ(first.status, 200) << first.body;
  EXPECT_THAT(first.body, HasSubstr("HIERARCHY"));
  EXPECT_EQ(first.body, again.body);
  EXPECT_EQ(Post(Request("graph"), "model/gltf-binary").body.substr(0, 4), "glTF");
  EXPECT_EQ(Post(Request("graph"), "image/png").status, 406);
}

TEST_F(ReconstructionRoutesTest, NamesWhatWasLost) {
  json request = Request("graph");
  for (std::size_t i = 60; i < 90; ++i) {
    for (json& value : request["sensors"]["readings"][i]) value = nullptr;
  }
  for (json& row : request["sensors"]["readings"]) row[3] = row[4] = row[5] = 0;
  const RawResponse response = Post(request, "application/json");
  ASSERT_EQ(response.status, 200) << response.body;
  const json about = json::parse(response.body).at("report").at("reconstruction");
  EXPECT_EQ(about.at("dead_sensors"), json::array({"right_wrist"}));
  EXPECT_EQ(about.at("sensors").size(), 3u);
  EXPECT_NEAR(about.at("longest_gap").get<double>(), 0.5, 0.05);
  EXPECT_GT(about.at("lost").get<double>(), 0.05);
  EXPECT_FALSE(about.at("notes").empty());
}

TEST_F(ReconstructionRoutesTest, SmoothsReadingsOnRequest) {
  json request = Request("olng");
  const RawResponse plain = Post(request);
  request["low_pass"] = 3;
  const RawResponse smooth = Post(request);
  ASSERT_EQ(smooth.status, 200) << smooth.body;
  EXPECT_NE(smooth.body, plain.body);
  request["low_pass"] = 0;
  ExpectProblem(Post(request), 422, "/low_pass");
}

// The walk begins out of standing, so that sensors which sit askew can be set right.
TEST_F(ReconstructionRoutesTest, AlignsSensorsByStanding) {
  json request = Request("graph");
  for (json& row : request["sensors"]["readings"]) {  // the right ankle's sensor, by 90 degrees about its x axis
    const double y = row[10], z = row[11];
    row[10] = -z;
    row[11] = y;
  }
  request["alignment"] = {{"standing", {0.0, 0.5}}};
  const RawResponse response = Post(request, "application/json");
  ASSERT_EQ(response.status, 200) << response.body;
  const json found = json::parse(response.body).at("report").at("reconstruction").at("alignment");
  EXPECT_EQ(found.at("standing"), json({0.0, 0.5}));
  EXPECT_EQ(found.at("standing_found"), false);
  EXPECT_EQ(found.at("standing_in_recordings"), true);
  ASSERT_EQ(found.at("sensors").size(), 4u);
  EXPECT_EQ(found.at("sensors").at(3).at("sensor"), "right_ankle");
  EXPECT_NEAR(found.at("sensors").at(3).at("angle").get<double>(), 90, 20);
  EXPECT_LT(found.at("sensors").at(2).at("angle").get<double>(), 20);

  request["alignment"] = {{"standing", {2.0, 3.0}}};
  ExpectProblem(Post(request), 422, "/alignment/standing");
  request["alignment"] = {{"standing", {3.0, 2.0}}};
  ExpectProblem(Post(request), 400, "/alignment/standing");
  request["alignment"] = {{"standing", {0.0}}};
  ExpectProblem(Post(request), 400, "/alignment/standing");
  request["alignment"] = {{"sitting", true}};
  ExpectProblem(Post(request), 400, "/alignment/sitting");
  request["alignment"] = true;
  ExpectProblem(Post(request), 400, "/alignment");
}

// Streams are worked off while their answer goes out; only so many at a time.
TEST_F(ReconstructionRoutesTest, FourStreamsAtATime) {
  HttpRequest request;
  request.method = "POST";
  request.path = "/v1/reconstructions";
  request.headers = {{"Content-Type", "application/x-ndjson"}, {"Accept", "application/x-ndjson"}};
  request.body = json({{"model", "walk"}, {"method", "olng"}, {"placements", Request("olng")["sensors"]["placements"]}}).dump() + "\n";
  const Route& route = *app_->router->Find("POST", request.path).route;
  std::vector<HttpResponse> held;
  for (int i = 0; i < 4; ++i) held.push_back(route.handler(request));
  try {
    route.handler(request);
    ADD_FAILURE() << "a fifth stream was let in";
  } catch (const ProblemError& full) {
    EXPECT_EQ(full.problem().status, 503);
  }
  held.pop_back();
  EXPECT_EQ(route.handler(request).status, 200);
}

// The same readings in a clip request: the clip is steered by them, and can be had again.
TEST_F(ReconstructionRoutesTest, ReadingsSteerClips) {
  json request = Request("graph");
  request.erase("method");
  request["seed"] = 5;
  const auto ask = [&](const std::string& method, const std::string& path, const std::string& body) {
    return testing::Ask(app_->port, method, path, "Content-Type: application/json\r\nAccept: application/json\r\n", body);
  };
  const RawResponse response = ask("POST", "/v1/clips", request.dump());
  ASSERT_EQ(response.status, 200) << response.body;
  const json answer = json::parse(response.body);
  const auto off_cm = [](const std::string& bvh) { return CompareClips(ImportClip(ParseBvh(bvh, "answer")), Walk()).position_rms_cm; };
  // Nearer to the walk that was read than a clip of the same seed which is told nothing but the style and the time.
  const json untold = {{"model", "walk"}, {"seed", 5}, {"style", answer.at("report").at("style")}, {"duration", answer.at("report").at("duration")}};
  const RawResponse free = ask("POST", "/v1/clips", untold.dump());
  ASSERT_EQ(free.status, 200) << free.body;
  EXPECT_LT(off_cm(answer.at("bvh")), 0.75 * off_cm(json::parse(free.body).at("bvh")));
  const json& report = answer.at("report");
  EXPECT_EQ(report.at("constraints").at(0).at("pointer"), "/sensors");
  EXPECT_EQ(report.at("constraints").at(0).at("unit"), "m/s2");
  EXPECT_FALSE(report.at("constraints").at(0).contains("tolerance"));
  EXPECT_EQ(report.at("sensors").at("sensors").size(), 4u);
  const std::string location = response.headers.at("location");
  const auto kept = app_->service.clips.Get(location.substr(location.rfind('/') + 1));
  ASSERT_TRUE(kept && kept->request.control.sensors);
  EXPECT_TRUE(kept->request.control.sensors->guide) << "made ready once, not for everybody who asks again";
  EXPECT_EQ(ask("GET", location, "").body, response.body);

  request["sensors"]["tolerance"] = 0.01;
  const RawResponse unmet = ask("POST", "/v1/clips", request.dump());
  EXPECT_EQ(unmet.status, 422);
  EXPECT_EQ(json::parse(unmet.body).at("errors").at(0).at("pointer"), "/sensors");
  request["sensors"]["tolerance"] = 0;
  EXPECT_EQ(ask("POST", "/v1/clips", request.dump()).status, 400);
  request["sensors"].erase("tolerance");
  request["count"] = 2;
  const RawResponse variants = testing::Ask(app_->port, "POST", "/v1/variants", "Content-Type: application/json\r\n", request.dump());
  EXPECT_EQ(variants.status, 200);
  EXPECT_THAT(variants.body, HasSubstr("\"made\":2"));
}

TEST_F(ReconstructionRoutesTest, RefusesWhatItCannotReadOrMeet) {
  ExpectProblem(Post(json::array()), 400, "");
  ExpectProblem(Post({{"model", "walk"}}), 400, "/sensors");
  json request = Request("graph");
  request["method"] = "magic";
  ExpectProblem(Post(request), 400, "/method");
  request = Request("graph");
  request["model"] = "dance";
  ExpectProblem(Post(request), 404, "/model");
  request = Request("graph");
  request["sensors"]["readings"][3].erase(0);
  ExpectProblem(Post(request), 400, "/sensors/readings/3");
  request = Request("graph");
  request["sensors"]["readings"][3][1] = "x";
  ExpectProblem(Post(request), 400, "/sensors/readings/3/1");
  request = Request("graph");
  request["sensors"]["times"] = json::array({0, 1});
  ExpectProblem(Post(request), 400, "/sensors/rate");
  request = Request("graph");
  request["sensors"]["placements"][1]["joint"] = "left_wrist";
  ExpectProblem(Post(request), 400, "/sensors/placements/1/name");
  request = Request("graph");
  request["sensors"]["placements"][1]["joint"] = "tail";
  const RawResponse tail = Post(request);
  EXPECT_EQ(tail.status, 422) << tail.body;
  EXPECT_THAT(tail.body, HasSubstr("tail"));
  request = Request("graph");
  for (json& row : request["sensors"]["readings"]) row = json(std::vector<double>(12, 0.0));
  ExpectProblem(Post(request), 422, "/sensors/readings");  // every sensor is dead
}

// What goes in line by line comes out line by line.
TEST_F(ReconstructionRoutesTest, StreamsPosesForLinesOfReadings) {
  const json request = Request("olng");
  std::string body = json({{"model", "walk"}, {"method", "olng"}, {"placements", request["sensors"]["placements"]}}).dump() + "\n";
  int n = 0;
  for (const json& row : request["sensors"]["readings"]) body += json({{"time", n++ / 60.0}, {"readings", row}}).dump() + "\n";
  const auto ask = [](const std::string& lines) {
    return testing::Ask(app_->port, "POST", "/v1/reconstructions", "Content-Type: application/x-ndjson\r\nAccept: application/x-ndjson\r\n", lines);
  };
  const RawResponse response = ask(body);
  ASSERT_EQ(response.status, 200) << response.body;
  std::vector<json> poses;
  std::istringstream lines(response.body);
  for (std::string line; std::getline(lines, line);) poses.push_back(json::parse(line));
  EXPECT_NEAR(static_cast<double>(poses.size()), n / 2.0, 3);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    EXPECT_NEAR(poses[k].at("time").get<double>(), static_cast<double>(k) / 30, 1e-4);
    for (const auto& [joint, q] : poses[k].at("rotations").items()) {
      const Eigen::Vector4d wxyz(q[0].get<double>(), q[1].get<double>(), q[2].get<double>(), q[3].get<double>());
      ASSERT_NEAR(wxyz.norm(), 1, 1e-3) << joint;
    }
  }
  // It walks: some metres from where it began.
  EXPECT_GT(std::hypot(poses.back()["root"][0].get<double>(), poses.back()["root"][2].get<double>()), 1.5);

  EXPECT_EQ(ask("{}\n").status, 400);
  EXPECT_THAT(response.body, Not(HasSubstr("\"notes\"")));
  const RawResponse broken = ask(body.substr(0, body.find('\n', body.size() / 2) + 1) + "{\"time\": 99}\n");
  ASSERT_EQ(broken.status, 200);
  EXPECT_THAT(broken.body, HasSubstr("\"error\""));
  EXPECT_THAT(broken.body, HasSubstr("/readings"));
}

// One frame in, one frame out: poses come while readings are still being sent, the same as of a body that was sent whole.
TEST_F(ReconstructionRoutesTest, StreamsWhileReadingsCome) {
  const json request = Request("olng");
  std::vector<std::string> lines = {json({{"model", "walk"}, {"method", "olng"}, {"placements", request["sensors"]["placements"]}}).dump() + "\n"};
  for (const json& row : request["sensors"]["readings"]) lines.push_back(json({{"time", static_cast<double>(lines.size() - 1) / 60}, {"readings", row}}).dump() + "\n");
  std::string whole;
  for (const std::string& line : lines) whole += line;
  const std::string head = "POST /v1/reconstructions HTTP/1.1\r\nHost: t\r\nContent-Type: application/x-ndjson\r\nTransfer-Encoding: chunked\r\n\r\n";
  const auto chunk = [](const std::string& text) {
    char size[16];
    std::snprintf(size, sizeof size, "%zx\r\n", text.size());
    return size + text + "\r\n";
  };
  testing::RawConnection connection(app_->port);
  ASSERT_TRUE(connection.Send(head));
  for (std::size_t i = 0; i < 120; ++i) ASSERT_TRUE(connection.Send(chunk(lines[i])));
  // A second and a half of poses is due of the two seconds that were sent.
  const std::string due = "\"time\":1.5,";
  ASSERT_EQ(connection.ReadSome(due), due);
  for (std::size_t i = 120; i < lines.size(); ++i) ASSERT_TRUE(connection.Send(chunk(lines[i])));
  ASSERT_TRUE(connection.Send("0\r\n\r\n"));
  const auto live = connection.Read();
  ASSERT_TRUE(live);
  EXPECT_EQ(live->status, 200);
  EXPECT_EQ(live->headers.at("connection"), "close");
  EXPECT_EQ(live->body, testing::Ask(app_->port, "POST", "/v1/reconstructions", "Content-Type: application/x-ndjson\r\n", whole).body);
  // What is wrong with a line ends it, as ever; one request in JSON is not taken so.
  testing::RawConnection broken(app_->port);
  ASSERT_TRUE(broken.Send(head + chunk(lines[0]) + chunk("{\"time\": 0}\n")));
  EXPECT_EQ(broken.ReadSome("\"error\""), "\"error\"");
  testing::RawConnection whole_request(app_->port);
  ASSERT_TRUE(whole_request.Send("POST /v1/reconstructions HTTP/1.1\r\nHost: t\r\nContent-Type: application/json\r\nTransfer-Encoding: chunked\r\n\r\n"));
  const auto refused = whole_request.Read();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 411);
}

// What is lost on the way is told in the lines, and a dead sensor takes the poses of the others nowhere.
TEST_F(ReconstructionRoutesTest, StreamsTellDamage) {
  const json request = Request("olng");
  const std::string head = json({{"model", "walk"}, {"method", "olng"}, {"placements", request["sensors"]["placements"]}}).dump() + "\n";
  const auto poses_of = [&](const std::function<void(int, json*)>& damage, double tempo = 1) {
    std::string body = head;
    int n = 0;
    for (json row : request["sensors"]["readings"]) {
      damage(n, &row);
      body += json({{"time", tempo * n++ / 60.0}, {"readings", row}}).dump() + "\n";
    }
    const RawResponse response = testing::Ask(app_->port, "POST", "/v1/reconstructions", "Content-Type: application/x-ndjson\r\nAccept: application/x-ndjson\r\n", body);
    EXPECT_EQ(response.status, 200);
    std::vector<json> poses;
    std::istringstream lines(response.body);
    for (std::string line; std::getline(lines, line);) poses.push_back(json::parse(line));
    return poses;
  };
  const auto notes_of = [](const std::vector<json>& poses) {
    std::string notes;
    for (const json& pose : poses) {
      for (const json& note : pose.value("notes", json::array())) notes += note.get<std::string>() + "\n";
    }
    return notes;
  };
  const auto set = [](json* row, int sensor, const json& value) {
    for (std::size_t axis = 0; axis < 3; ++axis) (*row)[3 * static_cast<std::size_t>(sensor) + axis] = value;
  };
  const std::vector<json> sound = poses_of([](int, json*) {});
  const auto apart_deg = [&](const std::vector<json>& poses) {  // mean over joints and frames
    double sum = 0;
    int count = 0;
    for (std::size_t k = 0; k < std::min(poses.size(), sound.size()); ++k) {
      for (const auto& [joint, q] : poses[k].at("rotations").items()) {
        double dot = 0;
        for (std::size_t i = 0; i < 4; ++i) dot += q[i].get<double>() * sound[k]["rotations"][joint][i].get<double>();
        sum += 2 * std::acos(std::min(1.0, std::abs(dot))) * 180 / M_PI;
        ++count;
      }
    }
    return sum / count;
  };
  for (const json& dead : {json(nullptr), json(0)}) {
    const std::vector<json> poses = poses_of([&](int, json* row) { set(row, 1, dead); });
    EXPECT_THAT(notes_of(poses), HasSubstr("'right_wrist' "));
    EXPECT_THAT(notes_of(poses), HasSubstr("it is left out from"));
    EXPECT_EQ(poses.size(), sound.size());
    EXPECT_LT(apart_deg(poses), 3);
  }
  const std::vector<json> gap = poses_of([&](int n, json* row) {
    for (int s = 0; n >= 120 && n < 150 && s < 4; ++s) set(row, s, nullptr);
  });
  EXPECT_THAT(notes_of(gap), HasSubstr("'left_ankle' was silent from 1.98 s to 2.50 s"));
  EXPECT_EQ(gap.size(), sound.size());
  const auto spike = [&](int n, json* row) {
    if (n % 60 == 30) set(row, 0, 120);
  };
  EXPECT_THAT(notes_of(poses_of(spike)), HasSubstr("wild samples were replaced"));
  const auto clip = [&](int, json* row) {
    for (json& value : *row) value = std::clamp(value.get<double>(), -14.0, 14.0);
  };
  EXPECT_THAT(notes_of(poses_of(clip)), HasSubstr("is clipped at 14.0 m/s^2"));
  const auto in_feet = [&](int, json* row) {
    for (json& value : *row) value = value.get<double>() / 0.3048;
  };
  EXPECT_THAT(notes_of(poses_of(in_feet)), HasSubstr("are they in m/s^2?"));
  const std::vector<json> in_ms = poses_of([](int, json*) {}, 1000);
  ASSERT_EQ(in_ms.size(), 1u);
  EXPECT_THAT(in_ms.front().at("error").at("detail").get<std::string>(), HasSubstr("times are in seconds"));
}

}  // namespace
}  // namespace morphograph
