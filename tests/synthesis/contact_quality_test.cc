#include "synthesis/contact_quality.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/synthesis/foot_track.h"

namespace morphograph {
namespace {

using testing::AlternatingFeet;

ContactQuality Measure(const ContactTrack& track) {
  return MeasureContacts(track, FitGroundPlane(track, 30), 30);
}

// Lifts every point by height(x, z).
template <typename Height>
ContactTrack Lifted(ContactTrack track, Height height) {
  for (int side = 0; side < 2; ++side) {
    for (Eigen::Matrix3Xd* points : {&track.balls[side], &track.heels[side]}) {
      for (Eigen::Index f = 0; f < points->cols(); ++f)
        (*points)(1, f) += height((*points)(0, f), (*points)(2, f));
    }
  }
  return track;
}

TEST(GroundPlane, OfFlatStancesIsAtStanceHeight) {
  const GroundPlane plane = FitGroundPlane(AlternatingFeet(150), 30);
  EXPECT_NEAR(plane.HeightAt(1.0, 2.0), 0.04, 1e-9);
  EXPECT_NEAR(plane.slope_z, 0, 1e-9);
}

TEST(GroundPlane, FollowsATiltedFloorAlongTheWalk) {
  const ContactTrack track = Lifted(AlternatingFeet(150), [](double, double z) { return 0.02 * z; });
  const GroundPlane plane = FitGroundPlane(track, 30);
  EXPECT_NEAR(plane.slope_z, 0.02, 1e-3);  // the ridge takes a few per cent
  EXPECT_LT(MeasureContacts(track, plane, 30).contact_distance_m,
            2.5e-3);  // the heel is 18 cm behind: 1.8 mm of tilt
}

TEST(GroundPlane, DoesNotTiltToHideAFootThatStandsHigher) {
  const ContactTrack track =
      Lifted(AlternatingFeet(300), [](double x, double) { return x > 0 ? 0.02 : 0.0; });
  EXPECT_GT(Measure(track).contact_distance_m, 0.004);
}

TEST(GroundPlane, IsNotPulledDownByOneBadStance) {
  ContactTrack track = AlternatingFeet(300);
  const ContactInterval bad = track.intervals[4];
  const int side = bad.foot == Foot::kLeft ? 0 : 1;
  for (int f = bad.first; f <= bad.last; ++f) track.balls[side](1, f) -= 0.1, track.heels[side](1, f) -= 0.1;
  EXPECT_NEAR(FitGroundPlane(track, 30).HeightAt(0, track.balls[0](2, 150)), 0.04, 0.002);
}

TEST(GroundPlane, DoesNotRiseWithFeetThatRollOverTheirToes) {
  // In the second half of each stance the ball lifts, faster than a still foot.
  ContactTrack track = AlternatingFeet(150);
  for (const ContactInterval& interval : track.intervals) {
    const int side = interval.foot == Foot::kLeft ? 0 : 1;
    for (int f = interval.first + 6; f <= interval.last; ++f)
      track.balls[side](1, f) += 0.012 * (f - interval.first - 5);
  }
  EXPECT_NEAR(FitGroundPlane(track, 30).height_m, 0.04, 1e-9);
}

TEST(GroundPlane, WithoutStanceIsLevelAtTheLowestBalls) {
  ContactTrack track = AlternatingFeet(100);
  track.intervals.clear();
  const GroundPlane plane = FitGroundPlane(track, 30);
  EXPECT_NEAR(plane.HeightAt(5, 5), 0.04, 1e-12);
  EXPECT_EQ(MeasureContacts(track, plane, 30).contact_distance_m, 0);
}

TEST(ContactQuality, OfPerfectStancesIsZero) {
  const ContactQuality quality = Measure(AlternatingFeet(150));
  EXPECT_NEAR(quality.contact_distance_m, 0, 1e-9);
  EXPECT_NEAR(quality.penetration_m, 0, 1e-9);
  EXPECT_NEAR(quality.foot_skate_cm_s, 0, 1e-6);
  EXPECT_EQ(quality.planted_foot_frames, 150);
}

TEST(ContactQuality, OfAKnownHeightErrorIsThatError) {
  // Every second frame of a stance hovers 8 mm: the medians, and so the plane, stay; half of the frames are 8
  // mm off.
  ContactTrack track = AlternatingFeet(150);
  for (const ContactInterval& interval : track.intervals) {
    const int side = interval.foot == Foot::kLeft ? 0 : 1;
    for (int f = interval.first + 1; f <= interval.last; f += 2) {
      track.balls[side](1, f) += 0.008, track.heels[side](1, f) += 0.008;
    }
  }
  const ContactQuality quality = Measure(track);
  EXPECT_NEAR(quality.contact_distance_m, 0.008 * 7 / 15, 1e-9);
  EXPECT_NEAR(quality.distance_m[1], 0.008, 1e-9);
  EXPECT_NEAR(quality.distance_m[0], 0, 1e-9);
}

TEST(ContactQuality, OfFeetThatSlideAtAKnownSpeedIsThatSpeed) {
  // Both balls on the floor, moving at 0.2 m/s and 0.1 m/s: the mean over both feet is 15 cm/s.
  ContactTrack track = AlternatingFeet(60);
  for (int f = 0; f < 60; ++f) {
    track.balls[0].col(f) = Eigen::Vector3d(0.2 * f / 30 * std::sin(0.3), 0.04, 0.2 * f / 30 * std::cos(0.3));
    track.balls[1].col(f) = Eigen::Vector3d(-0.1, 0.04, 0.1 * f / 30);
    track.heels[0].col(f) = track.balls[0].col(f), track.heels[1].col(f) = track.balls[1].col(f);
  }
  EXPECT_NEAR(Measure(track).foot_skate_cm_s, 15, 1e-9);
  // Of planted balls: 20 and 10 cm/s while they stand.
  double planted = 0;
  for (int side = 0; side < 2; ++side) {
    for (int f = 0; f + 1 < 60; ++f) planted += track.planted(2 * side + 1, f) && track.planted(2 * side + 1, f + 1) ? 20.0 / (side + 1) : 0;
  }
  ASSERT_GT(planted, 0);
  EXPECT_NEAR(Measure(track).planted_skate_cm_s, planted / (2 * 59), 1e-9);
  EXPECT_LT(Measure(track).planted_skate_cm_s, 10);
  for (int side = 0; side < 2; ++side) track.balls[side].row(1).array() += 0.0125;  // 2 - 2^0.5 of it counts
  EXPECT_NEAR(MeasureContacts(track, {0.04, 0, 0}, 30).foot_skate_cm_s, 15 * (2 - std::sqrt(2)), 1e-9);
  for (int side = 0; side < 2; ++side)
    track.balls[side].row(1).array() += 0.0125;  // 2.5 cm up: nothing counts
  EXPECT_NEAR(MeasureContacts(track, {0.04, 0, 0}, 30).foot_skate_cm_s, 0, 1e-9);
}

TEST(ContactQuality, OfAFootBelowTheGroundIsThatDepth) {
  ContactTrack track = AlternatingFeet(150);
  track.heels[1](1, 20) -= 0.03;  // the right foot stands in frames 15 to 29
  EXPECT_NEAR(Measure(track).penetration_m, 0.03, 1e-6);
}

TEST(ContactQuality, RefusesASingleFrame) {
  EXPECT_THROW(Measure(AlternatingFeet(1)), std::invalid_argument);
  EXPECT_THROW(FitGroundPlane(AlternatingFeet(0), 30), std::invalid_argument);
  EXPECT_THROW(FitGroundPlane(AlternatingFeet(10), 0), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
