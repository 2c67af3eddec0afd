#include "datasets/foot_retarget.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <vector>

#include "datasets/forward_kinematics.h"
#include "datasets/leg_ik.h"

namespace morphograph {
namespace {

constexpr double kLow = 0.1;      // the quantile of a ball's heights that is taken for where it is low
constexpr double kStretch = 0.7;  // of the way to a straight leg; what is left keeps knees from snapping straight

double Low(std::vector<double> heights) {
  const auto low = heights.begin() + static_cast<std::ptrdiff_t>(kLow * static_cast<double>(heights.size()));
  std::nth_element(heights.begin(), low, heights.end());
  return *low;
}

double LowerBall(const MotionClip& clip) {
  const RoleMap& roles = clip.skeleton().roles();
  if (!roles.Has(JointRole::kLeftToe) || !roles.Has(JointRole::kRightToe)) return 0;
  std::vector<double> heights;
  WorldPose pose;
  for (int f = 0; f < clip.frame_count(); ++f) {
    ForwardKinematics(clip.skeleton(), clip.rotations(f), clip.root_positions().col(f), &pose);
    heights.push_back(std::min(pose.positions(1, roles[JointRole::kLeftToe]), pose.positions(1, roles[JointRole::kRightToe])));
  }
  return Low(std::move(heights));
}

// Both legs; none where a skeleton has not two that can be bent.
std::vector<LegIk> LegsOf(const Skeleton& skeleton) {
  try {
    return {LegIk(skeleton, Foot::kLeft), LegIk(skeleton, Foot::kRight)};
  } catch (const std::invalid_argument&) {
    return {};
  }
}

std::vector<LegPlace> Places(const LegIk& leg, const MotionClip& clip) {
  std::vector<LegPlace> places;
  for (int f = 0; f < clip.frame_count(); ++f) places.push_back(leg.Place(clip.root_positions().col(f), clip.rotations(f)));
  return places;
}

double LowBall(const std::vector<LegPlace>& places) {
  std::vector<double> heights;
  for (const LegPlace& place : places) heights.push_back(place.toe_m.y());
  return Low(std::move(heights));
}

// The nearest to `target` along the line from the hip that the leg may be stretched to.
Eigen::Vector3d WithinReach(const LegPlace& place, double length_m, const Eigen::Vector3d& target) {
  const double now = (place.ankle_m - place.hip_m).norm(), wanted = (target - place.hip_m).norm();
  const double reach = now + kStretch * std::max(0.0, length_m - now);
  return wanted <= reach ? target : Eigen::Vector3d(place.hip_m + reach / wanted * (target - place.hip_m));
}

}  // namespace

void PlaceFeetAsIn(const MotionClip& source, double scale, MotionClip* moved) {
  const int frames = source.frame_count();
  if (frames == 0) return;
  const std::vector<LegIk> source_legs = LegsOf(source.skeleton()), legs = LegsOf(moved->skeleton());
  if (source_legs.empty() || legs.empty()) {
    moved->root_positions().row(1).array() += LowerBall(source) - LowerBall(*moved);
    return;
  }
  std::vector<LegPlace> there[2];
  double low[2], level = 0, lift = 0;
  for (size_t i = 0; i < legs.size(); ++i) {
    there[i] = Places(source_legs[i], source);
    low[i] = LowBall(there[i]);
    level += 0.5 * low[i];
    lift += 0.5 * (low[i] - LowBall(Places(legs[i], *moved)));
  }
  moved->root_positions().row(1).array() += lift;
  for (size_t i = 0; i < legs.size(); ++i) {
    for (int f = 0; f < frames; ++f) {
      const LegPlace here = legs[i].Place(moved->root_positions().col(f), moved->rotations(f));
      const LegPlace& model = there[i][static_cast<size_t>(f)];
      Eigen::Vector3d target = scale * model.ankle_m;
      target.y() = here.ankle_m.y() + level + scale * (model.toe_m.y() - low[i]) - here.toe_m.y();
      legs[i].Solve(WithinReach(here, legs[i].length_m(), target), std::nullopt, moved->root_positions().col(f), &moved->rotation(f, 0));
    }
  }
}

}  // namespace morphograph
