#include "synthesis/window_space.h"

#include <gtest/gtest.h>

#include <boost/random/normal_distribution.hpp>
#include <random>

#include "synthesis/style_classifier.h"

namespace morphograph {
namespace {

Eigen::MatrixXd NormalWindows(const Eigen::VectorXd& mean, const Eigen::VectorXd& deviations, int count,
                              std::mt19937_64& rng) {
  boost::random::normal_distribution<double> normal;
  Eigen::MatrixXd windows(mean.size(), count);
  for (int i = 0; i < count; ++i) {
    for (Eigen::Index d = 0; d < mean.size(); ++d) windows(d, i) = mean[d] + deviations[d] * normal(rng);
  }
  return windows;
}

TEST(WindowSpace, KeepsLeadingDirectionsScaledByTheFirst) {
  std::mt19937_64 rng(11);
  const Eigen::MatrixXd windows =
      NormalWindows(Eigen::Vector4d(1, 2, 3, 4), Eigen::Vector4d(0.1, 4, 1, 2), 20000, rng);
  const WindowSpace space(windows, 3);
  const Eigen::MatrixXd projected = space.Project(windows);
  ASSERT_EQ(projected.rows(), 3);
  EXPECT_LT(projected.rowwise().mean().norm(), 1e-9);
  const Eigen::VectorXd deviations =
      (projected.rowwise().squaredNorm() / static_cast<double>(projected.cols())).cwiseSqrt();
  EXPECT_NEAR(deviations[0], 1, 1e-4);
  EXPECT_NEAR(deviations[1], 0.5, 0.02);
  EXPECT_NEAR(deviations[2], 0.25, 0.02);
  EXPECT_NEAR(space.variance_kept(), 21.0 / 21.01, 1e-4);
}

TEST(WindowSpace, ResidualIsWhatTheDirectionsLeaveOut) {
  std::mt19937_64 rng(15);
  const Eigen::MatrixXd windows =
      NormalWindows(Eigen::Vector3d::Zero(), Eigen::Vector3d(2, 1, 0.1), 5000, rng);
  const WindowSpace space(windows, 2);
  EXPECT_NEAR(space.MeanSquaredResidual(windows), 0.01 / 4, 2e-4);
  Eigen::MatrixXd lifted = windows;
  lifted.row(2).array() += 1;
  EXPECT_NEAR(space.MeanSquaredResidual(lifted), 1.01 / 4, 0.01);
}

TEST(WindowSpace, RefusesWhatHasNoDirection) {
  EXPECT_THROW(WindowSpace(Eigen::MatrixXd::Ones(4, 10)), std::invalid_argument);
  EXPECT_THROW(WindowSpace(Eigen::MatrixXd::Ones(4, 1)), std::invalid_argument);
  Eigen::MatrixXd windows = Eigen::MatrixXd::Identity(4, 4);
  EXPECT_THROW(WindowSpace(windows).Project(Eigen::MatrixXd::Ones(3, 2)), std::invalid_argument);
}

TEST(StyleClassifier, TellsStylesByMeanAndBySpread) {
  std::mt19937_64 rng(12);
  const int size = 6;
  Eigen::VectorXd zero = Eigen::VectorXd::Zero(size), one = Eigen::VectorXd::Ones(size), shifted = zero;
  shifted[2] = 0.5;
  Eigen::VectorXd wide = one;
  wide[4] = 1.5;
  const auto draw = [&](int clips) {
    std::vector<StyledWindows> drawn;
    for (int i = 0; i < clips; ++i) {
      drawn.push_back({"plain", NormalWindows(zero, one, 100, rng)});
      drawn.push_back({"shifted", NormalWindows(shifted, one, 100, rng)});
      drawn.push_back({"wide", NormalWindows(zero, wide, 100, rng)});
    }
    return drawn;
  };
  const std::vector<StyledWindows> seen = draw(30);
  const StyleConfusion confusion = ConfuseStyles(StyleClassifier(seen), draw(30));
  EXPECT_GE(confusion.accuracy, 0.95);
  EXPECT_EQ(confusion.counts.sum(), 90);
  EXPECT_EQ(confusion.styles, (std::vector<std::string>{"plain", "shifted", "wide"}));
  EXPECT_GE(CrossValidateStyles(seen).accuracy, 0.9);
}

TEST(StyleClassifier, IsAtChanceWhereStylesAreTheSame) {
  std::mt19937_64 rng(13);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(6), one = Eigen::VectorXd::Ones(6);
  std::vector<StyledWindows> clips;
  for (int i = 0; i < 200; ++i) clips.push_back({i % 2 ? "a" : "b", NormalWindows(zero, one, 20, rng)});
  EXPECT_NEAR(CrossValidateStyles(clips).accuracy, 0.5, 0.12);
}

TEST(StyleClassifier, RefusesTooLittle) {
  std::mt19937_64 rng(14);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(3), one = Eigen::VectorXd::Ones(3);
  const Eigen::MatrixXd windows = NormalWindows(zero, one, 10, rng);
  EXPECT_THROW(StyleClassifier({{"a", windows}, {"a", windows}}), std::invalid_argument);
  EXPECT_THROW(StyleClassifier({{"a", windows}, {"a", windows}, {"b", windows}}), std::invalid_argument);
  const StyleClassifier classifier({{"a", windows}, {"a", windows}, {"b", windows}, {"b", windows}});
  EXPECT_THROW(classifier.Classify(windows.leftCols(1)), std::invalid_argument);
  EXPECT_THROW(ConfuseStyles(classifier, {{"c", windows}}), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
