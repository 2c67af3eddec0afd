#include "api/training_service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "graph/model_io.h"
#include "primitives/keyframe_detector.h"
#include "tests/support/raw_http.h"
#include "tests/support/small_model.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_service.h"

namespace morphograph {
namespace {

using nlohmann::json;
using testing::Ask;
using testing::RawResponse;
using ::testing::HasSubstr;

const std::string kMultipart = "Content-Type: multipart/form-data; boundary=cut\r\n";

std::string FormPart(const std::string& disposition, const std::string& content) {
  return "--cut\r\nContent-Disposition: form-data; " + disposition + "\r\n\r\n" + content + "\r\n";
}

std::string Upload(const std::string& name, int copies = 1) {
  std::string body = FormPart("name=\"settings\"", R"({"name":")" + name + R"("})");
  for (const auto& [file, text] : testing::SmallWalkFiles())
    for (int i = 0; i < copies; ++i) body += FormPart("name=\"clips\"; filename=\"" + file + "\"", text);
  return body + "--cut--\r\n";
}

/// A server with training, as `serve --data-dir` sets it up.
class TrainingServer {
 public:
  explicit TrainingServer(const std::filesystem::path& folder) {
    training_.emplace(&app_.service, folder, "", 2);
    app_.service.training = &*training_;
    app_.Start();
  }
  ~TrainingServer() { app_.Stop(); }
  RawResponse Submit(const std::string& body, const std::string& headers = kMultipart) {
    return Ask(app_.port, "POST", "/v1/models", headers, body);
  }
  RawResponse Send(const std::string& method, const std::string& path, const std::string& body = "") {
    return Ask(app_.port, method, path, "", body);
  }
  json WaitFor(const std::string& location) {
    for (int i = 0; i < 1200; ++i) {
      const json job = json::parse(Send("GET", location).body);
      if (job["state"] != "queued" && job["state"] != "running") return job;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    ADD_FAILURE() << "the job does not end";
    return {};
  }

 private:
  testing::TestService app_;
  std::optional<TrainingService> training_;
};

TEST(TrainingService, TrainsServesAndKeepsAModel) {
  const testing::TemporaryFolder folder;
  std::string clip, location;
  const std::string request = R"({"model":"mine","seed":5,"steps":5})";
  {
    TrainingServer server(folder.path());
    const RawResponse accepted = server.Submit(Upload("mine"));
    ASSERT_EQ(accepted.status, 202) << accepted.body;
    location = accepted.headers.at("location");
    EXPECT_EQ(location, "/v1/jobs/" + json::parse(accepted.body)["id"].get<std::string>());
    EXPECT_EQ(server.Submit(Upload("mine")).status, 409);  // the name is taken from now on
    const json job = server.WaitFor(location);
    EXPECT_EQ(job["state"], "succeeded") << job;
    EXPECT_EQ(job["progress"], 1);
    EXPECT_EQ(server.Send("DELETE", location).status, 409);
    clip = server.Send("POST", "/v1/clips", request).body;
    EXPECT_THAT(clip, ::testing::StartsWith("HIERARCHY"));
  }
  folder.Write("uploads/of-nobody/clips/a.bvh", "left over");
  TrainingServer restarted(folder.path());
  EXPECT_TRUE(std::filesystem::is_empty(folder.path() / "uploads"));
  EXPECT_EQ(restarted.Send("POST", "/v1/clips", request).body, clip);
  EXPECT_EQ(json::parse(restarted.Send("GET", location).body)["state"], "succeeded");
}

TEST(TrainingService, AJobCutShortByARestartIsDoneByTheNextProcess) {
  const testing::TemporaryFolder folder;
  std::string location;
  {
    TrainingServer server(folder.path());
    location = server.Submit(Upload("later")).headers.at("location");
  }  // ends at once, whatever the job was at
  TrainingServer restarted(folder.path());
  EXPECT_EQ(restarted.WaitFor(location)["state"], "succeeded");
  EXPECT_EQ(restarted.Send("GET", "/v1/models/later").status, 200);
}

TEST(TrainingService, CancelsRunningAndWaitingJobs) {
  const testing::TemporaryFolder folder;
  TrainingServer server(folder.path());
  const std::string first = server.Submit(Upload("one", /*copies=*/20)).headers.at("location");  // seconds of work
  const std::string second = server.Submit(Upload("two")).headers.at("location");
  EXPECT_EQ(server.Send("DELETE", second).status, 200);
  EXPECT_EQ(server.Send("DELETE", first).status, 200);
  EXPECT_EQ(server.WaitFor(second)["state"], "cancelled");
  EXPECT_EQ(server.WaitFor(first)["state"], "cancelled");
  EXPECT_EQ(server.Send("DELETE", first).status, 200);  // again: no harm
  EXPECT_EQ(server.Send("GET", "/v1/models/one").status, 404);
  EXPECT_EQ(server.Submit(Upload("one")).status, 202);  // the name is free again
}

TEST(TrainingService, SaysWhyAJobFailed) {
  const testing::TemporaryFolder folder;
  TrainingServer server(folder.path());
  const std::string body = FormPart("name=\"clips\"; filename=\"../../broken.bvh\"", "HIERARCHY\nROOT x\n{\n OFFSET a\n") + "--cut--\r\n";
  const json job = server.WaitFor(server.Submit(body).headers.at("location"));
  EXPECT_EQ(job["state"], "failed");
  EXPECT_THAT(job["detail"].get<std::string>(), ::testing::StartsWith("broken.bvh:4:"));
  EXPECT_THAT(job["detail"].get<std::string>(), ::testing::Not(HasSubstr(folder.path().string())));
}

TEST(TrainingService, RefusesUploadsThatCannotBeTrained) {
  const testing::TemporaryFolder folder;
  TrainingServer server(folder.path());
  EXPECT_EQ(server.Submit("{}", "Content-Type: application/json\r\n").status, 415);
  EXPECT_EQ(server.Submit("", kMultipart).status, 400);
  EXPECT_EQ(server.Submit("--cut--\r\n").status, 400);
  EXPECT_EQ(server.Submit(FormPart("name=x", "1") + "--cut--").status, 400);
  const std::string clip = FormPart("name=c; filename=a.bvh", "x");
  EXPECT_EQ(server.Submit(clip + FormPart("name=settings", "{\"name\":\"../evil\"}") + "--cut--").status, 400);
  EXPECT_EQ(server.Submit(clip + FormPart("name=settings", "{\"nom\":\"x\"}") + "--cut--").status, 400);
  EXPECT_EQ(server.Submit(clip + FormPart("name=settings", "{\"name\":7}") + "--cut--").status, 400);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path() / "uploads"));
}

TEST(TrainingService, ADamagedModelDoesNotStopTheServer) {
  const testing::TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "models");
  folder.Write("models/bad.mgm", "not a model");
  ::testing::internal::CaptureStderr();
  TrainingServer server(folder.path());
  EXPECT_EQ(server.Send("GET", "/livez").status, 200);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("bad.mgm"));
}

TEST(TrainingService, LabelledKeyframesComeWithTheUploadAndFromNowhereElse) {
  const testing::TemporaryFolder folder;
  TrainingServer server(folder.path());
  std::string clips;
  json labels;
  for (const auto& [name, clip] : testing::SmallWalks()) {
    clips += FormPart("name=clips; filename=\"" + name + ".bvh\"", WriteBvh(ExportClip(clip)));
    if (name != "walk_brisk_000" && name != "walk_slow_000") continue;
    for (const Keyframe& keyframe : DetectKeyframes(clip))
      labels[name].push_back({{"frame", std::lround(keyframe.frame)}, {"label", KeyframeLabelName(keyframe.label)}});
  }
  const auto upload = [&](const std::string& manifest, const std::string& keyframes) {
    return server.Submit(clips + FormPart("name=name", "mine") + (manifest.empty() ? "" : FormPart("name=manifest", manifest)) +
                         (keyframes.empty() ? "" : FormPart("name=keyframes", keyframes)) + "--cut--\r\n");
  };
  // Neither a path nor a name can make the server read a file of its own.
  folder.Write("labels.json", labels.dump());
  for (const std::string path : {"../../labels.json", "/etc/labels.json", "..\\\\labels.json", "sub/labels.json", "labels.json"}) {
    const RawResponse refused = upload(R"({"keyframes": ")" + path + "\"}", "");
    EXPECT_EQ(refused.status, 400) << path;
    EXPECT_THAT(refused.body, HasSubstr("/keyframes")) << path;
  }
  EXPECT_EQ(upload(R"({"keyframes": "../labels.json"})", labels.dump()).status, 400);
  EXPECT_EQ(upload("", "[{\"frame\": -1}]").status, 400);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path() / "uploads"));

  const RawResponse accepted = upload(R"({"action": "stroll", "include": ["walk_*"], "keyframes": "labels.json"})", labels.dump());
  ASSERT_EQ(accepted.status, 202) << accepted.body;
  const json job = server.WaitFor(accepted.headers.at("location"));
  EXPECT_EQ(job["state"], "succeeded") << job;
  const json graph = json::parse(server.Send("GET", "/v1/models/mine/graph").body);
  EXPECT_EQ(graph["action"], "stroll");
  bool strolls = false;
  for (const json& primitive : graph["primitives"]) strolls |= primitive["name"] == "left_stroll";
  EXPECT_TRUE(strolls);
}

TEST(TrainingService, WhatCannotBeTrainedIsRefusedBeforeItIsQueued) {
  const testing::TemporaryFolder folder;
  TrainingServer server(folder.path());
  const std::string clip = FormPart("name=c; filename=a.bvh", "x");
  const RawResponse action = server.Submit(clip + FormPart("name=action", "dance") + "--cut--");
  EXPECT_EQ(action.status, 400);
  EXPECT_EQ(json::parse(action.body)["errors"][0]["pointer"], "/action");
  const RawResponse manifest = server.Submit(clip + FormPart("name=manifest", R"({"nope": 1})") + "--cut--");
  EXPECT_EQ(manifest.status, 400);
  EXPECT_THAT(manifest.body, HasSubstr("manifest: /nope: unknown field"));
  EXPECT_THAT(server.Submit(clip + FormPart("name=manifest", R"({"metres_per_unit": 1e999})") + "--cut--").body, HasSubstr("range of a double"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path() / "uploads"));
}

TEST(TrainingService, ModelsWithNamesThatNobodyCanAskForAreNotServed) {
  const testing::TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "models");
  SaveModel(*testing::SmallModel(), folder.path() / "models" / "caf\xE9.mgm");
  SaveModel(*testing::SmallModel(), folder.path() / "models" / "fine.mgm");
  ::testing::internal::CaptureStderr();
  TrainingServer server(folder.path());
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("cannot name a model"));
  const RawResponse models = server.Send("GET", "/v1/models");
  EXPECT_EQ(models.status, 200);
  EXPECT_EQ(json::parse(models.body)["models"].size(), 1u);
}

}  // namespace
}  // namespace morphograph
