#include "primitives/keyframe_cues.h"

#include <Eigen/Geometry>
#include <algorithm>

#include <cmath>

#include "datasets/joint_roles.h"
#include "datasets/low_pass.h"
#include "datasets/quantile.h"
#include "primitives/pose_window.h"

namespace morphograph {
namespace {

constexpr double kLowPassHz = 10;
constexpr double kMinShare = 0.9;  // of the labels must have the turning point

// Sub-frame turning points; the ends of a clip are none.
std::vector<double> TurningPoints(const Eigen::MatrixXd& signals, int row, bool maximum) {
  const double sign = maximum ? 1 : -1;
  std::vector<double> found;
  for (Eigen::Index f = 1; f + 1 < signals.cols(); ++f) {
    const double before = sign * signals(row, f - 1), here = sign * signals(row, f), after = sign * signals(row, f + 1);
    if (!(here > before) || !(here >= after)) continue;
    const double curvature = before - 2 * here + after;
    found.push_back(static_cast<double>(f) + 0.5 * (before - after) / curvature);
  }
  return found;
}

std::optional<double> Nearest(const std::vector<double>& points, double frame, double reach_frames) {
  std::optional<double> nearest;
  for (const double point : points) {
    if (std::abs(point - frame) <= reach_frames && (!nearest || std::abs(point - frame) < std::abs(*nearest - frame))) nearest = point;
  }
  return nearest;
}

}  // namespace

Eigen::MatrixXd CueSignals(const std::vector<Eigen::Matrix3Xd>& poses, double frame_rate_hz) {
  if (poses.empty()) return {};
  const Eigen::Index frames = static_cast<Eigen::Index>(poses.size());
  const Eigen::Index joints = poses[0].cols();
  const Eigen::Index hips = PoseColumn(JointRole::kHips);
  const Eigen::Index left = PoseColumn(JointRole::kLeftHip), right = PoseColumn(JointRole::kRightHip);
  Eigen::MatrixXd signals(3 * joints + joints * (joints - 1) / 2, frames);
  for (Eigen::Index f = 0; f < frames; ++f) {
    const Eigen::Matrix3Xd& pose = poses[static_cast<size_t>(f)];
    Eigen::Vector3d ahead = (pose.col(left) - pose.col(right)).cross(Eigen::Vector3d::UnitY());
    ahead.y() = 0;
    ahead.normalize();
    Eigen::Index row = 3 * joints;
    for (Eigen::Index j = 0; j < joints; ++j) {
      const Eigen::Vector3d from_hips = pose.col(j) - pose.col(hips);
      signals(j, f) = from_hips.dot(ahead);
      signals(joints + j, f) = pose(1, j);
      signals(2 * joints + j, f) = from_hips.norm();
      for (Eigen::Index k = j + 1; k < joints; ++k) signals(row++, f) = (pose.col(j) - pose.col(k)).norm();
    }
  }
  signals = LowPass(signals, frame_rate_hz, kLowPassHz);
  // Heights become vertical speeds by central differences.
  const Eigen::MatrixXd height = signals.middleRows(joints, joints);
  for (Eigen::Index f = 0; f < frames; ++f) {
    const Eigen::Index before = std::max<Eigen::Index>(0, f - 1), after = std::min(frames - 1, f + 1);
    if (after == before) continue;
    signals.middleRows(joints, joints).col(f) =
        (height.col(after) - height.col(before)) * (frame_rate_hz / static_cast<double>(after - before));
  }
  return signals;
}

std::vector<TimingCue> LearnTimingCues(const std::vector<CueExample>& examples, double reach_s, int count) {
  std::vector<TimingCue> cues;
  Eigen::Index rows = 0;
  for (const CueExample& example : examples) rows = std::max(rows, example.signals->rows());
  for (int row = 0; row < rows; ++row) {
    for (const bool maximum : {true, false}) {
      std::vector<std::vector<double>> points;
      std::vector<double> offsets;
      int labels = 0;
      for (const CueExample& example : examples) {
        points.push_back(TurningPoints(*example.signals, row, maximum));
        for (const double frame : example.frames) {
          ++labels;
          if (const auto nearest = Nearest(points.back(), frame, reach_s * example.frame_rate_hz)) {
            offsets.push_back((frame - *nearest) / example.frame_rate_hz);
          }
        }
      }
      if (offsets.empty() || static_cast<double>(offsets.size()) < kMinShare * labels) continue;
      TimingCue cue{row, maximum, Median(offsets), 0};
      int starts = 0;
      for (size_t e = 0; e < examples.size(); ++e) {
        const double rate = examples[e].frame_rate_hz;
        for (const double frame : examples[e].frames) {
          for (const double part : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
            const double start = frame + part * reach_s * rate - cue.offset_s * rate;
            const auto nearest = Nearest(points[e], start, reach_s * 1.5 * rate);
            const double error = nearest ? std::abs(*nearest + cue.offset_s * rate - frame) / rate : reach_s;
            cue.error_s += std::min(error, reach_s);
            ++starts;
          }
        }
      }
      cue.error_s /= starts;
      cues.push_back(cue);
    }
  }
  std::stable_sort(cues.begin(), cues.end(), [](const TimingCue& a, const TimingCue& b) { return a.error_s < b.error_s; });
  if (static_cast<int>(cues.size()) > count) cues.resize(static_cast<size_t>(count));
  return cues;
}

std::optional<double> RefineByCues(const std::vector<TimingCue>& cues, const Eigen::MatrixXd& signals, double frame_rate_hz,
                                   double frame, double reach_s) {
  std::vector<double> said;
  for (const TimingCue& cue : cues) {
    const double offset = cue.offset_s * frame_rate_hz;
    const auto nearest = Nearest(TurningPoints(signals, cue.signal, cue.maximum), frame - offset, reach_s * frame_rate_hz);
    if (nearest) said.push_back(*nearest + offset);
  }
  if (said.empty()) return std::nullopt;
  return Median(said);
}

}  // namespace morphograph
