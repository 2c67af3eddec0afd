#include "datasets/resample.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace morphograph {
namespace {

// Pass band edge as a part of the lower rate's Nyquist frequency, and zero crossings of the sinc kept on each side:
// two keep the ringing before a foot strike below a millimetre.
constexpr double kCutoff = 0.9;
constexpr int kCrossings = 2;

struct Tap {
  int frame;  // may lie before the first or after the last frame
  double weight;
};

Eigen::Vector3d RotationVector(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) {
  const Eigen::AngleAxisd turn(from.conjugate() * to);
  return turn.angle() * turn.axis();
}

Eigen::Quaterniond Turned(const Eigen::Quaterniond& from, const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (!(angle > 0)) return from;
  return (from * Eigen::Quaterniond(Eigen::AngleAxisd(angle, vector / angle))).normalized();
}

std::vector<Tap> CubicTaps(double position) {
  const double floor = std::floor(position);
  const double t = position - floor;
  const int frame = static_cast<int>(floor);
  if (t < 1e-9) return {{frame, 1.0}};
  const double t2 = t * t, t3 = t2 * t;
  return {{frame - 1, 0.5 * (-t3 + 2 * t2 - t)},
          {frame, 0.5 * (3 * t3 - 5 * t2 + 2)},
          {frame + 1, 0.5 * (-3 * t3 + 4 * t2 + t)},
          {frame + 2, 0.5 * (t3 - t2)}};
}

// `step`: source frames an output frame, > 1. Hann-windowed sinc; a small correction under the same window makes
// constants and steady motion come out exactly.
std::vector<Tap> LowPassTaps(double position, double step) {
  const double crossing = step / kCutoff;  // source frames between zero crossings
  const double half_width = kCrossings * crossing;
  const auto window = [](double x) { return 0.5 + 0.5 * std::cos(std::numbers::pi * x / kCrossings); };
  std::vector<Tap> taps;
  Eigen::Vector2d missing(1, 0);  // of the sum and of the centre of gravity
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
  for (int frame = static_cast<int>(std::ceil(position - half_width)); frame < position + half_width; ++frame) {
    const double x = (frame - position) / crossing;
    const double sinc = std::abs(x) < 1e-12 ? 1 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
    const Eigen::Vector2d basis(1, x);
    taps.push_back({frame, sinc * window(x) / crossing});
    missing -= taps.back().weight * basis;
    moments += window(x) * basis * basis.transpose();
  }
  const Eigen::Vector2d correction = moments.llt().solve(missing);
  for (Tap& tap : taps) {
    const double x = (tap.frame - position) / crossing;
    tap.weight += window(x) * (correction[0] + correction[1] * x);
  }
  return taps;
}

// Values of a track beyond its ends: mirrored about the end point.
template <typename Value>
Eigen::Vector3d Reflected(int frame, int frames, const Value& value) {
  if (frame < 0) return 2 * value(0) - value(std::min(-frame, frames - 1));
  if (frame >= frames) return 2 * value(frames - 1) - value(std::max(2 * (frames - 1) - frame, 0));
  return value(frame);
}

template <typename Value>
Eigen::Vector3d WeightedSum(const std::vector<Tap>& taps, int frames, const Value& value) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Tap& tap : taps) sum += tap.weight * Reflected(tap.frame, frames, value);
  return sum;
}

}  // namespace

MotionClip Resample(const MotionClip& clip, double frame_rate_hz, std::int64_t max_joint_frames) {
  if (!(frame_rate_hz > 0) || !std::isfinite(frame_rate_hz)) {
    throw std::invalid_argument("Resample: frame rate must be positive");
  }
  const int frames = clip.frame_count();
  const double step = clip.frame_rate_hz() / frame_rate_hz;
  if (frames == 0 || std::abs(step - 1) < 1e-9) return clip;
  // A hair of tolerance keeps the last frame where the rates divide each other.
  const double last = std::floor((frames - 1) / step + 1e-6);
  if ((last + 1) * clip.joint_count() > static_cast<double>(max_joint_frames)) {
    throw std::invalid_argument("Resample: " + std::to_string(clip.duration_s()) + " s of " +
                                std::to_string(clip.joint_count()) + " joints are too long for " +
                                std::to_string(frame_rate_hz) + " frames a second; at most " +
                                std::to_string(max_joint_frames) + " rotations are made");
  }

  MotionClip resampled(clip.shared_skeleton(), frame_rate_hz, static_cast<int>(last) + 1);
  resampled.name = clip.name;
  resampled.style = clip.style;
  for (int f = 0; f < resampled.frame_count(); ++f) {
    const double position = std::min(f * step, frames - 1.0);
    const std::vector<Tap> taps = step > 1 ? LowPassTaps(position, step) : CubicTaps(position);
    resampled.root_positions().col(f) = WeightedSum(
        taps, frames, [&](int frame) -> Eigen::Vector3d { return clip.root_positions().col(frame); });
    const int base = static_cast<int>(position);
    for (int j = 0; j < clip.joint_count(); ++j) {
      const Eigen::Quaterniond& reference = clip.rotation(base, j);
      const Eigen::Vector3d vector = WeightedSum(
          taps, frames, [&](int frame) { return RotationVector(reference, clip.rotation(frame, j)); });
      Eigen::Quaterniond& rotation = resampled.rotation(f, j);
      rotation = Turned(reference, vector);
      if (f > 0 && rotation.dot(resampled.rotation(f - 1, j)) < 0) rotation.coeffs() *= -1;
    }
  }
  return resampled;
}

MotionClip Retimed(const MotionClip& clip, double frame_rate_hz) {
  if (!(frame_rate_hz > 0) || !std::isfinite(frame_rate_hz)) throw std::invalid_argument("Retimed: frame rate must be positive");
  MotionClip played(clip.shared_skeleton(), frame_rate_hz, clip.frame_count());
  played.name = clip.name;
  played.style = clip.style;
  for (int f = 0; f < clip.frame_count(); ++f) std::copy_n(clip.rotations(f), clip.joint_count(), &played.rotation(f, 0));
  played.root_positions() = clip.root_positions();
  return played;
}

MotionClip Reversed(const MotionClip& clip) {
  MotionClip reversed(clip.shared_skeleton(), clip.frame_rate_hz(), clip.frame_count());
  reversed.name = clip.name;
  reversed.style = clip.style;
  for (int f = 0; f < clip.frame_count(); ++f) std::copy_n(clip.rotations(clip.frame_count() - 1 - f), clip.joint_count(), &reversed.rotation(f, 0));
  reversed.root_positions() = clip.root_positions().rowwise().reverse();
  return reversed;
}

}  // namespace morphograph
