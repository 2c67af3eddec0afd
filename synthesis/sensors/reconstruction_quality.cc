#include "synthesis/sensors/reconstruction_quality.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "datasets/contact_detector.h"
#include "datasets/quantile.h"
#include "primitives/rotation_math.h"

namespace morphograph {
namespace {

// (3 * measured joints x frames), metres.
Eigen::MatrixXd PelvisTracks(const MotionBase& base, const std::vector<BasePose>& poses) {
  Eigen::MatrixXd tracks(3 * static_cast<Eigen::Index>(base.measured_joints().size()), static_cast<Eigen::Index>(poses.size()));
  WorldPose pose;
  for (std::size_t f = 0; f < poses.size(); ++f) {
    base.PelvisPose(poses[f].rotations, &pose);
    for (std::size_t n = 0; n < base.measured_joints().size(); ++n)
      tracks.col(static_cast<Eigen::Index>(f)).segment<3>(3 * static_cast<Eigen::Index>(n)) = pose.positions.col(base.measured_joints()[n]);
  }
  return tracks;
}

Eigen::MatrixXd Differences(const Eigen::MatrixXd& tracks) { return tracks.rightCols(tracks.cols() - 1) - tracks.leftCols(tracks.cols() - 1); }

double RootMeanSquare(const Eigen::MatrixXd& points) { return std::sqrt(points.squaredNorm() / static_cast<double>(points.size() / 3)); }

double MeanAngle(const std::vector<BasePose>& poses, const std::vector<BasePose>& truth) {
  double sum = 0;
  long long count = 0;
  for (std::size_t f = 0; f < poses.size(); ++f) {
    for (Eigen::Index r = 0; r < poses[f].rotations.size(); r += 3, ++count)
      sum += ExpMap(poses[f].rotations.segment<3>(r)).angularDistance(ExpMap(truth[f].rotations.segment<3>(r)));
  }
  return sum / static_cast<double>(count);
}

double ContactAgreement(const MotionClip& clip, const MotionClip& truth) {
  if (!clip.skeleton().roles().Missing(LocomotionRoles()).empty()) return 0;
  const ContactTrack found = DetectContacts(clip), wanted = DetectContacts(truth);
  const auto stands = [](const ContactTrack& track, int foot, int frame) { return track.planted(2 * foot, frame) || track.planted(2 * foot + 1, frame); };
  long long same = 0, count = 0;
  for (int foot = 0; foot < 2; ++foot) {
    for (int f = 0; f < clip.frame_count(); ++f, ++count) same += stands(found, foot, f) == stands(wanted, foot, f);
  }
  return static_cast<double>(same) / static_cast<double>(count);
}

}  // namespace

std::vector<BasePose> PosesOf(const MotionBase& base, const MotionClip& clip) {
  std::vector<BasePose> poses;
  for (int f = 0; f < clip.frame_count(); ++f) poses.push_back(base.PoseOf(clip, f));
  return poses;
}

ReconstructionQuality CompareWithTruth(const MotionBase& base, const std::vector<BasePose>& poses, const MotionClip& truth_clip) {
  if (static_cast<int>(poses.size()) != truth_clip.frame_count()) throw std::invalid_argument("CompareWithTruth: the truth has another number of frames");
  if (poses.size() < 4) throw std::invalid_argument("CompareWithTruth: fewer than 4 frames");
  const std::vector<BasePose> truth = PosesOf(base, truth_clip);
  const Eigen::MatrixXd tracks = PelvisTracks(base, poses), true_tracks = PelvisTracks(base, truth);
  const Eigen::MatrixXd off = tracks - true_tracks;
  ReconstructionQuality quality;
  quality.frames = static_cast<int>(poses.size());
  for (Eigen::Index f = 0; f < off.cols(); ++f) {
    quality.frame_rms_cm.push_back(100 * RootMeanSquare(off.col(f)));
    quality.position_rms_cm += quality.frame_rms_cm.back() / static_cast<double>(off.cols());
  }
  quality.position_rms_p95_cm = Quantile(quality.frame_rms_cm, 0.95);
  quality.velocity_error_cm_s = 100 * base.frame_rate_hz() * RootMeanSquare(Differences(off));
  quality.jerk_ratio = RootMeanSquare(Differences(Differences(Differences(tracks)))) / RootMeanSquare(Differences(Differences(Differences(true_tracks))));
  quality.angle_deg = MeanAngle(poses, truth) * 180 / M_PI;
  double wrong = 0, whole = 0;
  for (std::size_t f = 0; f < poses.size(); ++f) {
    wrong += (poses[f].rotations - truth[f].rotations).squaredNorm();
    whole += truth[f].rotations.squaredNorm();
  }
  quality.normalised_rms = whole > 0 ? std::sqrt(wrong / whole) : 0;
  quality.contact_agreement = ContactAgreement(base.Assemble(poses), truth_clip);
  return quality;
}

}  // namespace morphograph
