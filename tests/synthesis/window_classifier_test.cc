#include "synthesis/window_classifier.h"

#include <gtest/gtest.h>

#include <cmath>

#include "synthesis/evaluation_motion.h"
#include "synthesis/pose_windows.h"
#include "synthesis/random_forest.h"
#include "tests/support/random_matrix.h"
#include "tests/synthesis/gait_clips.h"

namespace morphograph {
namespace {

using testing::RandomNormal;

// Clips of windows of 6 normal values each; `shift` moves the first.
std::vector<Eigen::MatrixXd> RandomClips(int clips, int windows, double shift, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::vector<Eigen::MatrixXd> set;
  for (int c = 0; c < clips; ++c) {
    set.push_back(RandomNormal(6, windows, rng));
    set.back().row(0).array() += shift;
  }
  return set;
}

TEST(AreaUnderCurve, CountsPairsWithTiesHalf) {
  EXPECT_DOUBLE_EQ(AreaUnderCurve({1, 2, 3}, {4, 5}), 1);
  EXPECT_DOUBLE_EQ(AreaUnderCurve({4, 5}, {1, 2, 3}), 0);
  EXPECT_DOUBLE_EQ(AreaUnderCurve({1, 1}, {1, 1, 1}), 0.5);
  // Pairs: 2 > 1, 2 = 2, 2 < 3; 3 > 1, 3 > 2, 3 = 3.
  EXPECT_DOUBLE_EQ(AreaUnderCurve({1, 2, 3}, {2, 3}), 4.0 / 6);
  EXPECT_THROW(AreaUnderCurve({}, {1}), std::invalid_argument);
}

TEST(CrossValidatedAuc, IsHalfForEqualDistributions) {
  // Standard deviation of an area from n against n scores of no worth: sqrt((2 n + 1) / (12 n^2)), here 0.024.
  const double auc = CrossValidatedAuc(RandomClips(10, 30, 0, 1), RandomClips(10, 30, 0, 2));
  const double n = 300;
  EXPECT_NEAR(auc, 0.5, 3 * std::sqrt((2 * n + 1) / (12 * n * n)));
}

TEST(CrossValidatedAuc, OfShiftedGaussiansIsNearTheBestPossible) {
  // The best score is the shifted value itself: chance that N(d, 1) exceeds N(0, 1) is Phi(d / sqrt 2).
  const double shift = 1.5, best = 0.5 * std::erfc(-shift / 2);
  const double auc = CrossValidatedAuc(RandomClips(10, 40, 0, 3), RandomClips(10, 40, shift, 4));
  EXPECT_NEAR(best, 0.856, 0.001);
  EXPECT_LT(auc, best + 0.03);  // two standard deviations
  EXPECT_GT(auc, best - 0.06);  // five idle values beside it cost a forest something
}

TEST(CrossValidatedAuc, KeepsAClipTogether) {
  // Every clip has a place of its own, equally distributed in both sets: only a forest that has seen windows of the
  // very clip that it judges could tell the sets apart.
  std::mt19937_64 rng(5);
  std::vector<Eigen::MatrixXd> sets[2];
  for (auto& set : sets) {
    for (int c = 0; c < 15; ++c) set.push_back((0.01 * RandomNormal(6, 30, rng)).colwise() + Eigen::VectorXd(RandomNormal(6, 1, rng)));
  }
  EXPECT_LT(CrossValidatedAuc(sets[0], sets[1]), 0.75);
}

TEST(CrossValidatedAuc, DependsOnTheSeedAndNotOnThreads) {
  const auto first = RandomClips(6, 20, 0, 6), second = RandomClips(7, 25, 0.5, 7);
  const double auc = CrossValidatedAuc(first, second, {.trees = 20});
  EXPECT_EQ(auc, CrossValidatedAuc(first, second, {.trees = 20, .jobs = 3}));
  EXPECT_NE(auc, CrossValidatedAuc(first, second, {.trees = 20, .seed = 2}));
}

TEST(CrossValidatedAuc, RejectsSetsThatCannotFillTheFolds) {
  EXPECT_THROW(CrossValidatedAuc(RandomClips(4, 20, 0, 8), RandomClips(9, 20, 0, 9)), std::invalid_argument);
  auto short_clips = RandomClips(5, 20, 0, 8);
  short_clips[0].resize(6, 0);
  EXPECT_THROW(CrossValidatedAuc(RandomClips(9, 20, 0, 9), short_clips), std::invalid_argument);
  EXPECT_THROW(CrossValidatedAuc(RandomClips(9, 20, 0, 9), {5, Eigen::MatrixXd::Zero(7, 3)}), std::invalid_argument);
}

TEST(RandomForest, LearnsWhatNoSingleFeatureTells) {
  // Exclusive or of two signs: no split of the first node helps, trees that grow on find it.
  std::mt19937_64 rng(10);
  const Eigen::MatrixXf samples = RandomNormal(4, 1200, rng).cast<float>();
  std::vector<char> labels;
  for (Eigen::Index i = 0; i < samples.cols(); ++i) labels.push_back((samples(0, i) > 0) != (samples(2, i) > 0));
  const RandomForest forest(samples.leftCols(800), {labels.begin(), labels.begin() + 800}, {}, rng);
  const Eigen::VectorXd scores = forest.Predict(samples.rightCols(400));
  int right = 0;
  for (int i = 0; i < 400; ++i) right += (scores[i] > 0.5) == (labels[static_cast<size_t>(800 + i)] == 1);
  EXPECT_GT(right, 360);
  EXPECT_GE(scores.minCoeff(), 0);
  EXPECT_LE(scores.maxCoeff(), 1);
}

TEST(RandomForest, GivesTheShareOfAClassWhereNothingTellsSamplesApart) {
  std::mt19937_64 rng(11);
  std::vector<char> labels(400, 0);
  std::fill(labels.begin(), labels.begin() + 100, 1);
  const RandomForest forest(Eigen::MatrixXf::Constant(3, 400, 2.5f), labels, {}, rng);
  EXPECT_NEAR(forest.Predict(Eigen::MatrixXf::Constant(3, 1, 2.5f))[0], 0.25, 0.01);
}

TEST(RandomForest, RejectsWhatItCannotLearnFrom) {
  std::mt19937_64 rng(12);
  const Eigen::MatrixXf samples = RandomNormal(3, 4, rng).cast<float>();
  EXPECT_THROW(RandomForest(samples, {0, 1}, {}, rng), std::invalid_argument);
  EXPECT_THROW(RandomForest(samples, {1, 1, 1, 1}, {}, rng), std::invalid_argument);
  EXPECT_THROW(RandomForest(samples, {0, 1, 0, 1}, {.features = 4}, rng), std::invalid_argument);
  EXPECT_THROW(RandomForest(samples, {0, 1, 0, 1}, {}, rng).Predict(Eigen::MatrixXf::Zero(2, 1)), std::invalid_argument);
}

TEST(NoisyPoseWindows, PutsTheStatedNoiseOnJointsRelativeToTheHips) {
  const MotionClip clip = testing::GaitClip(1);
  const Eigen::MatrixXd clean = PoseWindows(PrepareEvaluation(clip));
  EXPECT_EQ(NoisyPoseWindows(clip, 0, 1), clean);
  const double noise = 0.001;
  const Eigen::MatrixXd error = NoisyPoseWindows(clip, noise, 1) - clean;
  // The height of the head (joint 8 of the roles, its second value) has its own noise alone; a height is not relative to the hips.
  const auto deviation = [&](Eigen::Index value) { return std::sqrt(error.row(value).squaredNorm() / static_cast<double>(error.cols())); };
  const double spread = 3 / std::sqrt(2.0 * static_cast<double>(error.cols()));
  EXPECT_NEAR(deviation(3 * 8 + 1) / noise, 1, spread);
  // Forward of a joint over the hips: its noise and theirs.
  EXPECT_NEAR(deviation(3 * 8 + 2) / (noise * std::sqrt(2)), 1, spread);
  // Forward speed: central differences over two frames.
  EXPECT_NEAR(deviation(44 + 43) / (noise * std::sqrt(2) * 15), 1, spread);
}

TEST(TellApart, TellsANoisySetAndNotAHalf) {
  // One population of walks: half of it as "captured", half as "synthesised".
  const auto captured = testing::GaitClips(1, 12, [](SyntheticGaitOptions&) {});
  const auto same = testing::GaitClips(101, 12, [](SyntheticGaitOptions&) {});
  const auto faster = testing::GaitClips(201, 12, [](SyntheticGaitOptions& options) { options.speed_m_s += 0.5; });
  const WindowClassifierOptions options{.trees = 30, .halvings = 2, .jobs = 2};
  const WindowDistinction alike = TellApart(same, captured, options);
  EXPECT_NEAR(alike.difference, 0, 0.2);
  EXPECT_GT(alike.standard_error, 0);
  const WindowDistinction unlike = TellApart(faster, captured, options);
  EXPECT_GT(unlike.auc, 0.95);
  EXPECT_EQ(unlike.floor, alike.floor);  // of the captured clips alone
  EXPECT_DOUBLE_EQ(unlike.difference, unlike.auc - unlike.floor);
  EXPECT_THROW(TellApart({}, captured, options), std::invalid_argument);
  EXPECT_THROW(TellApart(same, {captured.begin(), captured.begin() + 8}, options), std::invalid_argument);
}

TEST(AreaAgainstHalf, IsTheFirstComparisonOfTellApart) {
  const auto captured = testing::GaitClips(1, 12, [](SyntheticGaitOptions&) {});
  const auto drawn = testing::GaitClips(101, 9, [](SyntheticGaitOptions& options) { options.speed_m_s += 0.1; });
  const ClipHalves halving = {{0, 2, 4, 6, 8, 10}, {1, 3, 5, 7, 9, 11}};
  WindowClassifierOptions options{.trees = 30, .jobs = 2};
  const double area = AreaAgainstHalf(drawn, captured, halving, options);
  EXPECT_EQ(area, HalvedCapture(captured, {halving}, options).Tell(drawn).auc);
  options.jobs = 1;
  EXPECT_EQ(area, AreaAgainstHalf(drawn, captured, halving, options));
  EXPECT_THROW(AreaAgainstHalf({}, captured, halving, options), std::invalid_argument);
}

// What makes a model of one half easier to tell from the other half than captured clips are: it draws from the same few clips over and over.
TEST(AreaAgainstHalf, KnowsAFewClipsAgainThatAreDrawnOverAndOver) {
  // Speeds between which nothing lies: no clip of the one half is like one of the other.
  std::vector<MotionClip> captured, few;
  for (int i = 0; i < 20; ++i)
    captured.push_back(testing::GaitClips(static_cast<unsigned>(1 + i), 1, [&](SyntheticGaitOptions& options) { options.speed_m_s = 0.8 + 0.03 * i; }).front());
  ClipHalves halving;
  for (int i = 0; i < 20; ++i) (i % 2 == 0 ? halving.first : halving.second).push_back(i);
  for (int i = 0; i < 20; ++i) few.push_back(captured[i % 2 == 0 ? 4 : 12]);
  const WindowClassifierOptions options{.trees = 60, .jobs = 2};
  const WindowDistinction once = HalvedCapture(captured, {halving}, options).Tell(captured);
  EXPECT_GT(AreaAgainstHalf(few, captured, halving, options), once.floor + 0.15);
}

}  // namespace
}  // namespace morphograph
