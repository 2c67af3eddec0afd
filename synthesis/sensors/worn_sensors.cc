#include "synthesis/sensors/worn_sensors.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "datasets/contact_detector.h"
#include "datasets/forward_kinematics.h"

namespace morphograph {
namespace {

constexpr int kFrames = 20000;            // looked at, in whole clips evenly taken
constexpr double kResting_m_s = 0.12;     // pelvis and balls of the feet of a body that stands
constexpr double kLeastResting_s = 0.4;   // at a time
constexpr double kEnoughStanding_s = 1;   // in all
constexpr double kLeastSpread_rad = 0.05;  // people do not stand alike

enum class Limb { kOther, kLeftLeg, kRightLeg };

Limb LimbOf(const Skeleton& skeleton, int joint) {
  const RoleMap& roles = skeleton.roles();
  for (int j = joint; j >= 0; j = skeleton.parent(j)) {
    if (j == roles[JointRole::kLeftHip]) return Limb::kLeftLeg;
    if (j == roles[JointRole::kRightHip]) return Limb::kRightLeg;
  }
  return Limb::kOther;
}

// Sums of the way up in each sensor's axes.
struct UpSums {
  Eigen::Matrix3Xd sums;
  Eigen::VectorXd counts;
  explicit UpSums(Eigen::Index sensors) : sums(Eigen::Matrix3Xd::Zero(3, sensors)), counts(Eigen::VectorXd::Zero(sensors)) {}
  void Add(Eigen::Index sensor, const Eigen::Vector3d& up) {
    sums.col(sensor) += up;
    counts[sensor] += 1;
  }
};

// Frames in which pelvis and feet are at rest for a while.
std::vector<char> StandingFrames(const MotionClip& clip, const std::vector<WorldPose>& poses) {
  const RoleMap& roles = clip.skeleton().roles();
  std::vector<int> watched = {clip.skeleton().moving_root()};
  for (const JointRole role : {JointRole::kLeftToe, JointRole::kRightToe, JointRole::kLeftAnkle, JointRole::kRightAnkle}) {
    if (roles[role] >= 0) watched.push_back(roles[role]);
  }
  const auto frames = poses.size();
  std::vector<char> standing(frames, 0);
  const auto least = static_cast<std::size_t>(kLeastResting_s * clip.frame_rate_hz());
  for (std::size_t first = 0; first < frames;) {
    std::size_t last = first;  // rests until here
    const auto rests = [&](std::size_t f) {
      return std::all_of(watched.begin(), watched.end(), [&](int j) {
        return (poses[f + 1].positions.col(j) - poses[f].positions.col(j)).norm() * clip.frame_rate_hz() < kResting_m_s;
      });
    };
    while (last + 1 < frames && rests(last)) ++last;
    if (last - first >= least) std::fill(standing.begin() + static_cast<std::ptrdiff_t>(first), standing.begin() + static_cast<std::ptrdiff_t>(last) + 1, 1);
    first = last + 1;
  }
  return standing;
}

}  // namespace

WornSensors WornBy(const std::vector<MotionClip>& clips, const std::vector<Placement>& placements) {
  if (clips.empty()) throw std::invalid_argument("WornBy: there are no clips");
  const Skeleton& skeleton = clips.front().skeleton();
  const std::vector<int> joints = JointsOf(placements, skeleton);
  const auto sensors = static_cast<Eigen::Index>(placements.size());
  long long all = 0;
  for (const MotionClip& clip : clips) all += clip.frame_count();
  const auto every = static_cast<std::size_t>(std::max(1LL, all / kFrames));
  UpSums standing(sensors), walking(sensors), anyhow(sensors);
  double standing_s = 0;
  for (std::size_t c = 0; c < clips.size(); c += every) {
    const MotionClip& clip = clips[c];
    if (clip.frame_count() < 3) continue;
    const std::vector<WorldPose> poses = WorldPoses(clip);
    const std::vector<char> stands = StandingFrames(clip, poses);
    const ContactTrack contacts = DetectContacts(clip, poses);
    for (int f = 0; f < clip.frame_count(); ++f) {
      const auto frame = static_cast<std::size_t>(f);
      if (stands[frame]) standing_s += 1 / clip.frame_rate_hz();
      for (Eigen::Index s = 0; s < sensors; ++s) {
        const auto n = static_cast<std::size_t>(s);
        const Eigen::Vector3d up = (poses[frame].rotations[static_cast<std::size_t>(joints[n])] * placements[n].joint_from_sensor).conjugate() * Eigen::Vector3d::UnitY();
        anyhow.Add(s, up);
        if (stands[frame]) standing.Add(s, up);
        const Limb limb = LimbOf(skeleton, joints[n]);
        const int row = limb == Limb::kLeftLeg ? 0 : 2;
        if (limb == Limb::kOther || (contacts.planted(row, f) && contacts.planted(row + 1, f))) walking.Add(s, up);
      }
    }
  }
  WornSensors worn;
  worn.standing = standing_s >= kEnoughStanding_s;
  worn.up.resize(3, sensors);
  worn.spread_rad.resize(sensors);
  for (Eigen::Index s = 0; s < sensors; ++s) {
    const UpSums& from = worn.standing ? standing : walking.counts[s] > 0 ? walking : anyhow;
    worn.up.col(s) = from.sums.col(s).normalized();
    // Of unit vectors, a mean of length r: 1 - r is half their mean squared angle from it.
    const double length = from.sums.col(s).norm() / std::max(1.0, from.counts[s]);
    worn.spread_rad[s] = std::max(kLeastSpread_rad, std::sqrt(2 * std::max(0.0, 1 - length)));
  }
  return worn;
}

}  // namespace morphograph
