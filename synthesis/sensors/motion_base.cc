#include "synthesis/sensors/motion_base.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "datasets/mirror.h"
#include "datasets/parallel_for.h"
#include "datasets/resample.h"
#include "datasets/virtual_sensors.h"
#include "primitives/pose_layout.h"
#include "primitives/rotation_math.h"

namespace morphograph {
namespace {

constexpr int kFewestFrames = 5;
// Joints that turn less than this about their first rotation do not move.
constexpr double kStill_rad = 1e-4;
constexpr double kNoBone_m = 1e-6;

// The clip at the base's rate and its copies, those of its own tempo first; empty where it is too short.
struct ClipCopies {
  std::vector<MotionClip> clips;
  std::size_t own_tempo = 0;  // how many are of it
};

ClipCopies CopiesOf(const MotionClip& clip, const MotionBaseOptions& options) {
  ClipCopies copies;
  const auto add = [&](const MotionClip& made) {
    if (made.frame_count() < kFewestFrames) return;
    copies.clips.push_back(made);
    if (options.time_reversed) copies.clips.push_back(Reversed(made));
  };
  std::vector<MotionClip> sides;
  sides.reserve(2);
  sides.push_back(clip);
  if (options.mirrored) sides.push_back(Mirrored(clip));
  for (const MotionClip& side : sides) add(Resample(side, options.frame_rate_hz));
  copies.own_tempo = copies.clips.size();
  for (const double tempo : options.tempos) {
    for (const MotionClip& side : sides) add(Resample(Retimed(side, side.frame_rate_hz() * tempo), options.frame_rate_hz));
  }
  return copies;
}

std::vector<int> MovingJoints(const std::vector<std::vector<MotionClip>>& sets) {
  const MotionClip& first = sets.front().front();
  const int joints = first.joint_count();
  std::vector<char> moves(static_cast<std::size_t>(joints), 0);
  for (const std::vector<MotionClip>& set : sets) {
    for (const MotionClip& clip : set) {
      for (int j = 0; j < joints; ++j) {
        for (int f = 0; f < clip.frame_count() && !moves[static_cast<std::size_t>(j)]; ++f)
          moves[static_cast<std::size_t>(j)] = first.rotation(0, j).angularDistance(clip.rotation(f, j)) > kStill_rad;
      }
    }
  }
  const int root = first.skeleton().moving_root();
  std::vector<int> active = {root};
  for (int j = 0; j < joints; ++j) {
    if (j != root && moves[static_cast<std::size_t>(j)] && first.skeleton().IsBody(j)) active.push_back(j);
  }
  return active;
}

Eigen::Quaterniond TiltOf(const MotionClip& clip, int frame) {
  return Yaw(-HeadingRad(clip, frame)) * clip.rotation(frame, clip.skeleton().moving_root());
}

// Mean rotation of every joint over some thousand frames; the moving root's of its tilt.
std::vector<Eigen::Quaterniond> MeansOf(const std::vector<std::vector<MotionClip>>& sets) {
  constexpr long long kFrames = 3000;
  long long frames = 0;
  for (const auto& set : sets) {
    for (const MotionClip& clip : set) frames += clip.frame_count();
  }
  const long long stride = std::max(1LL, frames / kFrames);
  const MotionClip& first = sets.front().front();
  std::vector<std::vector<Eigen::Quaterniond>> samples(static_cast<std::size_t>(first.joint_count()));
  long long n = 0;
  for (const auto& set : sets) {
    for (const MotionClip& clip : set) {
      for (int f = 0; f < clip.frame_count(); ++f) {
        if (n++ % stride != 0) continue;
        for (int j = 0; j < first.joint_count(); ++j)
          samples[static_cast<std::size_t>(j)].push_back(j == first.skeleton().moving_root() ? TiltOf(clip, f) : clip.rotation(f, j));
      }
    }
  }
  std::vector<Eigen::Quaterniond> means;
  for (const auto& of_joint : samples) means.push_back(GeodesicMean(of_joint));
  return means;
}

double WrappedAngle(double angle) { return std::remainder(angle, 2 * M_PI); }

}  // namespace

MotionBase::MotionBase(const std::vector<MotionClip>& clips, std::vector<Placement> sensors, const MotionBaseOptions& options)
    : frame_rate_hz_(options.frame_rate_hz), sensors_(std::move(sensors)) {
  if (!(options.frame_rate_hz > 0)) throw std::invalid_argument("MotionBase: the frame rate must be positive");
  for (const MotionClip& clip : clips) {
    if (clip.shared_skeleton() != clips.front().shared_skeleton()) throw std::invalid_argument("MotionBase: clips must share one skeleton");
  }
  std::vector<std::vector<MotionClip>> sets(clips.size());
  std::vector<std::size_t> own_tempo(clips.size());
  ParallelFor(options.jobs, static_cast<int>(clips.size()), [&](int i) {
    ClipCopies copies = CopiesOf(clips[static_cast<std::size_t>(i)], options);
    sets[static_cast<std::size_t>(i)] = std::move(copies.clips);
    own_tempo[static_cast<std::size_t>(i)] = copies.own_tempo;
  });
  std::vector<Eigen::Index> first_frames;
  Eigen::Index frames = 0;
  for (std::size_t i = 0; i < sets.size(); ++i) {
    for (std::size_t copy = 0; copy < sets[i].size(); ++copy) {
      const MotionClip& clip = sets[i][copy];
      if (copy < own_tempo[i]) own_tempo_frames_ += clip.frame_count();
      clip_of_.insert(clip_of_.end(), static_cast<std::size_t>(clip.frame_count()), static_cast<int>(first_frames.size()));
      first_frames.push_back(frames);
      frames += clip.frame_count();
    }
  }
  std::erase_if(sets, [](const auto& set) { return set.empty(); });
  if (sets.empty()) throw std::invalid_argument("MotionBase: no clip is long enough");
  skeleton_ = clips.front().shared_skeleton();
  JointsOf(sensors_, *skeleton_);  // throws where one does not exist
  active_joints_ = MovingJoints(sets);
  for (int j = 0; j < skeleton_->joint_count(); ++j) {
    if (j != skeleton_->moving_root() && skeleton_->IsBody(j) && skeleton_->joint(j).offset_m.norm() > kNoBone_m) measured_joints_.push_back(j);
  }
  mean_rotations_ = MeansOf(sets);
  rotations_.resize(3 * static_cast<Eigen::Index>(active_joints_.size()), frames);
  positions_.resize(3 * static_cast<Eigen::Index>(measured_joints_.size()), frames);
  accelerations_.resize(3 * static_cast<Eigen::Index>(sensors_.size()), frames);
  travel_.resize(4, frames);
  std::vector<const MotionClip*> all;
  for (const auto& set : sets) {
    for (const MotionClip& clip : set) all.push_back(&clip);
  }
  ParallelFor(options.jobs, static_cast<int>(all.size()),
              [&](int i) { AddClip(*all[static_cast<std::size_t>(i)], first_frames[static_cast<std::size_t>(i)]); });
}

void MotionBase::AddClip(const MotionClip& clip, Eigen::Index first) {
  if (!sensors_.empty())
    accelerations_.middleCols(first, clip.frame_count()) = VirtualAccelerations(clip, sensors_, frame_rate_hz_).values.cast<float>();
  WorldPose pose;
  for (int f = 0; f < clip.frame_count(); ++f) {
    const BasePose channels = PoseOf(clip, f);
    const Eigen::Index column = first + f;
    rotations_.col(column) = channels.rotations.cast<float>();
    travel_.col(column) << channels.step.cast<float>(), static_cast<float>(channels.height_m);
    PelvisPose(channels.rotations, &pose);
    for (std::size_t n = 0; n < measured_joints_.size(); ++n)
      positions_.col(column).segment<3>(3 * static_cast<Eigen::Index>(n)) = pose.positions.col(measured_joints_[n]).cast<float>();
  }
  if (clip.frame_count() > 1) travel_.col(first).head<3>() = travel_.col(first + 1).head<3>();
}

BasePose MotionBase::Pose(Eigen::Index frame) const {
  BasePose pose;
  pose.rotations = rotations_.col(frame).cast<double>();
  pose.step = travel_.col(frame).head<3>().cast<double>();
  pose.height_m = travel_(3, frame);
  return pose;
}

BasePose MotionBase::PoseOf(const MotionClip& clip, int frame) const {
  BasePose pose;
  pose.rotations.resize(3 * static_cast<Eigen::Index>(active_joints_.size()));
  for (std::size_t n = 0; n < active_joints_.size(); ++n) {
    const int joint = active_joints_[n];
    const Eigen::Quaterniond rotation = n == 0 ? TiltOf(clip, frame) : clip.rotation(frame, joint);
    pose.rotations.segment<3>(3 * static_cast<Eigen::Index>(n)) = LogMapAbout(mean_rotations_[static_cast<std::size_t>(joint)], rotation);
  }
  pose.height_m = clip.root_positions()(1, frame);
  if (frame > 0) {
    const double heading = HeadingRad(clip, frame - 1);
    const Eigen::Vector3d moved = Yaw(-heading) * (clip.root_positions().col(frame) - clip.root_positions().col(frame - 1));
    pose.step = Eigen::Vector3d(moved.x(), moved.z(), WrappedAngle(HeadingRad(clip, frame) - heading));
  }
  return pose;
}

std::vector<Eigen::Quaterniond> MotionBase::LocalRotations(const Eigen::VectorXd& rotations) const {
  std::vector<Eigen::Quaterniond> local = mean_rotations_;
  for (std::size_t n = 0; n < active_joints_.size(); ++n) {
    Eigen::Quaterniond& rotation = local[static_cast<std::size_t>(active_joints_[n])];
    rotation = ExpMapAbout(rotation, rotations.segment<3>(3 * static_cast<Eigen::Index>(n)));
  }
  return local;
}

void MotionBase::PelvisPose(const Eigen::VectorXd& rotations, WorldPose* pose) const {
  std::vector<Eigen::Quaterniond> local = LocalRotations(rotations);
  local[static_cast<std::size_t>(skeleton_->moving_root())].setIdentity();
  ForwardKinematics(*skeleton_, local.data(), Eigen::Vector3d::Zero(), pose);
}

MotionClip MotionBase::Assemble(const std::vector<BasePose>& poses) const {
  MotionClip clip(skeleton_, frame_rate_hz_, static_cast<int>(poses.size()));
  PoseAssembler assembler(*this);
  for (int f = 0; f < clip.frame_count(); ++f) {
    const PlacedPose placed = assembler.Add(poses[static_cast<std::size_t>(f)]);
    std::copy(placed.rotations.begin(), placed.rotations.end(), &clip.rotation(f, 0));
    clip.root_positions().col(f) = placed.root_m;
  }
  return clip;
}

PlacedPose PoseAssembler::Add(const BasePose& pose) {
  if (!first_) {
    place_ += Yaw(heading_) * Eigen::Vector3d(pose.step[0], 0, pose.step[1]);
    heading_ += pose.step[2];
  }
  first_ = false;
  PlacedPose placed{base_.LocalRotations(pose.rotations), Eigen::Vector3d(place_.x(), pose.height_m, place_.z())};
  Eigen::Quaterniond& root = placed.rotations[static_cast<std::size_t>(base_.skeleton().moving_root())];
  root = Yaw(heading_) * root;
  return placed;
}

}  // namespace morphograph
