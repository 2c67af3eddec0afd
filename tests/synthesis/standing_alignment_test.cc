// Sensors that sit askew, found out by standing and by the motion, on synthetic walks whose truth is known.
#include "synthesis/sensors/standing_alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "datasets/virtual_sensors.h"
#include "synthesis/sensors/motion_source.h"
#include "synthesis/sensors/readings_reconstruction.h"
#include "synthesis/unsatisfiable_request.h"
#include "tests/support/random_matrix.h"
#include "tests/support/small_model.h"

namespace morphograph {
namespace {

constexpr double kPerDegree = std::numbers::pi / 180;

std::vector<Placement> WristsAndAnkles() { return PlacementsAtJoints({"left_wrist", "right_wrist", "left_ankle", "right_ankle"}); }

// Stands for 2 s, walks, and stands for 2 s again unless told otherwise.
MotionClip WalkBetweenStands(bool stands = true) {
  SyntheticGaitOptions options;
  options.seed = 4711;
  options.frame_rate_hz = 30;
  options.steps = 12;
  options.speed_m_s = 1.4;
  options.start_standing = options.stop_standing = stands;
  options.stand_s = 2;
  return GenerateGait(options);
}

// Sensors turned by `askew_deg` about a random axis each, and the turns that set them right.
Readings Askew(const MotionClip& clip, double askew_deg, std::vector<Eigen::Quaterniond>* turns, unsigned seed = 3) {
  Readings readings = VirtualAccelerations(clip, WristsAndAnkles(), 60);
  std::mt19937_64 rng(seed);
  for (int s = 0; s < readings.sensor_count(); ++s) {
    turns->emplace_back(Eigen::AngleAxisd(askew_deg * kPerDegree, testing::RandomRotation(rng) * Eigen::Vector3d::UnitX()));
    readings.values.middleRows<3>(3 * s) = (turns->back().conjugate().toRotationMatrix() * readings.values.middleRows<3>(3 * s)).eval();
  }
  return readings;
}

TEST(FindStanding, FindsTheLongestStandThroughNoiseAndNoneInAWalk) {
  const Readings readings = VirtualAccelerations(WalkBetweenStands(), WristsAndAnkles(), 30);
  for (const double noise : {0.0, 1.2}) {
    const auto phase = FindStanding(WithFaults(readings, {.noise = noise}, 1).values, 30);
    ASSERT_TRUE(phase.has_value()) << noise;
    EXPECT_GE(phase->to_s - phase->from_s, 1.5) << noise;
    // At one end of the clip or the other, and hardly into the walk.
    EXPECT_TRUE(phase->from_s < 0.5 || phase->to_s > readings.times_s.back() - 0.5) << phase->from_s << " " << phase->to_s;
    EXPECT_LE(phase->to_s - phase->from_s, 2.8) << noise;
    EXPECT_LE(UnrestOf(readings.values, 30, *phase).maxCoeff(), kMostUnrest_m_s2);
  }
  EXPECT_FALSE(FindStanding(VirtualAccelerations(WalkBetweenStands(false), WristsAndAnkles(), 30).values, 30).has_value());
  EXPECT_FALSE(FindStanding(readings.values.leftCols(20), 30).has_value());
  EXPECT_THROW(UnrestOf(readings.values, 30, {1, 1.2}), std::invalid_argument);
  EXPECT_THROW(UnrestOf(readings.values, 30, {-1, 1}), std::invalid_argument);
  EXPECT_THROW(UnrestOf(readings.values, 30, {0, 1000}), std::invalid_argument);
}

TEST(WornBy, KnowsStandingFromRecordingsAndGuessesItFromWalks) {
  SyntheticGaitOptions options;
  options.steps = 12;
  const std::vector<Placement> feet = PlacementsAtJoints({"left_ankle", "right_ankle", "left_wrist"});
  const WornSensors stood = WornBy({GenerateGait(options), GenerateGait(options)}, feet);
  options.start_standing = options.stop_standing = false;
  const WornSensors walked = WornBy({GenerateGait(options)}, feet);
  EXPECT_TRUE(stood.standing);
  EXPECT_FALSE(walked.standing);
  // Feet lie as flat in mid-stance as when standing; how an arm hangs is less sure.
  for (const int foot : {0, 1}) EXPECT_LT(std::acos(stood.up.col(foot).dot(walked.up.col(foot))), 5 * kPerDegree);
  EXPECT_GT(walked.spread_rad[2], 2 * walked.spread_rad[0]);
  EXPECT_THROW(WornBy({}, feet), std::invalid_argument);
}

TEST(AlignByStanding, SetsTheTiltRightAndLeavesTheTurnAboutTheVertical) {
  std::vector<Eigen::Quaterniond> turns;
  const Readings readings = Askew(WalkBetweenStands(), 25, &turns);
  const WornSensors worn = WornBy({WalkBetweenStands()}, WristsAndAnkles());
  const SensorTurns found = AlignByStanding(worn, readings.values, 60, {0.2, 1.8});
  for (Eigen::Index s = 0; s < 4; ++s) {
    const Eigen::Vector3d up = worn.up.col(s), seen = found.sensors[static_cast<std::size_t>(s)].told_from_worn * (turns[static_cast<std::size_t>(s)].conjugate() * up);
    EXPECT_LT(std::acos(std::min(1.0, seen.dot(up))), 3 * kPerDegree) << s;
    EXPECT_LT(found.sensors[static_cast<std::size_t>(s)].turn_rad(), 25.5 * kPerDegree);
  }
  EXPECT_THROW(AlignByStanding(worn, readings.values.topRows(6), 60, {0.2, 1.8}), std::invalid_argument);
}

class AlignedReconstructionTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    graph_ = testing::SmallModelWithRecordings();
    reconstructor_ = MakeReconstructor(graph_, ReconstructionMethod::kGraph, WristsAndAnkles());
  }
  static void TearDownTestSuite() {
    reconstructor_.reset();
    graph_.reset();
  }
  static ReconstructedReadings Made(const Readings& readings, const std::optional<AlignmentRequest>& alignment, ReconstructionMethod method = ReconstructionMethod::kGraph) {
    ReconstructionRequest request;
    request.method = method;
    request.readings = readings;
    request.placements = WristsAndAnkles();
    request.alignment = alignment;
    return ReconstructReadings(*graph_, request, [](const std::vector<Placement>&) { return reconstructor_; });
  }
  static std::string Refused(const Readings& readings, const AlignmentRequest& alignment, ReconstructionMethod method = ReconstructionMethod::kGraph) {
    try {
      Made(readings, alignment, method);
    } catch (const UnsatisfiableRequest& refused) {
      return refused.pointer() + ": " + refused.what();
    }
    return "taken";
  }

  static std::shared_ptr<const MotionGraph> graph_;
  static std::shared_ptr<const Reconstructor> reconstructor_;
};
std::shared_ptr<const MotionGraph> AlignedReconstructionTest::graph_;
std::shared_ptr<const Reconstructor> AlignedReconstructionTest::reconstructor_;

TEST_F(AlignedReconstructionTest, BringsAskewSensorsNearerToTheTruth) {
  const MotionClip truth = WalkBetweenStands();
  std::vector<Eigen::Quaterniond> straight;
  const auto error_cm = [&](const ReconstructedReadings& made) { return CompareClips(made.reconstruction.clip, truth).position_rms_cm; };
  const double straight_cm = error_cm(Made(Askew(truth, 0, &straight), std::nullopt));  // what this model makes of this walker at best
  for (const double askew_deg : {20.0, 30.0}) {
    double left = 0, told_cm = 0, aligned_cm = 0;
    constexpr unsigned kTries = 4;  // as how much a turn harms depends on its axis
    for (unsigned seed = 3; seed < 3 + kTries; ++seed) {
      std::vector<Eigen::Quaterniond> turns;
      const Readings readings = Askew(truth, askew_deg, &turns, seed);
      const ReconstructedReadings as_told = Made(readings, std::nullopt), aligned = Made(readings, AlignmentRequest());
      EXPECT_FALSE(as_told.alignment.has_value());
      ASSERT_TRUE(aligned.alignment.has_value());
      EXPECT_FALSE(aligned.alignment->told);
      for (std::size_t s = 0; s < turns.size(); ++s) left += aligned.alignment->sensors[s].told_from_worn.angularDistance(turns[s]) / kPerDegree / (4 * kTries);
      told_cm += error_cm(as_told) / kTries;
      aligned_cm += error_cm(aligned) / kTries;
    }
    EXPECT_LT(left, 0.6 * askew_deg);
    EXPECT_LT(aligned_cm - straight_cm, 0.3 * (told_cm - straight_cm)) << askew_deg;
    RecordProperty("cm_" + std::to_string(static_cast<int>(askew_deg)), std::to_string(straight_cm) + " " + std::to_string(told_cm) + " " + std::to_string(aligned_cm) + " left " + std::to_string(left));
  }
}

TEST_F(AlignedReconstructionTest, FindsASensorThatComesLate) {
  std::vector<Eigen::Quaterniond> turns;
  Readings readings = Askew(WalkBetweenStands(), 0, &turns);
  const Eigen::MatrixXd last = readings.values.bottomRows<3>();
  readings.values.bottomRows<3>() << last.col(0).replicate(1, 6), last.leftCols(last.cols() - 6);  // 0.1 s
  const SensorTurns found = Made(readings, AlignmentRequest()).alignment.value();
  EXPECT_NEAR(found.sensors[3].delay_s, 0.1, 0.04);
  for (const std::size_t s : {0U, 1U, 2U}) EXPECT_NEAR(found.sensors[s].delay_s, 0, 0.04) << s;
}

TEST_F(AlignedReconstructionTest, TakesAToldPhaseInTheReadingsOwnTime) {
  std::vector<Eigen::Quaterniond> turns;
  Readings readings = Askew(WalkBetweenStands(), 20, &turns);
  for (double& time : readings.times_s) time += 1000;
  const ReconstructedReadings made = Made(readings, AlignmentRequest{StandingPhase{1000.2, 1001.8}});
  EXPECT_TRUE(made.alignment->told);
  EXPECT_NEAR(made.alignment->standing.from_s, 1000.2, 1e-9);
  EXPECT_THAT(Refused(readings, {StandingPhase{0.2, 1.8}}), ::testing::StartsWith("/alignment/standing: a standing phase must"));
}

TEST_F(AlignedReconstructionTest, RefusesWhereNobodyStands) {
  std::vector<Eigen::Quaterniond> turns;
  const Readings walking = Askew(WalkBetweenStands(false), 20, &turns), both = Askew(WalkBetweenStands(), 20, &turns);
  EXPECT_THAT(Refused(walking, {}), ::testing::HasSubstr("/alignment/standing: there is no second"));
  EXPECT_THAT(Refused(both, {StandingPhase{3, 5}}), ::testing::HasSubstr("nobody stands there: sensor '"));
  EXPECT_THAT(Refused(VirtualMarkers(WalkBetweenStands(), WristsAndAnkles()), {}, ReconstructionMethod::kMarkers), ::testing::StartsWith("/alignment: markers"));
}

}  // namespace
}  // namespace morphograph
