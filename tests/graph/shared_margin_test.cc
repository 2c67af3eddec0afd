#include "graph/shared_margin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/support/random_matrix.h"
#include "tests/support/small_model.h"

namespace morphograph {
namespace {

TEST(SharedMarginMap, IsExactWhereTheSharedMotionSaysEverything) {
  std::mt19937_64 rng(3);
  const Eigen::MatrixXd start = testing::RandomNormal(20, 6, rng), wanted = testing::RandomNormal(6, 5, rng);
  EXPECT_LT((SharedMarginMap(start * wanted, start).WithNoise(1e-10) - wanted).norm(), 1e-6);
  // The noisier, the less is believed.
  EXPECT_LT(SharedMarginMap(start * wanted, start).WithNoise(1e3).norm(), 0.1 * wanted.norm());
}

// One is the conditional mean of a joint normal distribution, by another way: w' ~ N(0, I), start w' + e = end w.
TEST(SharedMarginMap, IsTheConditionalMean) {
  std::mt19937_64 rng(4);
  const Eigen::MatrixXd start = testing::RandomNormal(4, 7, rng), end = testing::RandomNormal(4, 5, rng);
  const Eigen::MatrixXd covariance = start * start.transpose() + 0.3 * Eigen::MatrixXd::Identity(4, 4);
  EXPECT_LT((SharedMarginMap(end, start).WithNoise(0.3) - start.transpose() * covariance.inverse() * end).norm(), 1e-10);
}

class SharedMarginOfWalks : public ::testing::Test {
 protected:
  SharedMarginOfWalks() : model_(testing::SmallModel()) {
    for (int e = 0; e < model_->edge_count() && edge_ < 0; ++e) {
      if (model_->edge_from(e) != model_->edge_to(e)) edge_ = e;
    }
    weights_ = Eigen::VectorXd::LinSpaced(model_->layout().channels(), 0.5, 2);
    margin_ = FindSharedMargin(from(), to(), model_->layout(), model_->styles()[static_cast<size_t>(from().style_index)].mean_rotations, weights_);
  }
  const MotionPrimitive& from() const { return model_->primitive(model_->edge_from(edge_)); }
  const MotionPrimitive& to() const { return model_->primitive(model_->edge_to(edge_)); }

  std::shared_ptr<const MotionGraph> model_;
  int edge_ = -1;
  Eigen::VectorXd weights_;
  SharedMargin margin_;
};

TEST_F(SharedMarginOfWalks, HasAJacobianForEveryMixtureComponent) {
  ASSERT_EQ(margin_.end.size(), static_cast<size_t>(from().mixture.size()));
  ASSERT_EQ(margin_.start.size(), static_cast<size_t>(to().mixture.size()));
  EXPECT_EQ(margin_.end.front().cols(), from().reduction.components());
  EXPECT_EQ(margin_.start.front().cols(), to().reduction.components());
  EXPECT_EQ(margin_.end.front().rows(), margin_.start.front().rows());
  EXPECT_TRUE(margin_.end.front().allFinite() && margin_.start.front().allFinite());
}

// At the key frame itself no clock matters: the joints' channels there are a sample of the step's vector, phase 1 of one and phase 0 of the
// other, and its derivative is the basis.
TEST_F(SharedMarginOfWalks, HoldsTheBasisAtTheKeyFrame) {
  const Eigen::Index channels = model_->layout().channels(), joints = channels - 6;
  const Eigen::Index before = 4 + joints + 2 * (7 + joints);  // values at the first three of seven times
  const auto check = [&](const MotionPrimitive& primitive, const Eigen::MatrixXd& jacobian, int sample) {
    ASSERT_NEAR(PhaseOfSample(sample), std::round(PhaseOfSample(sample)), 1e-12);
    const Eigen::MatrixXd basis = primitive.reduction.basis.cast<double>().middleRows(sample * channels + 6, joints);
    const Eigen::MatrixXd expected = weights_.tail(joints).asDiagonal() * basis * primitive.mixture.Component(0).cholesky;
    ASSERT_GT(expected.norm(), 0.01);
    EXPECT_LT((jacobian.middleRows(before + 4, joints) - expected).norm(), 1e-4 * expected.norm());
  };
  check(from(), margin_.end.front(), 20);
  check(to(), margin_.start.front(), 4);
}

}  // namespace
}  // namespace morphograph
