#include "synthesis/step_joiner.h"

#include <algorithm>
#include <cmath>

#include "primitives/rotation_math.h"

namespace morphograph {
namespace {

// Root motion of a step as increments from frame to frame, and what is left without heading.
struct RootTrack {
  std::vector<Eigen::Vector2d> moved;      // to the next frame, (x, z) in the heading frame of this one
  std::vector<double> turned;              // to the next frame, radians
  std::vector<Eigen::Quaterniond> tilts;   // root rotation with the heading taken out
};

RootTrack Increments(const StepTrack& track, const PoseLayout& layout, const Eigen::Quaterniond& mean) {
  const int frames = track.frames();
  RootTrack root;
  root.moved.resize(frames, Eigen::Vector2d::Zero());
  root.turned.resize(frames, 0);
  root.tilts.resize(frames);
  std::vector<double> headings(frames);
  for (int i = 0; i < frames; ++i) {
    const Eigen::Quaterniond rotation = ExpMapAbout(mean, track.poses.block<3, 1>(3, i));
    headings[i] = layout.HeadingOf(rotation);
    root.tilts[i] = Yaw(-headings[i]) * rotation;
  }
  for (int i = 0; i + 1 < frames; ++i) {
    root.turned[i] = std::remainder(headings[i + 1] - headings[i], 2 * M_PI);
    const Eigen::Vector3d step = track.poses.block<3, 1>(0, i + 1) - track.poses.block<3, 1>(0, i);
    const Eigen::Vector3d local = Yaw(-headings[i] - root.turned[i] / 2) * Eigen::Vector3d(step.x(), 0, step.z());
    root.moved[i] = {local.x(), local.z()};
  }
  return root;
}

double SmoothStep(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (t * (6 * t - 15) + 10);
}

// The steps that count at a time, and how much the second one does.
struct Mix {
  int first = 0;
  int second = 0;
  double second_weight = 0;
};

class MixFinder {
 public:
  MixFinder(const std::vector<StepTrack>& tracks, double frame_rate_hz, bool cross_fade) : tracks_(tracks) {
    for (size_t k = 0; k + 1 < tracks.size(); ++k) {
      half_widths_.push_back(cross_fade ? CrossFadeHalfWidth(tracks[k].end - tracks[k].start,
                                                             tracks[k + 1].end - tracks[k + 1].start, frame_rate_hz)
                                        : kHardCutHalfWidth);
    }
  }

  Mix At(double time) {  // times must not fall by more than a frame from call to call
    while (current_ + 1 < static_cast<int>(tracks_.size()) && time >= tracks_[current_].end + half_widths_[current_]) ++current_;
    while (current_ > 0 && time < tracks_[current_ - 1].end + half_widths_[current_ - 1]) --current_;
    if (current_ >= static_cast<int>(half_widths_.size())) return {current_, current_, 0};
    const double half = half_widths_[current_];
    return {current_, current_ + 1, SmoothStep((time - tracks_[current_].end + half) / (2 * half))};
  }

 private:
  const std::vector<StepTrack>& tracks_;
  std::vector<double> half_widths_;
  int current_ = 0;
};

}  // namespace

JoinedSteps JoinSteps(const MotionGraph& graph, const std::vector<StepTrack>& tracks, int frames, double frame_rate_hz,
                      const StartPose& start, bool cross_fade) {
  const PoseLayout& layout = graph.layout();
  const auto& joints = layout.active_joints();
  const auto means_of = [&](int k) -> const MeanRotations& {
    return graph.styles()[tracks[k].style].mean_rotations;
  };
  std::vector<RootTrack> roots;
  for (size_t k = 0; k < tracks.size(); ++k) {
    roots.push_back(Increments(tracks[k], layout, means_of(static_cast<int>(k))[joints[0]]));
  }

  JoinedSteps joined{MotionClip(graph.shared_skeleton(), frame_rate_hz, frames), ContactProfile::Zero(kContactRows, frames)};
  double heading = start.heading_rad;
  Eigen::Vector2d position = start.position_m;
  MixFinder mixes(tracks, frame_rate_hz, cross_fade);
  for (int f = 0; f < frames; ++f) {
    const Mix mix = mixes.At(f);
    const bool blended = mix.second_weight > 0;
    const auto column = [&](int k) { return std::clamp(f - tracks[k].first_frame, 0, tracks[k].frames() - 1); };
    const int i = column(mix.first);
    const int j = column(mix.second);
    const StepTrack& a = tracks[mix.first];
    const StepTrack& b = tracks[mix.second];
    const double w = mix.second_weight;

    const MeanRotations& means = means_of(mix.first);
    for (int joint = 0; joint < layout.skeleton().joint_count(); ++joint) joined.clip.rotation(f, joint) = means[joint];
    Eigen::VectorXd pose = a.poses.col(i);
    if (blended) pose += w * (b.poses.col(j) - pose);
    for (size_t n = 1; n < joints.size(); ++n) {
      joined.clip.rotation(f, joints[n]) =
          ExpMapAbout(means[joints[n]], pose.segment<3>(3 + 3 * static_cast<Eigen::Index>(n)));
    }
    Eigen::Quaterniond tilt = roots[mix.first].tilts[i];
    if (blended) tilt = tilt.slerp(w, roots[mix.second].tilts[j]);
    joined.clip.rotation(f, joints[0]) = (Yaw(heading) * tilt).normalized();
    joined.clip.root_positions().col(f) = Eigen::Vector3d(position.x(), pose[1], position.y());
    joined.contacts.col(f) = a.contacts.col(i);
    if (blended) joined.contacts.col(f) += w * (b.contacts.col(j) - a.contacts.col(i));

    // Increments belong half way to the next frame, and so does their mix.
    const Mix between = mixes.At(f + 0.5);
    const RootTrack& p = roots[between.first];
    const RootTrack& q = roots[between.second];
    const int ip = column(between.first);
    const int iq = column(between.second);
    const double v = between.second_weight;
    const double turned = (1 - v) * p.turned[ip] + v * q.turned[iq];
    const Eigen::Vector2d moved = (1 - v) * p.moved[ip] + v * q.moved[iq];
    const Eigen::Vector3d world = Yaw(heading + turned / 2) * Eigen::Vector3d(moved.x(), 0, moved.y());
    position += Eigen::Vector2d(world.x(), world.z());
    heading += turned;
  }
  return joined;
}

}  // namespace morphograph
