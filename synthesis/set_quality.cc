#include "synthesis/set_quality.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "datasets/quantile.h"
#include "datasets/resample.h"
#include "synthesis/body_check.h"
#include "synthesis/contact_quality.h"
#include "synthesis/evaluation_motion.h"
#include "synthesis/naturalness.h"
#include "synthesis/smoothness.h"

namespace morphograph {
namespace {

std::vector<MotionClip> Pieces(const MotionClip& clip, int piece_frames) {
  const bool at_rate = std::abs(clip.frame_rate_hz() - kEvaluationRateHz) <= 1e-3 * kEvaluationRateHz;
  const MotionClip sampled = at_rate ? clip : Resample(clip, kEvaluationRateHz);
  if (piece_frames == 0) return {sampled};
  std::vector<MotionClip> pieces;
  for (int first = 0; first + piece_frames <= sampled.frame_count(); first += piece_frames) {
    pieces.push_back(sampled.Slice(first, piece_frames));
  }
  return pieces;
}

}  // namespace

SetQuality MeasureSet(const std::vector<MotionClip>& clips, const SetQualityOptions& options) {
  if (options.piece_frames < 0 || options.piece_frames == 1) {
    throw std::invalid_argument("MeasureSet: pieces need 2 frames or more (or 0 for whole clips)");
  }
  SetQuality set;
  set.clips = static_cast<int>(clips.size());
  set.min_knee_flexion_deg = set.lowest_m = std::numeric_limits<double>::infinity();
  set.max_knee_flexion_deg = -std::numeric_limits<double>::infinity();
  double distance_sum = 0, jerk_sum = 0;
  int planted = 0;
  size_t jerks = 0;
  std::vector<double> accelerations;
  for (const MotionClip& clip : clips) {
    for (const MotionClip& piece : Pieces(clip, options.piece_frames)) {
      const EvaluationMotion motion = PrepareEvaluation(piece);
      const ContactQuality contact = MeasureContacts(motion.contacts, motion.ground, kEvaluationRateHz);
      const BodyCheck body = CheckBody(motion);
      ++set.pieces;
      set.seconds += piece.duration_s();
      distance_sum += contact.contact_distance_m * contact.planted_foot_frames;
      planted += contact.planted_foot_frames;
      set.foot_skate_cm_s += contact.foot_skate_cm_s;
      set.planted_skate_cm_s += contact.planted_skate_cm_s;
      set.naturalness += NaturalnessVariance(FrameDifferences(*motion.skeleton, motion.joint_positions));
      set.penetration_m = std::max(set.penetration_m, contact.penetration_m);
      set.min_knee_flexion_deg = std::min(set.min_knee_flexion_deg, body.min_knee_flexion_deg);
      set.max_knee_flexion_deg = std::max(set.max_knee_flexion_deg, body.max_knee_flexion_deg);
      set.lowest_m = std::min(set.lowest_m, body.lowest_m);
      set.bone_length_error_m = std::max(set.bone_length_error_m, body.bone_length_error_m);
      const std::vector<double> more =
          JointAccelerations(*motion.skeleton, motion.joint_positions, kEvaluationRateHz);
      accelerations.insert(accelerations.end(), more.begin(), more.end());
      for (const double jerk : JointJerks(*motion.skeleton, motion.joint_positions, kEvaluationRateHz)) {
        jerk_sum += jerk;
        ++jerks;
      }
    }
  }
  if (set.pieces == 0) throw std::invalid_argument("MeasureSet: no clip is as long as a piece");
  set.foot_skate_cm_s /= set.pieces;
  set.planted_skate_cm_s /= set.pieces;
  set.naturalness /= set.pieces;
  if (planted > 0) set.contact_distance_m = distance_sum / planted;
  if (!accelerations.empty()) set.acceleration_p999_m_s2 = Quantile(std::move(accelerations), 0.999);
  if (jerks > 0) set.mean_jerk_m_s3 = jerk_sum / static_cast<double>(jerks);
  return set;
}

}  // namespace morphograph
