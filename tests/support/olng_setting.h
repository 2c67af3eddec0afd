#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "datasets/synthetic_gait.h"
#include "datasets/virtual_sensors.h"
#include "synthesis/sensors/olng_estimator.h"

namespace morphograph::testing {

// Walks of several speeds on one skeleton.
inline std::vector<MotionClip> OlngWalks() {
  std::vector<MotionClip> walks;
  for (std::uint64_t i = 0; i < 9; ++i) {
    SyntheticGaitOptions options;
    options.seed = i + 1;
    options.frame_rate_hz = 30;
    options.steps = 8;
    options.speed_m_s = 1.0 + 0.08 * static_cast<double>(i);
    options.stop_standing = false;
    walks.push_back(GenerateGait(options));
    if (i > 0) {
      MotionClip shared(walks.front().shared_skeleton(), 30, walks.back().frame_count());
      for (int f = 0; f < shared.frame_count(); ++f) std::copy_n(walks.back().rotations(f), shared.joint_count(), &shared.rotation(f, 0));
      shared.root_positions() = walks.back().root_positions();
      walks.back() = shared;
    }
  }
  return walks;
}

// All walks but one, and that one.
struct OlngSetting {
  OlngSetting() {
    std::vector<MotionClip> walks = OlngWalks();
    test = walks[4];
    walks.erase(walks.begin() + 4);
    base = std::make_shared<MotionBase>(walks, PlacementsAtJoints({"left_wrist", "right_wrist", "left_ankle", "right_ankle"}), MotionBaseOptions());
    known = walks[3];
  }
  Eigen::MatrixXd Read(const MotionClip& clip) const { return VirtualAccelerations(clip, base->sensors(), 30).values; }
  MotionClip test, known;
  std::shared_ptr<const MotionBase> base;
};

inline const OlngSetting& OlngShared() {
  static const OlngSetting setting;
  return setting;
}

// What a stream of the readings gives.
inline std::vector<BasePose> RunOlng(const Eigen::MatrixXd& readings, const OlngOptions& options) {
  OlngEstimator estimator(std::make_shared<OlngModel>(OlngShared().base, options));
  std::vector<BasePose> poses;
  for (Eigen::Index f = 0; f < readings.cols(); ++f) poses.push_back(estimator.Next(readings.col(f)));
  return poses;
}

}  // namespace morphograph::testing
