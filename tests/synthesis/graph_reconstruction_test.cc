// The graph method: readings to a walk, on synthetic walks whose truth is known.
#include "synthesis/sensors/graph_reconstruction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/errors.h"
#include "datasets/marker_set.h"
#include "datasets/virtual_sensors.h"
#include "synthesis/evaluation.h"
#include "synthesis/sensors/motion_source.h"
#include "synthesis/sensors/readings_reconstruction.h"
#include "synthesis/sensors/reconstruction.h"
#include "tests/support/small_model.h"

namespace morphograph {
namespace {

std::vector<Placement> FourSensors() { return PlacementsAtJoints({"left_wrist", "right_wrist", "left_ankle", "right_ankle"}); }

class GraphReconstructionTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    graph_ = testing::SmallModelWithRecordings();
    const MotionSource source = SourceOf(*graph_);
    sensors_ = new SensorSteps(source.clips, source.steps, graph_->layout(), FourSensors());
  }
  static void TearDownTestSuite() {
    delete sensors_;
    graph_.reset();
  }

  // A walk that training has not seen: another seed and speed, cut in the middle of a step.
  static MotionClip UnseenWalk(SyntheticGaitTruth* truth) {
    SyntheticGaitOptions options;
    options.seed = 4711;
    options.frame_rate_hz = 30;
    options.steps = 12;
    options.speed_m_s = 1.4;
    options.start_standing = options.stop_standing = false;
    MotionClip clip = GenerateGait(options, truth);
    const int cut = 7;
    for (SyntheticGaitTruth::Strike& strike : truth->strikes) strike.time_s -= cut / 30.0;
    return clip.Slice(cut, clip.frame_count() - cut);
  }

  static std::shared_ptr<const MotionGraph> graph_;
  static SensorSteps* sensors_;
};
std::shared_ptr<const MotionGraph> GraphReconstructionTest::graph_;
SensorSteps* GraphReconstructionTest::sensors_ = nullptr;

TEST_F(GraphReconstructionTest, CutsReadingsWhereFeetStrike) {
  SyntheticGaitTruth truth;
  const MotionClip walk = UnseenWalk(&truth);
  const Eigen::MatrixXd readings = VirtualAccelerations(walk, FourSensors(), kSensorRate_hz).values;
  const std::vector<FoundStep> found = sensors_->search().Find(readings);
  ASSERT_FALSE(found.empty());
  EXPECT_LE(found.front().start_frame, 0);
  EXPECT_GE(found.back().end_frame, static_cast<double>(readings.cols() - 1));
  for (std::size_t k = 1; k < found.size(); ++k) {
    EXPECT_EQ(found[k].start_frame, found[k - 1].end_frame);
    EXPECT_NE(found[k].left, found[k - 1].left);
  }
  int strikes = 0;
  for (const SyntheticGaitTruth::Strike& strike : truth.strikes) {
    const double frame = strike.time_s * kSensorRate_hz;
    if (frame < 5 || frame > static_cast<double>(readings.cols()) - 6) continue;
    ++strikes;
    double nearest = 1e9;
    for (const FoundStep& step : found) {
      if (step.left == (strike.foot == Foot::kLeft)) nearest = std::min(nearest, std::abs(step.end_frame - frame));
    }
    EXPECT_LE(nearest, 3) << "strike at frame " << frame;
  }
  EXPECT_GE(strikes, 7);
}

TEST_F(GraphReconstructionTest, ComesNearTheTruthWithFeetPlanted) {
  SyntheticGaitTruth truth;
  const MotionClip walk = UnseenWalk(&truth);
  const Eigen::MatrixXd readings = VirtualAccelerations(walk, FourSensors(), kSensorRate_hz).values;
  const GraphReconstruction made = ReconstructWalk(*graph_, *sensors_, readings);
  ASSERT_EQ(made.result.clip.frame_count(), readings.cols());
  const ReconstructionQuality quality = CompareClips(made.result.clip, walk);
  EXPECT_LT(quality.position_rms_cm, 4);
  EXPECT_GT(quality.contact_agreement, 0.9);
  EXPECT_GT(quality.jerk_ratio, 0.5);
  EXPECT_LT(quality.jerk_ratio, 1.5);
  // It walks as far as the truth did, since steps carry the root with them.
  const auto length = [](const MotionClip& clip) { return (clip.root_positions().rightCols(1) - clip.root_positions().leftCols(1)).norm(); };
  EXPECT_NEAR(length(made.result.clip) / length(walk), 1, 0.1);
  EXPECT_LT(made.result.report.quality.foot_skate_cm_s, 1.4 * EvaluateClip(walk).quality.foot_skate_cm_s);
  ASSERT_TRUE(made.result.report.quality.log_likelihood.has_value());
  EXPECT_TRUE(std::isfinite(*made.result.report.quality.log_likelihood));
  EXPECT_EQ(made.result.report.style, "brisk");
  EXPECT_EQ(made.result.report.steps.back().to, readings.cols() - 1);
}

TEST_F(GraphReconstructionTest, BearsNoiseAndAskewSensors) {
  SyntheticGaitTruth truth;
  const MotionClip walk = UnseenWalk(&truth);
  const Readings readings = WithFaults(VirtualAccelerations(walk, FourSensors(), kSensorRate_hz), {.noise = 1.2, .mounting_rad = 0.17}, 3);
  EXPECT_LT(CompareClips(ReconstructWalk(*graph_, *sensors_, readings.values).result.clip, walk).position_rms_cm, 5.5);
}

TEST_F(GraphReconstructionTest, GivesTheSameTwice) {
  SyntheticGaitTruth truth;
  const Eigen::MatrixXd readings = VirtualAccelerations(UnseenWalk(&truth), FourSensors(), kSensorRate_hz).values;
  const MotionClip a = ReconstructWalk(*graph_, *sensors_, readings).result.clip;
  const MotionSource source = SourceOf(*graph_, 2);
  const SensorSteps sensors(source.clips, source.steps, graph_->layout(), FourSensors(), 2);
  const MotionClip b = ReconstructWalk(*graph_, sensors, readings).result.clip;
  EXPECT_EQ(a.root_positions(), b.root_positions());
  for (int j = 0; j < a.joint_count(); ++j) EXPECT_EQ(a.rotation(20, j).coeffs(), b.rotation(20, j).coeffs());
}

TEST_F(GraphReconstructionTest, CopiesOfOtherTemposAreTheSameStepsInAnotherTime) {
  const MotionSource source = SourceOf(*graph_);
  const CapturedSteps plain(source.clips, source.steps, graph_->layout(), FourSensors(), false), copied(source.clips, source.steps, graph_->layout(), FourSensors(), false, 1, {0.8});
  for (const bool left : {true, false}) {
    const StepBank &once = plain.landing(left), &twice = copied.landing(left);
    ASSERT_EQ(twice.size(), 2 * once.size());
    for (Eigen::Index k = 0; k < once.size(); ++k) {
      double nearest = 1e9;
      for (Eigen::Index i = 0; i < twice.size(); ++i) nearest = std::min(nearest, static_cast<double>(std::abs(twice.log_durations[i] - once.log_durations[k] - std::log(1 / 0.8F))));
      EXPECT_LT(nearest, 1e-4);
    }
  }
}

// A full set of markers would take minutes and gigabytes to learn maps from.
TEST_F(GraphReconstructionTest, OfManyMarkersThePrincipalOnesAreUsed) {
  SyntheticGaitTruth truth;
  const MotionClip walk = UnseenWalk(&truth);
  const std::vector<Placement> full = FullBodyMarkers(SourceOf(*graph_).clips);
  ASSERT_GT(full.size(), 30u);
  std::size_t asked = 0;
  const ReconstructedReadings made = ReconstructReadings(*graph_, {.method = ReconstructionMethod::kMarkers, .readings = VirtualMarkers(walk, full), .placements = full},
                                                         [&](const std::vector<Placement>& sensors) {
                                                           asked = sensors.size();
                                                           return MakeReconstructor(graph_, ReconstructionMethod::kMarkers, sensors);
                                                         });
  EXPECT_EQ(asked, 12u);
  EXPECT_EQ(made.sensors.size(), 12u);
  EXPECT_THAT(made.repaired.notes, ::testing::Contains(::testing::HasSubstr("the 12 that say most of the others are used")));
  EXPECT_LT(CompareClips(made.reconstruction.clip, walk).position_rms_cm, 4);
}

TEST_F(GraphReconstructionTest, TellsMarkersFromAccelerations) {
  SyntheticGaitTruth truth;
  const MotionClip walk = UnseenWalk(&truth);
  const Readings accelerations = VirtualAccelerations(walk, FourSensors(), kSensorRate_hz), markers = VirtualMarkers(walk, FourSensors());
  const ReconstructorSource none = [](const std::vector<Placement>&) -> std::shared_ptr<const Reconstructor> { throw std::logic_error("made"); };
  const auto said = [&](ReconstructionMethod method, const Readings& readings) -> std::string {
    try {
      ReconstructReadings(*graph_, {.method = method, .readings = readings, .placements = {}}, none);
    } catch (const DatasetError& error) {
      return error.what();
    } catch (const std::logic_error&) {
      return "taken";
    }
    return "";
  };
  EXPECT_EQ(said(ReconstructionMethod::kOlng, accelerations), "taken");
  EXPECT_EQ(said(ReconstructionMethod::kMarkers, markers), "taken");
  EXPECT_THAT(said(ReconstructionMethod::kOlng, markers), ::testing::HasSubstr("positions of markers"));
  EXPECT_THAT(said(ReconstructionMethod::kMarkers, accelerations), ::testing::HasSubstr("look like accelerations"));
  // In other units, and 9.8 m away from the origin.
  Readings in_g = accelerations, in_mm = markers, far = markers;
  in_g.values /= 9.81;
  in_mm.values *= 1000;
  for (int m = 0; m < far.sensor_count(); ++m) far.values.row(3 * m + 2).array() += 9.8 - far.values.row(3 * m + 2).mean();
  EXPECT_EQ(said(ReconstructionMethod::kOlng, in_g), "taken");
  EXPECT_EQ(said(ReconstructionMethod::kMarkers, in_mm), "taken");
  EXPECT_EQ(said(ReconstructionMethod::kMarkers, far), "taken");
  EXPECT_THAT(said(ReconstructionMethod::kGraph, in_mm), ::testing::HasSubstr("positions of markers"));
  // A stand, then feet that are flung about.
  Readings vigorous = accelerations;
  for (int s = 0; s < vigorous.sensor_count(); ++s) {
    vigorous.values.middleRows<3>(3 * s).leftCols(60).colwise() = Eigen::Vector3d(0, 9.81, 0);
    if (s >= 2) vigorous.values.middleRows<3>(3 * s).rightCols(60) *= 1.7;
  }
  EXPECT_EQ(said(ReconstructionMethod::kOlng, vigorous), "taken");
  // A sensor that is dead does not make markers of the others.
  Readings dead = in_g;
  dead.values.topRows<3>().setZero();
  EXPECT_EQ(said(ReconstructionMethod::kOlng, dead), "taken");
}

TEST_F(GraphReconstructionTest, RefusesWhatIsTooShortOrOfOtherSensors) {
  EXPECT_THROW(ReconstructWalk(*graph_, *sensors_, Eigen::MatrixXd::Zero(12, 3)), std::invalid_argument);
  EXPECT_THROW(ReconstructWalk(*graph_, *sensors_, Eigen::MatrixXd::Zero(9, 60)), std::invalid_argument);
}

TEST_F(GraphReconstructionTest, MakesSomethingOfReadingsThatAreNoWalk) {
  Eigen::MatrixXd readings = Eigen::MatrixXd::Zero(12, 90);
  for (int s = 0; s < 4; ++s) readings.row(3 * s + 1).setConstant(9.81);
  const GraphReconstruction made = ReconstructWalk(*graph_, *sensors_, readings);
  EXPECT_EQ(made.result.clip.frame_count(), 90);
  EXPECT_TRUE(made.result.clip.root_positions().allFinite());
  EXPECT_GT(made.residual_m_s2, 1);  // and says that it does not fit
}

// A step between two captured ones, read without noise, comes out between them.
TEST_F(GraphReconstructionTest, FitsAStepToItsReadings) {
  const StepBank& bank = sensors_->steps().landing(true);
  const int frames = static_cast<int>(std::lround(std::exp(static_cast<double>(bank.log_durations[0])) * kSensorRate_hz));
  // A stream whose samples are those of a captured step, at its phases.
  Eigen::MatrixXd readings(12, 2 * frames);
  const Eigen::MatrixXd samples = bank.readings.col(0).cast<double>().reshaped(12, kPhaseSamples);
  for (int f = 0; f < readings.cols(); ++f) {
    const double at = std::clamp(((f - frames / 2) / static_cast<double>(frames) + kPhaseMargin) / kPhaseSpacing, 0.0, kPhaseSamples - 1.0);
    const int low = std::min(static_cast<int>(at), kPhaseSamples - 2);
    readings.col(f) = (1 - (at - low)) * samples.col(low) + (at - low) * samples.col(low + 1);
  }
  const FittedStep fitted = FitStep(sensors_->steps(), readings, {frames / 2.0 - 0.5 * (frames % 2), frames / 2.0 - 0.5 * (frames % 2) + frames, true}, {.neighbours = 40, .sigma_m_s2 = 0.2});
  const Eigen::MatrixXd wanted = bank.poses.col(0).cast<double>().reshaped(fitted.poses.rows(), kPhaseSamples);
  EXPECT_LT((fitted.poses - wanted).bottomRows(fitted.poses.rows() - 6).cwiseAbs().maxCoeff(), 0.15);
  EXPECT_NEAR(fitted.styles.sum(), 1, 1e-9);
}

}  // namespace
}  // namespace morphograph
