#include "datasets/contact_detector.h"

#include <Eigen/Geometry>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

#include "datasets/forward_kinematics.h"
#include "datasets/low_pass.h"
#include "datasets/quantile.h"

namespace morphograph {
namespace {

constexpr double kFilterAboveHz = 60;  // below it a stance is too few frames to be filtered
constexpr double kFlatSpeed = 0.25;    // m/s; ankle and ball of a foot that lies flat on the floor
constexpr double kStanceSpeed = 0.3;   // m/s; ball of a foot that may define the floor
constexpr double kStanceTime = 0.1;    // s; shortest stance that may define the floor
constexpr double kLifted = 0.2;        // m; a still foot this far above the other still foot is held in the air
constexpr double kSlopeSpread = 0.3;   // m; spread of stances below which a slope along it is not seen

struct FootPath {
  Eigen::Matrix3Xd ankle, ball, heel;
  std::vector<Eigen::Quaterniond> rotation;  // world_from_foot
};

// A time in which a ball of the foot stands still.
struct Stance {
  int first, last;
  Eigen::Vector3d ball;  // medians
};

Eigen::Vector3d MedianPoint(const Eigen::Matrix3Xd& points) {
  Eigen::Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::VectorXd row = points.row(axis);
    median[axis] = Median({row.begin(), row.end()});
  }
  return median;
}

// The smaller of backward and forward difference: a frame next to a still one is still.
Eigen::VectorXd Speeds(const Eigen::Matrix3Xd& path, double rate_hz) {
  const Eigen::Index frames = path.cols();
  Eigen::VectorXd speeds = Eigen::VectorXd::Zero(frames);
  if (frames < 2) return speeds;
  const Eigen::VectorXd steps =
      (path.rightCols(frames - 1) - path.leftCols(frames - 1)).colwise().norm().transpose() * rate_hz;
  speeds[0] = steps[0];
  speeds[frames - 1] = steps[frames - 2];
  for (Eigen::Index f = 1; f + 1 < frames; ++f) speeds[f] = std::min(steps[f - 1], steps[f]);
  return speeds;
}

// Deviation of white noise on a coordinate, metres: median fourth difference of samples some 1/30 s apart, in which motion cancels.
double Jitter(const FootPath (&feet)[2], double rate_hz) {
  const int apart = std::max(1, static_cast<int>(std::lround(rate_hz / 30)));
  std::vector<double> sizes;
  for (const FootPath& foot : feet) {
    for (const Eigen::Matrix3Xd* path : {&foot.ankle, &foot.ball}) {
      for (Eigen::Index f = 2 * apart; f + 2 * apart < path->cols(); ++f) {
        const Eigen::Vector3d fourth = path->col(f - 2 * apart) - 4 * path->col(f - apart) + 6 * path->col(f) -
                                       4 * path->col(f + apart) + path->col(f + 2 * apart);
        for (const double d : fourth) sizes.push_back(std::abs(d));
      }
    }
  }
  if (sizes.empty()) return 0;
  constexpr double kMedianOfNormal = 0.6745;
  return Median(std::move(sizes)) / kMedianOfNormal / std::sqrt(70.0);  // 70 = 1 + 16 + 36 + 16 + 1
}

void RequireRoles(const MotionClip& clip) {
  const std::vector<std::string> missing =
      clip.skeleton().roles().Missing({JointRole::kLeftKnee, JointRole::kLeftAnkle, JointRole::kLeftToe,
                                       JointRole::kRightKnee, JointRole::kRightAnkle, JointRole::kRightToe});
  if (missing.empty()) return;
  std::string names;
  for (const std::string& name : missing) names += (names.empty() ? "" : ", ") + name;
  throw std::invalid_argument("DetectContacts: the skeleton of '" + clip.name + "' has no joint for: " + names);
}

// The half of the values, at least one, that lie closest together, as positions (the shorth; Andrews et al. 1972).
std::vector<size_t> ClosestHalf(const std::vector<double>& values) {
  std::vector<size_t> order(values.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return values[a] < values[b]; });
  const size_t half = (values.size() + 1) / 2;
  size_t best = 0;
  const auto width = [&](size_t first) { return values[order[first + half - 1]] - values[order[first]]; };
  for (size_t first = 1; first + half <= order.size(); ++first) {
    if (width(first) < width(best)) best = first;
  }
  return {order.begin() + static_cast<std::ptrdiff_t>(best), order.begin() + static_cast<std::ptrdiff_t>(best + half)};
}

// Where the heel lies in the foot's own frame, from the frames in which the foot is flat. A foot that never is
// (a run, a jump) takes half of its slowest tenth of frames. Among slow frames are some in which the heel already leaves the floor, the more the slower
// somebody walks; flat are those that agree how far the ankle is above the ball.
Eigen::Vector3d HeelInFoot(const FootPath& foot, double rate_hz, double behind_m) {
  const int frames = static_cast<int>(foot.ball.cols());
  const Eigen::VectorXd speed =
      Speeds(foot.ankle, rate_hz).cwiseMax(Speeds(foot.ball, rate_hz));
  std::vector<double> sorted(speed.begin(), speed.end());
  std::sort(sorted.begin(), sorted.end());
  const double limit = std::max(kFlatSpeed, sorted[sorted.size() / 10]);
  std::vector<Eigen::Vector3d> heels;
  std::vector<double> rises;  // of the ankle over the ball
  for (int f = 0; f < frames; ++f) {
    if (speed[f] > limit) continue;
    const Eigen::Vector3d along = foot.ball.col(f) - foot.ankle.col(f);
    Eigen::Vector3d forward(along.x(), 0, along.z());
    if (forward.norm() < 1e-6) continue;
    forward.normalize();
    const Eigen::Vector3d heel = Eigen::Vector3d(0, along.y(), 0) - behind_m * forward;
    heels.push_back(foot.rotation[f].conjugate() * heel);
    rises.push_back(-along.y());
  }
  if (heels.empty()) return Eigen::Vector3d::Zero();
  const std::vector<size_t> flat = ClosestHalf(rises);
  Eigen::Matrix3Xd of_flat(3, static_cast<Eigen::Index>(flat.size()));
  for (size_t i = 0; i < flat.size(); ++i) of_flat.col(static_cast<Eigen::Index>(i)) = heels[flat[i]];
  return MedianPoint(of_flat);
}

std::vector<Stance> StillBalls(const Eigen::Matrix3Xd& ball, double rate_hz) {
  const Eigen::VectorXd speed = Speeds(ball, rate_hz);
  const int frames = static_cast<int>(ball.cols());
  std::vector<Stance> stances;
  for (int f = 0; f < frames; ++f) {
    if (speed[f] >= kStanceSpeed) continue;
    int last = f;
    while (last + 1 < frames && speed[last + 1] < kStanceSpeed) ++last;
    if (last - f + 1 >= kStanceTime * rate_hz) stances.push_back({f, last, MedianPoint(ball.middleCols(f, last - f + 1))});
    f = last;
  }
  return stances;
}

std::vector<Stance> FloorStances(const FootPath (&feet)[2], double rate_hz) {
  const std::vector<Stance> still[2] = {StillBalls(feet[0].ball, rate_hz), StillBalls(feet[1].ball, rate_hz)};
  std::vector<Stance> stances;
  for (int side = 0; side < 2; ++side) {
    for (const Stance& stance : still[side]) {
      const bool lifted = std::any_of(still[1 - side].begin(), still[1 - side].end(), [&](const Stance& other) {
        return other.first <= stance.last && stance.first <= other.last && stance.ball.y() > other.ball.y() + kLifted;
      });
      if (!lifted) stances.push_back(stance);
    }
  }
  std::stable_sort(stances.begin(), stances.end(),
                   [](const Stance& a, const Stance& b) { return a.first + a.last < b.first + b.last; });
  return stances;
}

// Plane through the stances with a slope only along directions in which they spread.
std::optional<FloorPlane> FitPlane(const std::vector<Stance>& stances, double max_residual_m) {
  if (stances.empty()) return std::nullopt;
  const auto count = static_cast<Eigen::Index>(stances.size());
  Eigen::Matrix2Xd places(2, count);
  Eigen::VectorXd heights(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    places.col(i) = Eigen::Vector2d(stances[i].ball.x(), stances[i].ball.z());
    heights[i] = stances[i].ball.y();
  }
  FloorPlane plane;
  plane.origin = places.rowwise().mean();
  plane.height_m = heights.mean();
  places.colwise() -= plane.origin;
  heights.array() -= plane.height_m;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> spread(places * places.transpose() / static_cast<double>(count));
  for (int axis = 0; axis < 2 && count > 2; ++axis) {
    if (spread.eigenvalues()[axis] < kSlopeSpread * kSlopeSpread) continue;
    const Eigen::Vector2d direction = spread.eigenvectors().col(axis);
    const Eigen::VectorXd along = places.transpose() * direction;
    plane.slope += direction * (along.dot(heights) / along.squaredNorm());
  }
  const Eigen::VectorXd residual = heights - places.transpose() * plane.slope;
  if (std::sqrt(residual.squaredNorm() / static_cast<double>(count)) > max_residual_m) return std::nullopt;
  return plane;
}

// Height of the floor per frame: level through each stance, straight between one and the next.
Eigen::VectorXd FloorInTime(const std::vector<Stance>& stances, int frames) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(frames);
  int next = 0;  // stance whose middle comes after the frame
  for (int f = 0; f < frames; ++f) {
    const auto middle = [&](int i) { return 0.5 * (stances[i].first + stances[i].last); };
    while (next < static_cast<int>(stances.size()) && middle(next) <= f) ++next;
    if (next == 0) {
      sum[f] = stances.front().ball.y();
    } else if (next == static_cast<int>(stances.size())) {
      sum[f] = stances.back().ball.y();
    } else {
      const double span = middle(next) - middle(next - 1);
      const double t = span > 0 ? (f - middle(next - 1)) / span : 0;
      sum[f] = (1 - t) * stances[next - 1].ball.y() + t * stances[next].ball.y();
    }
  }
  return sum;
}

using Flags = std::vector<char>;

void CloseGaps(Flags* flags, double max_frames) {
  const int frames = static_cast<int>(flags->size());
  int last_set = -1;
  for (int f = 0; f < frames; ++f) {
    if (!(*flags)[f]) continue;
    const int gap = f - last_set - 1;
    if (last_set >= 0 && gap > 0 && gap <= max_frames) std::fill_n(flags->begin() + last_set + 1, gap, 1);
    last_set = f;
  }
}

std::vector<ContactInterval> Runs(const Flags& flags, Foot foot, double min_frames) {
  std::vector<ContactInterval> runs;
  const int frames = static_cast<int>(flags.size());
  for (int f = 0; f < frames; ++f) {
    if (!flags[f]) continue;
    int last = f;
    while (last + 1 < frames && flags[last + 1]) ++last;
    if (last - f + 1 >= min_frames) runs.push_back({foot, f, last});
    f = last;
  }
  return runs;
}

// `pose_of(f)` gives the world pose of frame f; frames are asked for in order.
template <typename PoseOf>
ContactTrack Detect(const MotionClip& clip, PoseOf pose_of, const ContactOptions& options) {
  RequireRoles(clip);
  const RoleMap& roles = clip.skeleton().roles();
  const int frames = clip.frame_count();
  const double rate = clip.frame_rate_hz();
  const int ankles[2] = {roles[JointRole::kLeftAnkle], roles[JointRole::kRightAnkle]};
  const int toes[2] = {roles[JointRole::kLeftToe], roles[JointRole::kRightToe]};

  ContactTrack track;
  track.planted.setZero(4, frames);
  track.ground_m.setZero(frames);
  FootPath feet[2];
  for (FootPath& foot : feet) {
    foot.ankle.resize(3, frames);
    foot.ball.resize(3, frames);
    foot.rotation.resize(frames);
  }
  if (frames == 0) {
    for (int side = 0; side < 2; ++side) track.heels[side] = track.balls[side] = feet[side].ball;
    return track;
  }

  for (int f = 0; f < frames; ++f) {
    const WorldPose& pose = pose_of(f);
    for (int side = 0; side < 2; ++side) {
      feet[side].ankle.col(f) = pose.positions.col(ankles[side]);
      feet[side].ball.col(f) = pose.positions.col(toes[side]);
      feet[side].rotation[f] = pose.rotations[ankles[side]];
    }
  }
  const bool jittery = Jitter(feet, rate) > options.jitter_m;
  for (FootPath& foot : feet) {
    if (!jittery) break;
    foot.ankle = LowPass(foot.ankle, rate, options.jittery_low_pass_hz);
    foot.ball = LowPass(foot.ball, rate, options.jittery_low_pass_hz);
  }
  for (int side = 0; side < 2; ++side) {
    FootPath& foot = feet[side];
    const Eigen::Vector3d heel_in_foot = HeelInFoot(foot, rate, options.heel_behind_m);
    foot.heel.resize(3, frames);
    for (int f = 0; f < frames; ++f) foot.heel.col(f) = foot.ankle.col(f) + foot.rotation[f] * heel_in_foot;
    if (jittery) foot.heel = LowPass(foot.heel, rate, options.jittery_low_pass_hz);
    if (rate > kFilterAboveHz) {
      foot.ball = LowPass(foot.ball, rate, options.low_pass_hz);
      foot.heel = LowPass(foot.heel, rate, options.low_pass_hz);
    }
  }

  const std::vector<Stance> stances = FloorStances(feet, rate);
  track.plane = FitPlane(stances, options.plane_residual_m);
  if (stances.empty()) {
    // Nothing ever stands still: the lowest point that a ball reaches is the only floor there is.
    track.ground_m.setConstant(std::min(feet[0].ball.row(1).minCoeff(), feet[1].ball.row(1).minCoeff()));
  } else if (track.plane) {
    for (int f = 0; f < frames; ++f) {
      track.ground_m[f] = track.plane->HeightAt(clip.root_positions()(0, f), clip.root_positions()(2, f));
    }
  } else {
    track.ground_m = FloorInTime(stances, frames);
  }

  for (int side = 0; side < 2; ++side) {
    const Eigen::Matrix3Xd* points[2] = {&feet[side].heel, &feet[side].ball};
    Flags low_and_slow[2], either(frames, 0);
    for (int part = 0; part < 2; ++part) {
      const Eigen::Matrix3Xd& path = *points[part];
      const Eigen::VectorXd speed = Speeds(path, rate);
      low_and_slow[part].assign(frames, 0);
      for (int f = 0; f < frames; ++f) {
        const double floor = track.plane ? track.plane->HeightAt(path(0, f), path(2, f)) : track.ground_m[f];
        low_and_slow[part][f] = path(1, f) - floor < options.height_m && speed[f] < options.speed_m_s;
        either[f] |= low_and_slow[part][f];
      }
    }
    CloseGaps(&either, options.max_gap_s * rate);
    const Foot foot = side == 0 ? Foot::kLeft : Foot::kRight;
    for (const ContactInterval& contact : Runs(either, foot, options.min_contact_s * rate)) {
      track.intervals.push_back(contact);
      for (int part = 0; part < 2; ++part) {
        Flags inside(low_and_slow[part].begin() + contact.first, low_and_slow[part].begin() + contact.last + 1);
        CloseGaps(&inside, options.max_gap_s * rate);
        for (int f = contact.first; f <= contact.last; ++f) {
          track.planted(2 * side + part, f) = static_cast<std::uint8_t>(inside[f - contact.first]);
        }
      }
    }
    track.heels[side] = std::move(feet[side].heel);
    track.balls[side] = std::move(feet[side].ball);
  }
  std::stable_sort(track.intervals.begin(), track.intervals.end(),
                   [](const ContactInterval& a, const ContactInterval& b) { return a.first < b.first; });
  return track;
}

}  // namespace

ContactTrack DetectContacts(const MotionClip& clip, const ContactOptions& options) {
  WorldPose pose;
  const auto pose_of = [&](int f) -> const WorldPose& {
    ForwardKinematics(clip.skeleton(), clip.rotations(f), clip.root_positions().col(f), &pose);
    return pose;
  };
  return Detect(clip, pose_of, options);
}

ContactTrack DetectContacts(const MotionClip& clip, const std::vector<WorldPose>& poses, const ContactOptions& options) {
  if (static_cast<int>(poses.size()) != clip.frame_count()) {
    throw std::invalid_argument("DetectContacts: " + std::to_string(poses.size()) + " poses for " +
                                std::to_string(clip.frame_count()) + " frames");
  }
  return Detect(clip, [&](int f) -> const WorldPose& { return poses[static_cast<size_t>(f)]; }, options);
}

}  // namespace morphograph
