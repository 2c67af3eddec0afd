#include "graph/transition_fit.h"

#include <gtest/gtest.h>

#include <boost/random/uniform_int_distribution.hpp>
#include <random>

#include "primitives/matrix_factors.h"
#include "primitives/whitening.h"
#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

constexpr int kDims = 4;

// A chain of latents x' = B x + noise, so strongly correlated that a plain regression of it would be near instability.
Eigen::MatrixXd Chain(int steps, std::mt19937_64& rng) {
  const Eigen::MatrixXd noise = testing::RandomNormal(kDims, steps, rng);
  Eigen::MatrixXd chain(kDims, steps);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(kDims);
  for (int i = 0; i < steps; ++i) {
    x = 0.9 * x + noise.col(i);
    x[1] += 0.2 * x[0];
    chain.col(i) = x;
  }
  return chain;
}

GaussianMixture OneGaussian(const Eigen::MatrixXd& samples) {
  std::mt19937_64 rng(1);
  return FitGaussianMixture(samples, 1, CovarianceForm::kFull, {}, rng).mixture;
}

struct Fitted {
  GaussianMixture mixture;
  TransitionModel model;
};

Fitted FitChain(int steps) {
  std::mt19937_64 rng(5);
  const Eigen::MatrixXd chain = Chain(steps, rng);
  Fitted fitted{OneGaussian(chain), {}};
  fitted.model = FitTransition({chain.leftCols(steps - 1), chain.rightCols(steps - 1), {}, {}}, fitted.mixture, fitted.mixture);
  return fitted;
}

TEST(TransitionFit, WalkingOnForTwoHundredStepsKeepsTheCapturedMarginal) {
  const Fitted fitted = FitChain(400);
  std::mt19937_64 rng(7);
  boost::random::uniform_int_distribution<int> pick(0, static_cast<int>(fitted.model.residuals.cols()) - 1);
  Eigen::MatrixXd late(kDims, 2000);
  for (int walk = 0; walk < late.cols(); ++walk) {
    Eigen::VectorXd w = testing::RandomNormal(kDims, 1, rng);
    for (int step = 0; step < 200; ++step) w = fitted.model.Mean(w) + fitted.model.residuals.col(pick(rng)).cast<double>();
    late.col(walk) = w;
  }
  const Eigen::VectorXd mean = late.rowwise().mean();
  const Eigen::MatrixXd centred = late.colwise() - mean;
  const Eigen::MatrixXd covariance = centred * centred.transpose() / static_cast<double>(late.cols());
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 0.2);
  for (int d = 0; d < kDims; ++d) {
    EXPECT_GT(std::sqrt(covariance(d, d)), 0.9) << d;
    EXPECT_LT(std::sqrt(covariance(d, d)), 1.1) << d;
  }
}

// Pairs of nine clips in six copies each. Their next latents follow no function of the ones before, but the copies of a clip
// are near each other: whoever judges by them believes that everything can be told.
TransitionPairs Copies(int dims, std::mt19937_64& rng) {
  constexpr int kClips = 9, kPairs = 6, kCopies = 6;
  TransitionPairs pairs{Eigen::MatrixXd(dims, kClips * kPairs * kCopies), Eigen::MatrixXd(dims, kClips * kPairs * kCopies), {}, {}};
  int column = 0;
  for (int clip = 0; clip < kClips; ++clip) {
    for (int i = 0; i < kPairs; ++i) {
      const Eigen::VectorXd previous = testing::RandomNormal(dims, 1, rng), next = testing::RandomNormal(dims, 1, rng);
      for (int copy = 0; copy < kCopies; ++copy, ++column) {
        pairs.previous.col(column) = previous + 0.2 * testing::RandomNormal(dims, 1, rng);
        pairs.next.col(column) = next + 0.2 * testing::RandomNormal(dims, 1, rng);
        pairs.clip.push_back(clip);
        pairs.made.push_back(copy > 0);
      }
    }
  }
  return pairs;
}

TEST(TransitionFit, CopiesOfAClipAreNoEvidenceForEachOther) {
  std::mt19937_64 rng(21);
  const TransitionPairs pairs = Copies(12, rng);
  const GaussianMixture mixture = OneGaussian(pairs.next);
  EXPECT_FALSE(FitTransition(pairs, mixture, mixture).process);
  EXPECT_GT(FitTransition(pairs, mixture, mixture).unseen_error, 0.9);
  // The same pairs, each on its own, look as if they could be told almost entirely.
  const TransitionPairs blind{pairs.previous, pairs.next, {}, {}};
  EXPECT_TRUE(FitTransition(blind, mixture, mixture).process);
  EXPECT_LT(FitTransition(blind, mixture, mixture).unseen_error, 0.3);
}

// Neighbours share `values` values of their motion: start w' = end w.
struct SharingPairs {
  TransitionPairs pairs;
  SharedMargin margin;
  GaussianMixture source, target;
};

SharingPairs PairsThatShare(int dims, int values, int count, std::mt19937_64& rng) {
  const Eigen::MatrixXd end = testing::RandomNormal(values, dims, rng), start = testing::RandomNormal(values, dims, rng);
  const Eigen::MatrixXd previous = testing::RandomNormal(dims, count, rng);
  Eigen::MatrixXd next = testing::RandomNormal(dims, count, rng);
  // The part of `next` that is shared is as `previous` has it.
  const Eigen::MatrixXd fit = start.transpose() * (start * start.transpose()).inverse();
  next += fit * (end * previous - start * next);
  const GaussianMixture source = OneGaussian(previous), target = OneGaussian(next);
  return {{previous, next, {}, {}}, {{end * source.Component(0).cholesky}, {start * target.Component(0).cholesky}}, source, target};
}

TEST(TransitionFit, SharedMotionTellsWhatTooFewPairsCannot) {
  std::mt19937_64 rng(31);
  const SharingPairs few = PairsThatShare(24, 12, 40, rng);
  const double by_pairs = FitTransition(few.pairs, few.source, few.target).unseen_error;
  const double by_both = FitTransition(few.pairs, few.source, few.target, {.margin = few.margin}).unseen_error;
  EXPECT_GT(by_pairs, 0.7);
  EXPECT_LT(by_both, 0.75 * by_pairs);
}

TEST(TransitionFit, SharedMotionThatIsWrongIsNotBelieved) {
  std::mt19937_64 rng(32);
  SharingPairs few = PairsThatShare(24, 12, 40, rng);
  few.margin.end.front() = testing::RandomNormal(12, 24, rng);
  const double by_pairs = FitTransition(few.pairs, few.source, few.target).unseen_error;
  EXPECT_LE(FitTransition(few.pairs, few.source, few.target, {.margin = few.margin}).unseen_error, by_pairs);
}

// Next latents bend with the ones before, so that the RBF part has something to tell.
TEST(TransitionFit, KeepsTheMarginalWithAnRbfPartToo) {
  constexpr int kWalks = 500;
  std::mt19937_64 rng(23);
  Eigen::MatrixXd chain(2, 400);
  Eigen::Vector2d x(0.3, 0);
  for (int i = 0; i < chain.cols(); ++i) {
    x = Eigen::Vector2d(1.6 * std::sin(2 * x[0]) + 0.1 * x[1], 0.5 * x[0]) + 0.2 * testing::RandomNormal(2, 1, rng);
    chain.col(i) = x;
  }
  const GaussianMixture mixture = OneGaussian(chain);
  const TransitionModel model = FitTransition({chain.leftCols(399), chain.rightCols(399), {}, {}}, mixture, mixture);
  ASSERT_TRUE(model.process);
  boost::random::uniform_int_distribution<int> pick(0, static_cast<int>(model.residuals.cols()) - 1);
  Eigen::MatrixXd late(2, kWalks);
  for (int walk = 0; walk < kWalks; ++walk) {
    Eigen::VectorXd w = testing::RandomNormal(2, 1, rng);
    for (int step = 0; step < 200; ++step) w = model.Mean(w) + model.residuals.col(pick(rng)).cast<double>();
    late.col(walk) = w;
  }
  const Eigen::MatrixXd centred = late.colwise() - late.rowwise().mean();
  const double variance = centred.squaredNorm() / static_cast<double>(centred.size());
  EXPECT_NEAR(variance, 1, 0.15);  // noise is matched for normal latents, and these are bent
}

TEST(TransitionFit, LinearPartNeverGrowsAVector) {
  const Fitted fitted = FitChain(60);
  const double largest = FactorSingular(fitted.model.linear.cast<double>()).values[0];
  EXPECT_LE(largest, 0.97 + 1e-5);
  EXPECT_GT(largest, 0.3) << "the chain's correlation was not learned";
}

TEST(TransitionFit, PredictsBetterThanTheMarginal) {
  const Fitted fitted = FitChain(400);
  std::mt19937_64 rng(11);
  const Eigen::MatrixXd unseen = Chain(400, rng);
  double with = 0, without = 0;
  for (int i = 50; i + 1 < unseen.cols(); ++i) {
    const MixtureComponent& component = fitted.mixture.Component(0);
    const Eigen::VectorXd next = Whiten(component, unseen.col(i + 1));
    with += (next - fitted.model.Mean(Whiten(component, unseen.col(i)))).squaredNorm();
    without += next.squaredNorm();
  }
  EXPECT_LT(with, 0.5 * without);
}

TEST(TransitionFit, ComponentChancesFollowTheCapture) {
  // Two well separated components that always alternate.
  std::mt19937_64 rng(3);
  Eigen::MatrixXd chain = 0.1 * testing::RandomNormal(2, 200, rng);
  for (int i = 0; i < chain.cols(); i += 2) chain(0, i) += 10;
  std::mt19937_64 em(1);
  const GaussianMixture mixture = FitGaussianMixture(chain, 2, CovarianceForm::kDiagonal, {}, em).mixture;
  ASSERT_EQ(mixture.size(), 2);
  const TransitionModel model = FitTransition({chain.leftCols(199), chain.rightCols(199), {}, {}}, mixture, mixture);
  for (int c = 0; c < 2; ++c) {
    EXPECT_NEAR(model.component_chances.row(c).sum(), 1, 1e-12);
    EXPECT_GT(model.component_chances(c, 1 - c), 0.95);
  }
}

TEST(TransitionFit, RefusesPairsThatDoNotFit) {
  std::mt19937_64 rng(5);
  const Eigen::MatrixXd chain = Chain(50, rng);
  const GaussianMixture mixture = OneGaussian(chain);
  EXPECT_THROW(FitTransition({Eigen::MatrixXd(kDims, 0), Eigen::MatrixXd(kDims, 0), {}, {}}, mixture, mixture), std::invalid_argument);
  EXPECT_THROW(FitTransition({chain, chain.leftCols(10), {}, {}}, mixture, mixture), std::invalid_argument);
  EXPECT_THROW(FitTransition({chain.topRows(2), chain.topRows(2), {}, {}}, mixture, mixture), std::invalid_argument);
  EXPECT_THROW(FitTransition({chain, chain, {1, 2}, {}}, mixture, mixture), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
