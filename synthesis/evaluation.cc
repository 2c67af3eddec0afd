#include "synthesis/evaluation.h"

#include <algorithm>
#include <cmath>

#include "synthesis/contact_quality.h"
#include "synthesis/evaluation_motion.h"
#include "synthesis/naturalness.h"

namespace morphograph {
namespace {

// Where the ball stood: the mean over the middle half of the interval, in which it hardly moves.
Eigen::Vector2d StancePosition(const ContactTrack& contacts, const ContactInterval& interval) {
  const Eigen::Matrix3Xd& ball = contacts.balls[interval.foot == Foot::kLeft ? 0 : 1];
  const int quarter = (interval.last - interval.first) / 4;
  const int first = interval.first + quarter, count = interval.last - quarter - first + 1;
  const Eigen::Vector3d mean = ball.middleCols(first, count).rowwise().mean();
  return {mean.x(), mean.z()};
}

}  // namespace

std::vector<PlantedFoot> PlantedFeet(const ContactTrack& contacts) {
  std::vector<PlantedFoot> planted;
  for (const ContactInterval& interval : contacts.intervals) {
    planted.push_back({interval, StancePosition(contacts, interval)});
  }
  return planted;
}

ClipEvaluation EvaluateMotion(const EvaluationMotion& motion) {
  ClipEvaluation evaluation;
  const ContactQuality contact = MeasureContacts(motion.contacts, motion.ground, kEvaluationRateHz);
  evaluation.quality.contact_distance_m = contact.contact_distance_m;
  evaluation.quality.foot_skate_cm_s = contact.foot_skate_cm_s;
  evaluation.quality.penetration_m = contact.penetration_m;
  evaluation.contact_distance_m.assign(contact.distance_m.begin(), contact.distance_m.end());
  evaluation.frame_difference = FrameDifferences(*motion.skeleton, motion.joint_positions);
  evaluation.quality.naturalness = NaturalnessVariance(evaluation.frame_difference);
  evaluation.contacts = PlantedFeet(motion.contacts);
  return evaluation;
}

ClipEvaluation EvaluateClip(const MotionClip& clip) {
  const EvaluationMotion motion = PrepareEvaluation(clip);
  ClipEvaluation evaluation = EvaluateMotion(motion);
  // Contacts go out in the clip's own frames; where it was resampled they are found again at its own rate.
  if (motion.frame_count() != clip.frame_count() ||
      std::abs(clip.frame_rate_hz() - kEvaluationRateHz) > 1e-3 * kEvaluationRateHz) {
    evaluation.contacts = PlantedFeet(DetectContacts(clip));
  }
  return evaluation;
}

}  // namespace morphograph
