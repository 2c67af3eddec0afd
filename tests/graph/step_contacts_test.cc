#include "graph/step_contacts.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/random_matrix.h"
#include "tests/support/small_model.h"

namespace morphograph {
namespace {

constexpr int kMotionRows = kContactRows - kFootParts;

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
  Eigen::MatrixXf Map() const { return FitContactMap(steps_, ContactProfile::Zero(kContactRows, kPhaseSamples), latents_, clips_); }

  static constexpr int kBall = 1, kOther = 3;
  Eigen::MatrixXd latents_, truth_;
  std::vector<ContactProfile> steps_;
  std::vector<int> clips_;
};

TEST_F(ContactMapOfSteps, FindsWhatFollowsFromTheLatentAndNothingElse) {
  const Eigen::MatrixXf map = Map();
  ASSERT_EQ(map.rows(), kMotionRows * kPhaseSamples);
  ASSERT_EQ(map.cols(), 5);
  for (int sample = 0; sample < kPhaseSamples; ++sample) {
    const auto row = [&](int of_profile) { return map.row(sample * kMotionRows + of_profile - kFootParts).cast<double>(); };
    EXPECT_LT((row(kPlantedHeight + kBall) - truth_.row(sample)).norm(), 0.05 * truth_.row(sample).norm()) << sample;
    EXPECT_EQ(row(kPlantedHeight + kOther).norm(), 0) << sample;
    EXPECT_EQ(row(kSlideForward).norm(), 0) << sample;
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
    judged += Map().row(kBall).norm();
    for (int i = 0; i < 200; ++i) clips_[static_cast<size_t>(i)] = i;  // as if every step were on its own
    believed += Map().row(kBall).norm();
  }
  EXPECT_LT(judged, 0.3 * believed);
}

TEST_F(ContactMapOfSteps, NeedsAClipOfEveryStep) {
  clips_.pop_back();
  EXPECT_THROW(Map(), std::invalid_argument);
}

TEST(ContactMap, AddsToTheMeanWhatTheLatentTells) {
  const auto model = testing::SmallModel();
  const MotionPrimitive& primitive = model->primitive(0);
  EXPECT_EQ(primitive.Contacts({}), primitive.contacts);
  EXPECT_THROW(primitive.Contacts(Eigen::VectorXd::Zero(1)), std::invalid_argument);
  const ContactProfile told = primitive.Contacts(Eigen::VectorXd::Zero(primitive.reduction.components()));
  EXPECT_EQ(told, primitive.contacts);
  MotionPrimitive other = primitive;
  other.contact_map = Eigen::MatrixXf::Zero(kMotionRows * kPhaseSamples, primitive.reduction.components());
  other.contact_map(kMotionRows * 4 + kSlideLeft - kFootParts, 0) = 2;
  Eigen::VectorXd latent = Eigen::VectorXd::Zero(primitive.reduction.components());
  latent[0] = 0.5;
  ContactProfile wanted = primitive.contacts;
  wanted(kSlideLeft, 4) += 1;
  EXPECT_LT((other.Contacts(latent) - wanted).norm(), 1e-6);
}

}  // namespace
}  // namespace morphograph
