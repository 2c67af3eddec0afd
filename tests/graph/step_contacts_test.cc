#include "graph/step_contacts.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/random_matrix.h"
#include "tests/support/small_model.h"

namespace morphograph {
namespace {

TEST(MeanContacts, TakesHeightsOfPlantedFeetAlone) {
  std::vector<ContactProfile> steps(4, ContactProfile::Zero(kContactRows, kPhaseSamples));
  for (int i = 0; i < 4; ++i) steps[i].row(kPlantedHeight).setConstant(0.01 * i);
  steps[1](kPlantedChance, 3) = steps[2](kPlantedChance, 3) = 1;
  const ContactProfile mean = MeanContacts(steps);
  EXPECT_DOUBLE_EQ(mean(kPlantedChance, 3), 0.5);
  EXPECT_NEAR(mean(kPlantedHeight, 3), 0.015, 1e-12);
  EXPECT_EQ(mean(kPlantedChance, 4), 0);
  EXPECT_NEAR(mean(kPlantedHeight, 4), 0.015, 1e-12);  // never planted: of all
  steps[2](kPlantedChance, 3) = 0;
  EXPECT_NEAR(MeanContacts(steps)(kPlantedHeight, 3), 0.01, 1e-12);
  EXPECT_THROW(MeanContacts({}), std::invalid_argument);
}

// Steps of 20 clips whose left ball moves by a linear function of the latent while planted, and whose right ball by chance.
class ContactMapOfSteps : public ::testing::Test {
 protected:
  ContactMapOfSteps() {
    std::mt19937_64 rng(7);
    latents_ = testing::RandomNormal(5, 200, rng);
    truth_ = testing::RandomNormal(kPhaseSamples, 5, rng) * 0.01;
    const Eigen::MatrixXd noise = testing::RandomNormal(kPhaseSamples, 200, rng) * 0.01;
    for (int i = 0; i < 200; ++i) {
      ContactProfile step = ContactProfile::Zero(kContactRows, kPhaseSamples);
      step.row(kPlantedChance + kBall).setOnes();
      step.row(kPlantedChance + kOther).setOnes();
      step.row(kPlantedHeight + kBall) = (truth_ * latents_.col(i)).transpose();
      step.row(kPlantedHeight + kOther) = noise.col(i).transpose();
      step.row(kSlideForward).setConstant(latents_(0, i));  // of a heel that is never planted
      steps_.push_back(step);
      clips_.push_back(i / 10);
    }
  }
  Eigen::MatrixXf Map() const { return FitStepContacts(steps_, latents_, clips_).map; }
  static auto RowOf(const Eigen::MatrixXf& map, int sample, int row) { return map.row(sample * kContactRows + row).cast<double>(); }

  static constexpr int kBall = 1, kOther = 3;
  Eigen::MatrixXd latents_, truth_;
  std::vector<ContactProfile> steps_;
  std::vector<int> clips_;
};

TEST_F(ContactMapOfSteps, FindsWhatFollowsFromTheLatentAndNothingElse) {
  const Eigen::MatrixXf map = Map();
  ASSERT_EQ(map.rows(), kContactRows * kPhaseSamples);
  ASSERT_EQ(map.cols(), 5);
  for (int sample = 0; sample < kPhaseSamples; ++sample) {
    EXPECT_LT((RowOf(map, sample, kPlantedHeight + kBall) - truth_.row(sample)).norm(), 0.05 * truth_.row(sample).norm()) << sample;
    EXPECT_EQ(RowOf(map, sample, kPlantedHeight + kOther).norm(), 0) << sample;
    EXPECT_EQ(RowOf(map, sample, kPlantedChance + kBall).norm(), 0) << sample;
    EXPECT_EQ(RowOf(map, sample, kSlideForward).norm(), 0) << sample;
  }
}

// A turning step lifts its heel while a straight one still stands on it: the heel in the air says nothing of how heels stand.
TEST_F(ContactMapOfSteps, HearsOfHeightsFromPlantedFeetAloneAndSaysWhichStepsPlantThem) {
  const Eigen::VectorXd way = Eigen::VectorXd::LinSpaced(5, 1, 2).normalized();
  for (int i = 0; i < 200; ++i) {
    ContactProfile& step = steps_[static_cast<size_t>(i)];
    if (way.dot(latents_.col(i)) > -0.5) continue;
    step.row(kPlantedChance + kBall).setZero();
    step.row(kPlantedHeight + kBall).array() += 0.5;
  }
  const StepContacts told = FitStepContacts(steps_, latents_, clips_);
  for (int sample = 0; sample < kPhaseSamples; ++sample) {
    const int height = kPlantedHeight + kBall;
    EXPECT_LT((RowOf(told.map, sample, height) - truth_.row(sample)).norm(), 0.06 * truth_.row(sample).norm()) << sample;
    EXPECT_NEAR(told.at_zero(height, sample), 0, 0.06 * truth_.row(sample).norm()) << sample;
    const Eigen::VectorXd chance = RowOf(told.map, sample, kPlantedChance + kBall).transpose();
    EXPECT_GT(chance.dot(way), 0.95 * chance.norm()) << sample;
    EXPECT_GT(told.at_zero(kPlantedChance + kBall, sample) + chance.dot(way), 0.85) << sample;
    EXPECT_LT(told.at_zero(kPlantedChance + kBall, sample) - 2 * chance.dot(way), 0.25) << sample;
  }
}

// What all steps of a clip share by chance is no evidence of anything.
TEST_F(ContactMapOfSteps, IsNotTaughtByClipsThatItIsJudgedBy) {
  const std::vector<int> clips = clips_;
  double judged = 0, believed = 0;
  for (unsigned seed = 0; seed < 5; ++seed) {
    std::mt19937_64 rng(seed);
    const Eigen::MatrixXd of_clip = testing::RandomNormal(1, 20, rng), places = testing::RandomNormal(5, 20, rng);
    for (int i = 0; i < 200; ++i) {
      latents_.col(i) = places.col(clips[static_cast<size_t>(i)]);
      steps_[static_cast<size_t>(i)].row(kPlantedHeight + kBall).setConstant(of_clip(0, clips[static_cast<size_t>(i)]));
    }
    clips_ = clips;
    judged += RowOf(Map(), 0, kPlantedHeight + kBall).norm();
    for (int i = 0; i < 200; ++i) clips_[static_cast<size_t>(i)] = i;  // as if every step were on its own
    believed += RowOf(Map(), 0, kPlantedHeight + kBall).norm();
  }
  EXPECT_LT(judged, 0.3 * believed);
}

TEST_F(ContactMapOfSteps, NeedsAClipOfEveryStep) {
  clips_.pop_back();
  EXPECT_THROW(Map(), std::invalid_argument);
}

TEST(ContactMap, AddsWhatTheLatentTells) {
  const auto model = testing::SmallModel();
  const MotionPrimitive& primitive = model->primitive(0);
  EXPECT_EQ(primitive.Contacts({}), primitive.contacts);
  EXPECT_THROW(primitive.Contacts(Eigen::VectorXd::Zero(1)), std::invalid_argument);
  const ContactProfile told = primitive.Contacts(Eigen::VectorXd::Zero(primitive.reduction.components()));
  EXPECT_EQ(told, primitive.contacts);
  MotionPrimitive other = primitive;
  other.contact_map = Eigen::MatrixXf::Zero(kContactRows * kPhaseSamples, primitive.reduction.components());
  other.contact_map(kContactRows * 4 + kSlideLeft, 0) = 2;
  other.contact_map(kContactRows * 5 + kPlantedChance, 0) = 9;
  other.contact_map(kContactRows * 6 + kPlantedChance, 0) = -9;
  Eigen::VectorXd latent = Eigen::VectorXd::Zero(primitive.reduction.components());
  latent[0] = 0.5;
  ContactProfile wanted = primitive.contacts;
  wanted(kSlideLeft, 4) += 1;
  wanted(kPlantedChance, 5) = 1;
  wanted(kPlantedChance, 6) = 0;
  EXPECT_LT((other.Contacts(latent) - wanted).norm(), 1e-6);
}

}  // namespace
}  // namespace morphograph
