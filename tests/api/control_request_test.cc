// Paths, goals, speeds and constraints of a clip request.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "api/clip_request.h"
#include "api/clip_response.h"
#include "api/problem.h"

namespace morphograph {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;

// A request that has every kind of term, and no default anywhere.
constexpr const char* kEverything = R"({
  "model": "walk", "seed": 1, "duration": 8,
  "start": {"position": [0, 0], "heading": 90},
  "goal": {"position": [4, 3], "heading": -30, "tolerance": 0.04, "heading_tolerance": 3, "time": 8, "weight": 3},
  "path": {"points": [[0, 0], [2, 0], [2, 0], [4, 3]], "tolerance": 0.2, "interpolation": "spline", "weight": 0.5},
  "speed": {"profile": [[0, 1], [4, 1.5]], "tolerance": 0.2, "weight": 2},
  "constraints": [
    {"type": "position", "joint": "right_wrist", "time": 3.2, "value": [2.1, null, 0.4], "tolerance": 0.02, "weight": 4},
    {"type": "orientation", "joint": "head", "keyframe": 3, "value": [0.5, 0.5, -0.5, 0.5], "tolerance": 12},
    {"type": "trajectory", "joint": "left_wrist", "points": [[1, 0, 1, 0], [1.5, 0, 1.2, 0.1]], "tolerance": 0.1},
    {"type": "heading", "time": 5.0, "value": 180, "tolerance": 4},
    {"type": "footstep", "foot": "right", "index": 4, "value": [1.9, 0.0], "tolerance": 0.02},
    {"type": "keep_out", "circle": {"center": [2, 2], "radius": 0.5}, "weight": 10},
    {"type": "keep_out", "polygon": [[5, 5], [6, 5], [6, 6], [5, 5]]},
    {"type": "look_at", "from": 1.0, "to": 3.0, "value": [3, 1.6, 3], "tolerance": 15},
    {"type": "pose", "keyframe": 2, "joints": {"right_wrist": [-0.3, 1, 0.2], "left_wrist": [0.3, 1, 0.2]}, "tolerance": 0.1}
  ]})";

// Readings stand in a request's name and come back as they were, what was lost included.
TEST(ControlRequest, ReadsReadings) {
  const std::string text = R"({"model":"walk","seed":1,"sensors":{"rate":50,"placements":[{"joint":"left_wrist","offset":[0,0.02,0]},{"joint":"hips","name":"belt"}],
      "readings":[[0.1,9.8,0.2,0,9.7,1],[0.1,null,0.2,0,9.7,1],[0.1,9.9,0.2,0,9.7,1]],"tolerance":2.5,"weight":0.25}})";
  const ClipRequest request = ParseClipRequest(text);
  ASSERT_TRUE(request.control.sensors);
  const SensorTerm& term = *request.control.sensors;
  EXPECT_EQ(term.readings.names, (std::vector<std::string>{"left_wrist", "belt"}));
  EXPECT_NEAR(term.readings.times_s[2], 0.04, 1e-12);
  EXPECT_EQ(term.readings.values.cols(), 3);
  EXPECT_TRUE(std::isnan(term.readings.values(1, 1)));
  EXPECT_EQ(term.tolerance_m_s2, 2.5);
  EXPECT_EQ(term.weight, 0.25);
  const std::string canonical = CanonicalJson(request);
  EXPECT_EQ(CanonicalJson(ParseClipRequest(canonical)), canonical);
  ClipRequest other = request;
  other.control.sensors->readings.values(0, 0) += 1e-9;
  EXPECT_NE(ClipId("hash", request), ClipId("hash", other));
}

Problem ProblemWithTerms(const json& request) {
  try {
    ParseClipRequest(request.dump());
  } catch (const ProblemError& error) {
    return error.problem();
  }
  return {200, "accepted", {}, {}, {}};
}

std::string VerdictOnTerms(const json& request) {
  const Problem problem = ProblemWithTerms(request);
  std::string verdict = std::to_string(problem.status);
  for (const FieldError& error : problem.errors) verdict += " " + error.pointer;
  return verdict;
}

json Request(const std::string& fields) { return json::parse(R"({"model":"walk",)" + fields + "}"); }

// The verdict on a request with these constraints; with `fields` beside them.
std::string OfConstraint(const std::string& constraints, const std::string& fields = R"("style":"slow")") {
  return VerdictOnTerms(Request(fields + R"(,"constraints":[)" + constraints + "]"));
}

TEST(ControlRequest, ReadsEveryKindOfTerm) {
  const ClipRequest request = ParseClipRequest(kEverything);
  const ControlTerms& terms = ToSynthesisRequest(request).control;
  ASSERT_TRUE(terms.path && terms.goal && terms.speed);
  EXPECT_EQ(terms.path->points_m, (std::vector<Eigen::Vector2d>{{0, 0}, {2, 0}, {4, 3}}));  // once each
  EXPECT_TRUE(terms.path->smooth);
  EXPECT_EQ(terms.path->tolerance_m, 0.2);
  EXPECT_EQ(terms.goal->position_m, Eigen::Vector2d(4, 3));
  EXPECT_NEAR(*terms.goal->heading_rad, -30 * kDegree, 1e-14);
  EXPECT_NEAR(terms.goal->heading_tolerance_rad, 3 * kDegree, 1e-14);
  EXPECT_EQ(terms.goal->time_s, 8.0);
  ASSERT_EQ(terms.speed->profile.size(), 2u);
  EXPECT_EQ(terms.speed->profile[1].time_s, 4);
  EXPECT_EQ(terms.speed->profile[1].speed_m_s, 1.5);
  EXPECT_EQ(terms.speed->tolerance_m_s, 0.2);
  ASSERT_EQ(terms.constraints.size(), 9u);
  const auto& position = std::get<PositionTerm>(terms.constraints[0]);
  EXPECT_EQ(position.joint, "right_wrist");
  EXPECT_EQ(position.weight, 4);
  EXPECT_EQ(terms.path->weight, 0.5);
  EXPECT_EQ(terms.goal->weight, 3);
  EXPECT_EQ(terms.speed->weight, 2);
  EXPECT_EQ(position.at.time_s, 3.2);
  EXPECT_FALSE(position.at.keyframe);
  EXPECT_EQ(position.value_m, Eigen::Vector3d(2.1, 0, 0.4));
  EXPECT_TRUE(position.use[0] && !position.use[1] && position.use[2]);
  const auto& orientation = std::get<OrientationTerm>(terms.constraints[1]);
  EXPECT_EQ(orientation.at.keyframe, 3);
  EXPECT_EQ(orientation.value.w(), 0.5);
  EXPECT_EQ(orientation.value.y(), -0.5);
  EXPECT_NEAR(orientation.tolerance_rad, 12 * kDegree, 1e-14);
  const auto& trajectory = std::get<TrajectoryTerm>(terms.constraints[2]);
  EXPECT_EQ(trajectory.times_s, (std::vector<double>{1, 1.5}));
  EXPECT_EQ(trajectory.points_m[1], Eigen::Vector3d(0, 1.2, 0.1));
  EXPECT_NEAR(std::get<HeadingTerm>(terms.constraints[3]).value_rad, std::numbers::pi, 1e-14);
  const auto& footstep = std::get<FootstepTerm>(terms.constraints[4]);
  EXPECT_FALSE(footstep.left);
  EXPECT_EQ(footstep.index, 4);
  EXPECT_EQ(std::get<KeepOutTerm>(terms.constraints[5]).radius_m, 0.5);
  EXPECT_EQ(std::get<KeepOutTerm>(terms.constraints[6]).polygon_m.size(), 3u);  // closed by repeating the first corner
  EXPECT_EQ(std::get<LookAtTerm>(terms.constraints[7]).to_s, 3);
  const auto& pose = std::get<PoseTerm>(terms.constraints[8]);
  EXPECT_EQ(pose.joints, (std::vector<std::string>{"left_wrist", "right_wrist"}));
  EXPECT_EQ(pose.values_m[1], Eigen::Vector3d(-0.3, 1, 0.2));
}

TEST(ControlRequest, CanonicalJsonHoldsEveryTermAndReadsBackTheSame) {
  const std::string canonical = CanonicalJson(ParseClipRequest(kEverything));
  EXPECT_EQ(CanonicalJson(ParseClipRequest(canonical)), canonical);
  // What was sent, but for repeated points.
  json sent = json::parse(kEverything);
  sent["path"]["points"].erase(1);
  sent["constraints"][6]["polygon"].erase(3);
  EXPECT_EQ(json::parse(canonical), sent);
}

TEST(ControlRequest, EveryFieldCountsInAClipsName) {
  const json all = json::parse(kEverything);
  const std::string name = ClipId("hash", ParseClipRequest(all.dump()));
  int changed = 0;
  const json flat = all.flatten();
  for (const auto& [pointer, value] : flat.items()) {
    if (!value.is_number() || pointer == "/path/points/1/0" || pointer == "/path/points/2/0") continue;
    json other = all;
    json& number = other[json::json_pointer(pointer)];
    if (number.is_number_integer()) {
      number = number.get<int>() + 1;
    } else {
      number = number.get<double>() + 1e-3;
    }
    try {
      EXPECT_NE(ClipId("hash", ParseClipRequest(other.dump())), name) << pointer;
      ++changed;
    } catch (const ProblemError&) {
      // Some numbers cannot change alone.
    }
  }
  EXPECT_GT(changed, 40);
  json same = all;
  same["goal"]["position"] = {4.0, 3.0};
  EXPECT_EQ(ClipId("hash", ParseClipRequest(same.dump())), name);
}

TEST(ControlRequest, DefaultsThatAreToldAreTheSameRequest) {
  const auto canonical = [](const std::string& fields) { return CanonicalJson(ParseClipRequest(Request(fields).dump())); };
  EXPECT_EQ(canonical(R"("path":{"points":[[0,0],[1,1]],"tolerance":0.1,"interpolation":"linear"})"),
            canonical(R"("path":{"points":[[0,0],[1,1]]})"));
  EXPECT_EQ(canonical(R"("goal":{"position":[1,1],"heading":0,"tolerance":0.05,"heading_tolerance":5})"),
            canonical(R"("goal":{"position":[1,1],"heading":0})"));
  EXPECT_EQ(canonical(R"("speed":{"profile":[[0,1.2]],"tolerance":0.1})"), canonical(R"("speed":1.2)"));
  EXPECT_EQ(canonical(R"("constraints":[])"), R"({"model":"walk"})");
  EXPECT_EQ(canonical(R"("constraints":[{"type":"heading","time":1,"value":5,"tolerance":5}])"),
            canonical(R"("constraints":[{"type":"heading","time":1,"value":5}])"));
}

TEST(ControlRequest, AStartThatIsGivenIsNotOneLeftOpen) {
  const auto given = [](const std::string& fields) { return ToSynthesisRequest(ParseClipRequest(Request(R"("seed":1,)" + fields).dump())).start_given; };
  const std::string path = R"("path":{"points":[[0,0],[1,1]]})";
  EXPECT_FALSE(given(path).position || given(path).heading);
  EXPECT_TRUE(given(path + R"(,"start":{"position":[0,0]})").position);
  EXPECT_TRUE(given(path + R"(,"start":{"heading":0})").heading);
  const auto canonical = [](const std::string& fields) { return CanonicalJson(ParseClipRequest(Request(fields).dump())); };
  EXPECT_NE(canonical(path), canonical(path + R"(,"start":{"heading":0})"));
  EXPECT_EQ(canonical(R"("start":{"position":[0,0],"heading":0})"), R"({"model":"walk"})");  // no way to go: no difference
}

TEST(ControlRequest, DegreesComeBackToTheLastDigit) {
  for (const double degrees : {0.1, 33.3, 123.456789012, -179.999999999, 359.1, 35999.123456789}) {
    const json request = Request(R"("constraints":[{"type":"heading","time":1,"value":)" + json(degrees).dump() + "}]");
    const std::string canonical = CanonicalJson(ParseClipRequest(request.dump()));
    EXPECT_NEAR(json::parse(canonical)["constraints"][0]["value"].get<double>(), degrees, 1e-9);
    EXPECT_EQ(CanonicalJson(ParseClipRequest(canonical)), canonical);
  }
}

TEST(ControlRequest, PointsAtWhatIsMalformed) {
  for (const auto& [fields, verdict] : std::vector<std::pair<std::string, std::string>>{
           {R"("path":[[0,0],[1,1]])", "400 /path"},
           {R"("path":{})", "400 /path/points"},
           {R"("path":{"points":[[0,0]]})", "400 /path/points"},
           {R"("path":{"points":"round"})", "400 /path/points"},
           {R"("path":{"points":[[0,0],[1,"1"]]})", "400 /path/points/1"},
           {R"("path":{"points":[[0,0],[1,1,1]]})", "400 /path/points/1"},
           {R"("path":{"points":[[0,0],[1,1]],"tolerance":0})", "400 /path/tolerance"},
           {R"("path":{"points":[[0,0],[1,1]],"interpolation":"cubic"})", "400 /path/interpolation"},
           {R"("path":{"points":[[0,0],[1,1]],"closed":true})", "400 /path/closed"},
           {R"("goal":{"heading":3})", "400 /goal/position"},
           {R"("goal":{"position":[1]})", "400 /goal/position"},
           {R"("goal":{"position":[1,1],"heading_tolerance":3})", "400 /goal/heading_tolerance"},
           {R"("goal":{"position":[1,1],"time":0})", "400 /goal/time"},
           {R"("goal":{"position":[1,1],"pose":{}})", "400 /goal/pose"},
           {R"("speed":"fast")", "400 /speed"},
           {R"("speed":-1)", "400 /speed"},
           {R"("speed":{"profile":[]})", "400 /speed/profile"},
           {R"("speed":{"profile":[[0,1],[0,2]]})", "400 /speed/profile/1/0"},
           {R"("speed":{"profile":[[0,-1]]})", "400 /speed/profile/0/1"},
           {R"("speed":{"profile":[1,2]})", "400 /speed/profile/0 /speed/profile/1"},
           {R"("constraints":{})", "400 /constraints"},
           {R"("count":3)", "400 /count"}}) {
    EXPECT_EQ(VerdictOnTerms(Request(fields)), verdict) << fields;
  }
  const std::string wrist = R"({"type":"position","joint":"left_wrist",)";
  for (const auto& [constraint, verdict] : std::vector<std::pair<std::string, std::string>>{
           {"3", "400 /constraints/0"},
           {"{}", "400 /constraints/0/type"},
           {R"({"type":"velocity"})", "400 /constraints/0/type"},
           {R"({"type":"position","time":1,"value":[0,1,0]})", "400 /constraints/0/joint"},
           {wrist + R"("value":[0,1,0]})", "400 /constraints/0"},
           {wrist + R"("time":1,"keyframe":1,"value":[0,1,0]})", "400 /constraints/0/keyframe"},
           {wrist + R"("time":-1,"value":[0,1,0]})", "400 /constraints/0/time"},
           {wrist + R"("keyframe":-1,"value":[0,1,0]})", "400 /constraints/0/keyframe"},
           {wrist + R"("keyframe":1.5,"value":[0,1,0]})", "400 /constraints/0/keyframe"},
           {wrist + R"("time":1})", "400 /constraints/0/value"},
           {wrist + R"("time":1,"value":[null,null,null]})", "400 /constraints/0/value"},
           {wrist + R"("time":1,"value":[0,1]})", "400 /constraints/0/value"},
           {wrist + R"("time":1,"value":[0,1,0],"mass":2})", "400 /constraints/0/mass"},
           {R"({"type":"orientation","joint":"head","time":1,"value":[1,1,0,0]})", "400 /constraints/0/value"},
           {R"({"type":"orientation","joint":"head","time":1,"value":[0,0,0,0]})", "400 /constraints/0/value"},
           {R"({"type":"trajectory","joint":"head","points":[[0,0,1]]})", "400 /constraints/0/points/0"},
           {R"({"type":"trajectory","joint":"head","points":[[1,0,1,0],[1,0,1,0]]})", "400 /constraints/0/points/1/0"},
           {R"({"type":"heading","time":1})", "400 /constraints/0/value"},
           {R"({"type":"footstep","foot":"both","index":0,"value":[0,0]})", "400 /constraints/0/foot"},
           {R"({"type":"footstep","foot":"left","value":[0,0]})", "400 /constraints/0/index"},
           {R"({"type":"keep_out"})", "400 /constraints/0"},
           {R"({"type":"keep_out","circle":{"center":[0,0],"radius":0}})", "400 /constraints/0/circle/radius"},
           {R"({"type":"keep_out","circle":{"center":[0,0],"radius":1},"polygon":[[0,0],[1,0],[0,1]]})", "400 /constraints/0/polygon"},
           {R"({"type":"keep_out","polygon":[[0,0],[1,0]]})", "400 /constraints/0/polygon"},
           {R"({"type":"look_at","from":2,"to":2,"value":[0,1,0]})", "400 /constraints/0/to"},
           {R"({"type":"pose","time":1,"joints":{}})", "400 /constraints/0/joints"},
           {R"({"type":"pose","time":1,"joints":{"a/b":[0,0]}})", "400 /constraints/0/joints/a~1b"}}) {
    EXPECT_EQ(OfConstraint(constraint), verdict) << constraint;
  }
}

TEST(ControlRequest, PointsAtWhatNoClipCouldMeet) {
  const std::string path = R"("path":{"points":[[0,0],[4,0]]},)";
  for (const auto& [fields, verdict] : std::vector<std::pair<std::string, std::string>>{
           {R"("path":{"points":[[1,1],[1,1]]})", "422 /path/points"},
           {R"("path":{"points":[[0,0],[9000,0]]})", "422 /path/points"},
           {R"("path":{"points":[[0,0],[20000,0]]})", "422 /path/points/1"},
           {R"("path":{"points":[[0,0],[3000,0]]},"output":{"frame_rate":30})", "422 /path/points"},  // more frames than a clip may have
           {R"("path":{"points":[[0,0],[1,1]],"tolerance":1e-6})", "422 /path/tolerance"},
           {path + R"("start":{"position":[0,2]})", "422 /start/position"},
           {path + R"("goal":{"position":[5,0]})", "422 /goal/position"},
           {path + R"("speed":0)", "422 /speed"},
           {R"("speed":13)", "422 /speed"},
           {R"("goal":{"position":[5,0],"time":601})", "422 /goal/time"},
           {R"("duration":5,"goal":{"position":[5,0],"time":6})", "422 /goal/time"}}) {
    EXPECT_EQ(VerdictOnTerms(Request(fields)), verdict) << fields;
  }
  const std::string clip = R"("duration":5)", steps = R"("steps":6)";
  for (const auto& [constraints, given, verdict] : std::vector<std::tuple<std::string, std::string, std::string>>{
           {R"({"type":"heading","time":5.1,"value":0})", clip, "422 /constraints/0/time"},
           {R"({"type":"heading","time":5.1,"value":0})", R"("goal":{"position":[4,0],"time":5})", "422 /constraints/0/time"},
           {R"({"type":"heading","keyframe":7,"value":0})", steps, "422 /constraints/0/keyframe"},
           {R"({"type":"footstep","foot":"left","index":5,"value":[0,0]})", steps, "422 /constraints/0/index"},
           {R"({"type":"look_at","from":2,"to":6,"value":[0,1,0]})", clip, "422 /constraints/0/to"},
           {R"({"type":"trajectory","joint":"head","points":[[1,0,1,0],[6,0,1,0]]})", clip, "422 /constraints/0/points/1/0"},
           {R"({"type":"keep_out","polygon":[[3,3],[4,4],[4,3],[3,4]]})", clip, "422 /constraints/0/polygon"},
           {R"({"type":"keep_out","polygon":[[3,3],[4,4],[5,5]]})", clip, "422 /constraints/0/polygon"},
           {R"({"type":"keep_out","circle":{"center":[0,0.2],"radius":0.5}})", clip, "422 /start/position"},
           {R"({"type":"keep_out","polygon":[[3,-1],[5,-1],[5,1],[3,1]]})", R"("goal":{"position":[4,0]})", "422 /goal/position"},
           {R"({"type":"keep_out","circle":{"center":[4,0],"radius":0.5}})", path + clip, "422 /path/points/1"},
           {R"({"type":"footstep","foot":"left","index":1,"value":[2,0]},{"type":"keep_out","circle":{"center":[2,0],"radius":0.3}})", clip,
            "422 /constraints/0/value"},
           {R"({"type":"heading","time":1,"value":0},{"type":"heading","time":1,"value":90})", clip, "422 /constraints/1/value"},
           {R"({"type":"position","joint":"head","time":1,"value":[0,1.5,0]},{"type":"position","joint":"head","time":1,"value":[null,1,0]})",
            clip, "422 /constraints/1/value"}}) {
    EXPECT_EQ(OfConstraint(constraints, given), verdict) << constraints;
  }
  // Their neighbours can be met, as far as the request can tell.
  EXPECT_EQ(VerdictOnTerms(Request(path + R"("start":{"position":[0,0.09]},"goal":{"position":[4.1,0]})")), "200");
  EXPECT_EQ(OfConstraint(R"({"type":"heading","time":5,"value":0})", clip), "200");
  EXPECT_EQ(OfConstraint(R"({"type":"heading","keyframe":6,"value":0})", steps), "200");
  EXPECT_EQ(OfConstraint(R"({"type":"heading","time":1,"value":179},{"type":"heading","time":1,"value":-179})", clip), "200");
  EXPECT_EQ(OfConstraint(R"({"type":"keep_out","polygon":[[3,3],[4,4],[4,3]]})", clip), "200");
}

TEST(ControlRequest, SaysWhatWouldDo) {
  const Problem apart = ProblemWithTerms(Request(R"("path":{"points":[[0,0],[4,0]]},"goal":{"position":[5,0]})"));
  EXPECT_THAT(apart.errors.at(0).detail, HasSubstr("the path ends at [4.0,0.0], 1.0 m away"));
  const Problem late = ProblemWithTerms(Request(R"("duration":5,"constraints":[{"type":"heading","time":9,"value":0}])"));
  EXPECT_THAT(late.errors.at(0).detail, HasSubstr("at most"));
  const Problem inside = ProblemWithTerms(Request(R"("goal":{"position":[4,0]},"constraints":[{"type":"keep_out","circle":{"center":[4,0.2],"radius":0.5}}])"));
  EXPECT_THAT(inside.errors.at(0).detail, HasSubstr("0.3 m inside of /constraints/0"));
}

TEST(ControlRequest, BoundsHowMuchIsAsked) {
  json path = Request(R"("path":{"points":[]})");
  for (int i = 0; i < 1000; ++i) path["path"]["points"].push_back({i, 0});
  path["output"]["frame_rate"] = 10;
  EXPECT_EQ(VerdictOnTerms(path), "200");
  path["path"]["points"].push_back({1001, 0});
  EXPECT_EQ(VerdictOnTerms(path), "422 /path/points");
  json many = Request(R"("constraints":[])");
  for (int i = 0; i < 200; ++i) many["constraints"].push_back({{"type", "heading"}, {"time", i}, {"value", 0}});
  EXPECT_EQ(VerdictOnTerms(many), "200");
  many["constraints"].push_back({{"type", "heading"}, {"time", 300}, {"value", 0}});
  EXPECT_EQ(VerdictOnTerms(many), "422 /constraints");
  // Whatever is wrong with however many, the answer stays short.
  for (json& constraint : many["constraints"]) constraint["colour"] = std::string(500, 'x');
  many["constraints"].erase(200);
  EXPECT_EQ(ProblemWithTerms(many).errors.size(), 20u);
}

TEST(ControlRequest, VariantsAreAClipRequestAndACount) {
  const VariantsRequest request = ParseVariantsRequest(R"({"model":"walk","seed":5,"count":100,"goal":{"position":[4,3]}})");
  EXPECT_EQ(request.count, 100);
  EXPECT_TRUE(request.clip.control.goal);
  const auto verdict = [](const std::string& text) {
    try {
      ParseVariantsRequest(text);
      return std::string("200");
    } catch (const ProblemError& error) {
      return std::to_string(error.problem().status) + " " + error.problem().errors.at(0).pointer;
    }
  };
  EXPECT_EQ(verdict(R"({"model":"walk"})"), "400 /count");
  EXPECT_EQ(verdict(R"({"model":"walk","count":0})"), "400 /count");
  EXPECT_EQ(verdict(R"({"model":"walk","count":2.0})"), "400 /count");
  EXPECT_EQ(verdict(R"({"model":"walk","count":1001})"), "422 /count");
  EXPECT_EQ(verdict(R"({"model":"walk","count":1000})"), "200");
}

TEST(ControlReport, TellsWhatBecameOfEachTerm) {
  SynthesisReport report;
  report.constraints = {{"/path", std::nullopt, true, 0.0312345, 0.1, "m"},
                        {"/speed", std::nullopt, true, 0.02, 0.1, "m/s"},
                        {"/constraints/0", 0, false, 0.1, 5 * kDegree, "rad", false, {30 * kDegree}},
                        {"/constraints/1", 1, true, 0.01, 0.03, "m", false, {1, 1.2345678, -3}}};
  const json constraints = json::parse(ReportJson(report))["constraints"];
  EXPECT_EQ(constraints[0], json({{"pointer", "/path"}, {"met", true}, {"residual", 0.03123}, {"tolerance", 0.1}, {"unit", "m"}}));
  EXPECT_EQ(constraints[1]["unit"], "m/s");
  EXPECT_EQ(constraints[2], json({{"index", 0}, {"pointer", "/constraints/0"}, {"met", false}, {"residual", 5.72958}, {"tolerance", 5.0}, {"unit", "deg"}, {"reached", 30.0}}));
  EXPECT_EQ(constraints[3]["reached"], json({1.0, 1.23457, -3.0}));
}

}  // namespace
}  // namespace morphograph
