// Clips that readings of sensors steer, on synthetic walks whose truth is known.
#include "synthesis/control/sensor_guide.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/virtual_sensors.h"
#include "synthesis/control/control_problem.h"
#include "synthesis/motion_synthesizer.h"
#include "synthesis/sensors/motion_source.h"
#include "synthesis/sensors/reconstruction.h"
#include "synthesis/unsatisfiable_request.h"
#include "tests/support/small_model.h"

namespace morphograph {
namespace {

using ::testing::HasSubstr;

// A walk that training has not seen, cut in the middle of a step, and a request with what four sensors on it read.
class SteeredByReadings : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    graph_ = testing::SmallModelWithRecordings();
    const MotionSource source = SourceOf(*graph_);
    steps_ = std::make_shared<const SensorSteps>(source.clips, source.steps, graph_->layout(), Sensors());
    SyntheticGaitOptions options;
    options.seed = 4711;
    options.frame_rate_hz = 60;
    options.steps = 10;
    options.speed_m_s = 1.4;
    options.start_standing = options.stop_standing = false;
    const MotionClip clip = GenerateGait(options);
    walk_ = std::make_shared<const MotionClip>(clip.Slice(15, clip.frame_count() - 15));
  }
  static void TearDownTestSuite() {
    graph_.reset();
    steps_.reset();
    walk_.reset();
  }
  static std::vector<Placement> Sensors() { return PlacementsAtJoints({"left_wrist", "right_wrist", "left_ankle", "right_ankle"}); }
  static SynthesisRequest Request() {
    SynthesisRequest request;
    request.control.sensors = SensorTerm{VirtualAccelerations(*walk_, Sensors(), 60), Sensors()};
    return request;
  }
  static SynthesisResult Make(SynthesisRequest request) {
    PrepareSensors(*graph_, &request, [](const std::vector<Placement>&) { return steps_; });
    return Synthesize(*graph_, request);
  }
  static std::string RefusedAt(const SynthesisRequest& request) {
    try {
      Make(request);
    } catch (const UnsatisfiableRequest& unmet) {
      return unmet.unmet().front().pointer;
    }
    return "accepted";
  }
  static double WayOf(const MotionClip& clip) {
    return (clip.root_positions().rightCols(1) - clip.root_positions().leftCols(1)).norm();
  }

  static std::shared_ptr<const MotionGraph> graph_;
  static std::shared_ptr<const SensorSteps> steps_;
  static std::shared_ptr<const MotionClip> walk_;
};
std::shared_ptr<const MotionGraph> SteeredByReadings::graph_;
std::shared_ptr<const SensorSteps> SteeredByReadings::steps_;
std::shared_ptr<const MotionClip> SteeredByReadings::walk_;

TEST_F(SteeredByReadings, ComesNearTheWalkThatWasRead) {
  SynthesisRequest request = Request();
  request.start.position_m = {2, -1};
  request.start.heading_rad = 0.5;
  const SynthesisResult made = Make(request);
  EXPECT_NEAR(made.clip.duration_s(), walk_->duration_s(), 0.05);
  EXPECT_LT(CompareClips(made.clip, *walk_).position_rms_cm, 4);
  EXPECT_NEAR(WayOf(made.clip) / WayOf(*walk_), 1, 0.1);
  EXPECT_EQ(made.report.style, "brisk");
  EXPECT_NEAR((made.report.path_m.front() - request.start.position_m).norm(), 0, 1e-9);
  ASSERT_EQ(made.report.constraints.size(), 1u);
  EXPECT_EQ(made.report.constraints[0].pointer, "/sensors");
  EXPECT_TRUE(made.report.constraints[0].met);
  EXPECT_GT(made.report.constraints[0].residual, 0.05);
  EXPECT_LT(made.report.constraints[0].residual, 2.5);
  // Of a clip that was not told: far worse.
  SynthesisRequest untold;
  untold.style = "brisk";
  untold.duration_s = walk_->duration_s();
  EXPECT_GT(CompareClips(Synthesize(*graph_, untold).clip, *walk_).position_rms_cm, 6);
}

TEST_F(SteeredByReadings, FollowsAPathAsWell) {
  SynthesisRequest request = Request();
  const double way = WayOf(*walk_);
  // Elsewhere, another way, and a little shorter than the walk that was read.
  request.control.path = PathTerm{.points_m = {{1, 2}, {1 + 0.6 * way, 2 + 0.75 * way}}, .tolerance_m = 0.1};
  const SynthesisResult made = Make(request);
  ASSERT_EQ(made.report.constraints.size(), 3u);
  for (const ControlOutcome& outcome : made.report.constraints) EXPECT_TRUE(outcome.met) << outcome.pointer << ' ' << outcome.residual;
  EXPECT_EQ(made.report.constraints[2].pointer, "/sensors");
  EXPECT_LT(made.report.constraints[2].residual, 3);
  EXPECT_LT(CompareClips(made.clip, *walk_).position_rms_cm, 5);
}

TEST_F(SteeredByReadings, GoesOnPastItsReadings) {
  SynthesisRequest request = Request();
  request.duration_s = walk_->duration_s() + 3;
  const SynthesisResult made = Make(request);
  EXPECT_NEAR(made.clip.duration_s(), *request.duration_s, 0.05);
  EXPECT_LT(made.report.constraints.back().residual, 2.5);  // of the part that was read
  EXPECT_GT(WayOf(made.clip), WayOf(*walk_) + 2);
  request.duration_s = 2;  // and stops before they do
  EXPECT_NEAR(Make(request).clip.duration_s(), 2, 0.05);
}

TEST_F(SteeredByReadings, MayHaveAnotherFrameRate) {
  SynthesisRequest request = Request();
  request.frame_rate_hz = 50;
  const SynthesisResult made = Make(request);
  EXPECT_EQ(made.clip.frame_rate_hz(), 50);
  EXPECT_LT(CompareClips(made.clip, *walk_).position_rms_cm, 4);
}

// Between the frames of a slow film accelerations are not to be had; what its frames say is held against what the readings say of such times.
TEST_F(SteeredByReadings, IsMeasuredAtTheRateOfSlowClips) {
  const auto residual = [](double frame_rate_hz) {
    SynthesisRequest request = Request();
    request.frame_rate_hz = frame_rate_hz;
    return Make(request).report.constraints.back().residual;
  };
  const double usual = residual(30);
  for (const double slow_hz : {15, 10}) EXPECT_LT(residual(slow_hz), 1.1 * usual) << slow_hz;
}

// On the graph the first step that is found may take less time than there is before the readings.
TEST_F(SteeredByReadings, BeginsInsideItsFirstStep) {
  SynthesisRequest request = Request();
  PrepareSensors(*graph_, &request, [](const std::vector<Placement>&) { return steps_; });
  const auto guide = std::make_shared<SensorGuide>(*request.control.sensors->guide);
  DrawnStep& first = guide->walk.steps.front();
  const double duration_s = graph_->primitive(first.step.primitive).Shape(first.step.latent).duration_s;
  request.control.sensors->guide = guide;
  for (const double end : {2.0, 10.0, 100.0}) {
    first.end = end;
    first.start = end - 2 * kSensorRate_hz * duration_s;
    const double begins_s = MakeControlProblem(*graph_, request, guide->walk.style, 30).guide.given_from_s;
    EXPECT_LE(begins_s, 0);
    EXPECT_GT(begins_s + duration_s, 0);
    EXPECT_GE(begins_s + duration_s, std::min(duration_s, end / kSensorRate_hz) - 1e-9);
  }
}

TEST_F(SteeredByReadings, RefusesModelsWithoutSteps) {
  const SensorStepsSource source = [](const std::vector<Placement>& sensors) {
    return std::make_shared<const SensorSteps>(std::vector<MotionClip>{*walk_}, std::vector<RecordedStep>{}, graph_->layout(), sensors);
  };
  try {
    MakeSensorGuide(*graph_, Request(), source);
    ADD_FAILURE() << "accepted";
  } catch (const UnsatisfiableRequest& unmet) {
    EXPECT_EQ(unmet.unmet().front().pointer, "/model");
  }
}

// Two actions with styles of the same names, that are called the other way round: what is fast in one is slow in the other.
TEST_F(SteeredByReadings, ChoosesAmongTheStylesOfTheAction) {
  std::vector<TrainingClip> clips;
  for (auto& [name, clip] : testing::SmallWalks()) {
    if (name.back() > '2') continue;
    clips.push_back({clip, false});
    TrainingClip run{clip, false, -1, "run"};
    run.clip.name = "run_" + name;
    run.clip.style = clip.style == "brisk" ? "slow" : "brisk";
    clips.push_back(std::move(run));
  }
  TrainingOptions options;
  options.keep_recordings = true;
  const auto both = BuildGraph(clips, options);
  const MotionSource recorded = SourceOf(*both);
  const auto steps = std::make_shared<const SensorSteps>(recorded.clips, recorded.steps, both->layout(), Sensors());
  for (const double speed_m_s : {0.9, 1.5}) {
    SyntheticGaitOptions gait;
    gait.seed = 4712;
    gait.frame_rate_hz = 60;
    gait.steps = 9;
    gait.speed_m_s = speed_m_s;
    gait.start_standing = gait.stop_standing = false;
    const MotionClip walk = GenerateGait(gait);
    for (const std::string action : {"walk", "run"}) {
      SynthesisRequest request;
      request.control.sensors = SensorTerm{VirtualAccelerations(walk, Sensors(), 60), Sensors()};
      request.action = action;
      const auto guide = MakeSensorGuide(*both, request, [&](const std::vector<Placement>&) { return steps; });
      const GraphStyle& style = both->styles()[static_cast<std::size_t>(guide->walk.style)];
      EXPECT_EQ(both->action_of(style), action);
      EXPECT_EQ(style.name, (speed_m_s > 1.2) == (action == "walk") ? "brisk" : "slow") << action << ' ' << speed_m_s;
    }
  }
}

TEST_F(SteeredByReadings, GivesTheSameClipAgain) {
  const SynthesisResult a = Make(Request()), b = Synthesize(*graph_, Request());  // which makes its own captured steps
  EXPECT_EQ(a.clip.root_positions(), b.clip.root_positions());
}

// Each seed draws another walk of those that the readings leave possible.
TEST_F(SteeredByReadings, DiffersByItsSeedALittle) {
  SynthesisRequest request = Request();
  request.seed = 1;
  const SynthesisResult a = Make(request);
  request.seed = 2;
  const SynthesisResult b = Make(request);
  const double apart = CompareClips(a.clip, b.clip).position_rms_cm;
  EXPECT_GT(apart, 0.3);
  EXPECT_LT(apart, 5);
}

TEST_F(SteeredByReadings, TwoReadingsSteerNothing) {
  SynthesisRequest request = Request();
  Readings& readings = request.control.sensors->readings;
  readings.times_s.resize(2);
  readings.values.conservativeResize(Eigen::NoChange, 2);
  request.duration_s = 2;
  const SynthesisResult made = Make(request);
  EXPECT_NEAR(made.clip.duration_s(), 2, 0.05);
  ASSERT_TRUE(made.report.sensors);
  EXPECT_THAT(made.report.sensors->repaired.notes.at(0), HasSubstr("steer nothing"));
}

TEST_F(SteeredByReadings, ShorterThanAStepStillCounts) {
  SynthesisRequest request = Request();
  Readings& readings = request.control.sensors->readings;
  readings.times_s.resize(14);  // 0.22 s
  readings.values.conservativeResize(Eigen::NoChange, 14);
  request.duration_s = 2;
  const SynthesisResult made = Make(request);
  EXPECT_EQ(made.report.constraints.back().pointer, "/sensors");
  request.control.sensors.reset();
  const SynthesisResult untold = Synthesize(*graph_, request);
  EXPECT_NE(made.clip.root_positions(), untold.clip.root_positions());
}

TEST_F(SteeredByReadings, RefusesWhatCannotBe) {
  SynthesisRequest request = Request();
  request.control.sensors->tolerance_m_s2 = 0.01;
  EXPECT_EQ(RefusedAt(request), "/sensors");
  request = Request();
  request.start_from = WalkBoundary::kStanding;
  EXPECT_EQ(RefusedAt(request), "/start/from");
  request = Request();
  request.end = WalkBoundary::kStanding;
  EXPECT_EQ(RefusedAt(request), "/end");
  request = Request();
  request.control.sensors->placements[2].joint = "tail";
  EXPECT_EQ(RefusedAt(request), "/sensors/placements/2/joint");
  request = Request();
  request.control.sensors->readings.values.setZero();
  EXPECT_EQ(RefusedAt(request), "/sensors/readings");
  // The key frame that the clip's first step begins with lies before it.
  request = Request();
  request.control.constraints.push_back(HeadingTerm{.at = {.keyframe = 0}, .value_rad = 0});
  EXPECT_EQ(RefusedAt(request), "/constraints/0/keyframe");
  // Readings over a day are refused before anything is made of them.
  request = Request();
  Readings& readings = request.control.sensors->readings;
  for (std::size_t i = 0; i < readings.times_s.size(); ++i) readings.times_s[i] = 300.0 * static_cast<double>(i);
  request.duration_s = 2;
  EXPECT_EQ(RefusedAt(request), "/sensors/readings");
  request = Request();
  request.control.sensors->placements.pop_back();
  EXPECT_THROW(Make(request), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
