// Each part that a variant leaves out is gone from the model, and nothing else fails for it.

#include "graph/training_variant.h"

#include <gtest/gtest.h>

#include <cmath>

#include "graph/graph_builder.h"
#include "graph/model_io.h"
#include "graph/walk_boundary.h"
#include "primitives/step_vector.h"
#include "tests/support/random_matrix.h"
#include "tests/support/small_model.h"

namespace morphograph {
namespace {

std::shared_ptr<const MotionGraph> Learn(const TrainingVariant& variant) {
  std::vector<TrainingClip> clips;
  for (auto& [name, clip] : testing::SmallWalks()) clips.push_back({std::move(clip), true});
  TrainingOptions options;
  options.name = "walk";
  options.variant = variant;
  return BuildGraph(clips, options);
}

double DurationSpread(const MotionGraph& graph, int primitive) {
  std::mt19937_64 rng(1);
  double least = 1e9, most = 0;
  for (int i = 0; i < 20; ++i) {
    const double duration = graph.primitive(primitive).Shape(testing::RandomNormal(graph.primitive(primitive).reduction.components(), 1, rng)).duration_s;
    least = std::min(least, duration), most = std::max(most, duration);
  }
  return most / least;
}

TEST(TrainingVariant, AsItStandsChangesNothing) {
  EXPECT_EQ(Learn({})->hash(), testing::SmallModel()->hash());
}

TEST(TrainingVariant, WithoutTimingMarginsAndTransition) {
  const auto full = testing::SmallModel();
  const auto graph = Learn({.timing = false, .margins = false, .transition = TrainingVariant::Transition::kNone});
  const Eigen::VectorXd weights = StepWeights(graph->layout().ChannelWeights(graph->styles().front().mean_rotations));
  for (int p = 0; p < graph->primitive_count(); ++p) {
    EXPECT_NEAR(DurationSpread(*graph, p), 1, 1e-6) << graph->primitive(p).name;
  }
  EXPECT_GT(DurationSpread(*full, 0), 1.001);
  // Weighted, a basis vector has length 1; the variant's has it within the step.
  const int channels = graph->layout().channels();
  const Eigen::VectorXd inside = graph->primitive(0).reduction.basis.col(0).cast<double>().cwiseProduct(weights).segment(4 * channels, 17 * channels);
  EXPECT_NEAR(inside.squaredNorm(), 1, 1e-3);
  const Eigen::VectorXd usual = full->primitive(0).reduction.basis.col(0).cast<double>().cwiseProduct(weights).segment(4 * channels, 17 * channels);
  EXPECT_LT(usual.squaredNorm(), 0.98);
  for (int e = 0; e < graph->edge_count(); ++e) {
    const TransitionModel& model = graph->transition(e);
    EXPECT_EQ(model.linear.cwiseAbs().maxCoeff(), 0);
    EXPECT_FALSE(model.process.has_value());
    EXPECT_EQ(model.residuals.cols(), 0);
    EXPECT_TRUE(model.noise_cholesky.isApprox(Eigen::MatrixXd::Identity(model.noise_cholesky.rows(), model.noise_cholesky.rows()), 1e-3));
  }
}

TEST(TrainingVariant, UnweightedWithTheProcessAlone) {
  const auto graph = Learn({.weighted = false, .transition = TrainingVariant::Transition::kProcessOnly});
  const Eigen::VectorXd alike = StepWeights(Eigen::VectorXd::Ones(graph->layout().channels()));
  const Eigen::MatrixXd basis = alike.asDiagonal() * graph->primitive(0).reduction.basis.cast<double>();
  const Eigen::MatrixXd products = basis.transpose() * basis;
  EXPECT_LT((products - Eigen::MatrixXd::Identity(products.rows(), products.cols())).cwiseAbs().maxCoeff(), 0.01);
  int steady = 0;
  for (int e = 0; e < graph->edge_count(); ++e) {
    const TransitionModel& model = graph->transition(e);
    EXPECT_EQ(model.linear.cwiseAbs().maxCoeff(), 0);
    EXPECT_EQ(model.residuals.cols(), model.pairs);
    if (!IsSteady(graph->primitive(graph->edge_from(e))) || !IsSteady(graph->primitive(graph->edge_to(e)))) continue;
    EXPECT_TRUE(model.process.has_value());
    ++steady;
  }
  EXPECT_GT(steady, 0);
}

TEST(TrainingVariant, PooledStylesInEulerAngles) {
  const auto graph = Learn({.styles = false, .euler = true});
  ASSERT_EQ(graph->styles().size(), 1u);
  EXPECT_EQ(graph->styles()[0].name, "");
  EXPECT_EQ(graph->layout().rotation_form(), RotationForm::kEuler);
  const std::string bytes = SerialiseModel(*graph);
  const auto read = ParseModel(bytes, "some.mgm");
  EXPECT_EQ(read->layout().rotation_form(), RotationForm::kEuler);
  EXPECT_EQ(SerialiseModel(*read), bytes);
  EXPECT_EQ(ParseModel(SerialiseModel(*testing::SmallModel()), "some.mgm")->layout().rotation_form(), RotationForm::kLogMap);
}

TEST(PoseLayout, GivesRotationsBackInEitherForm) {
  const auto skeleton = testing::SmallModel()->shared_skeleton();
  const std::vector<int>& joints = testing::SmallModel()->layout().active_joints();
  std::mt19937_64 rng(3);
  for (const RotationForm form : {RotationForm::kLogMap, RotationForm::kEuler}) {
    const PoseLayout layout(skeleton, joints, form);
    const Eigen::Quaterniond mean = testing::RandomRotation(rng);
    Eigen::Vector3d previous = Eigen::Vector3d::Zero();
    for (int i = 0; i < 20; ++i) {
      const Eigen::Quaterniond rotation = testing::RandomRotation(rng);
      const Eigen::Vector3d channels = layout.ChannelsOf(1, mean, rotation, previous);
      EXPECT_LT(layout.RotationOf(1, mean, channels).angularDistance(rotation), 1e-7);
      if (form == RotationForm::kEuler) {
        EXPECT_LE((channels - previous).cwiseAbs().maxCoeff(), 1.5 * M_PI + 1e-9);
      }
      previous = channels;
    }
  }
}

}  // namespace
}  // namespace morphograph
