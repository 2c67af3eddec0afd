#include "datasets/noise_model.h"

#include <algorithm>
#include <array>
#include <boost/random/exponential_distribution.hpp>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>

#include "datasets/internal/cubic_spline.h"

namespace morphograph {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

enum class NoiseKind : std::uint32_t { kJitter, kSlip, kDropout };

// A stream of its own for each kind of noise and each place: none shifts another.
std::mt19937_64 Stream(const std::string& clip, std::uint64_t seed, NoiseKind kind, size_t place) {
  std::vector<std::uint32_t> words = {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                                      static_cast<std::uint32_t>(kind), static_cast<std::uint32_t>(place)};
  for (const char c : clip) words.push_back(static_cast<unsigned char>(c));
  std::seed_seq sequence(words.begin(), words.end());  // its mixing is laid down by the standard
  return std::mt19937_64(sequence);
}

Quaterniond Turn(const Vector3d& axis_angle) {
  const double angle = axis_angle.norm();
  return angle > 0 ? Quaterniond(Eigen::AngleAxisd(angle, axis_angle / angle)) : Quaterniond::Identity();
}

// White noise of unit deviation, (dims x frames): a draw a camera frame, between them by spline.
Eigen::MatrixXd WhiteNoise(int dims, int frames, double rate_hz, double camera_hz, std::mt19937_64& rng) {
  boost::random::normal_distribution<double> normal;
  const bool every_frame = rate_hz <= camera_hz * 1.01;
  const int draws = every_frame ? frames : static_cast<int>(std::ceil((frames - 1) * camera_hz / rate_hz)) + 2;
  Eigen::MatrixXd noise(dims, draws);
  for (int f = 0; f < draws; ++f) {
    for (int d = 0; d < dims; ++d) noise(d, f) = normal(rng);
  }
  if (every_frame) return noise;
  std::vector<double> knots(draws);
  for (int f = 0; f < draws; ++f) knots[f] = f;
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(dims);
  const CubicSpline spline(std::move(knots), std::move(noise), still, still);
  Eigen::MatrixXd between(dims, frames);
  for (int f = 0; f < frames; ++f) between.col(f) = spline.At(f * camera_hz / rate_hz);
  return between;
}

struct Spell {
  double from_s, length_s;
};

// A Poisson process; spells may begin before the clip does, so that its start is like the rest of it.
std::vector<Spell> DrawSpells(double per_s, double mean_s, double duration_s, std::mt19937_64& rng) {
  std::vector<Spell> spells;
  if (per_s <= 0) return spells;
  boost::random::exponential_distribution<double> gap(per_s);
  boost::random::uniform_real_distribution<double> part(0.5, 1.5);
  for (double t = -1.5 * mean_s + gap(rng); t < duration_s; t += gap(rng)) spells.push_back({t, mean_s * part(rng)});
  return spells;
}

Vector3d RandomDirection(std::mt19937_64& rng) {
  boost::random::normal_distribution<double> normal;
  Vector3d v = Vector3d::Zero();
  while (v.norm() < 1e-6) {
    for (int i = 0; i < 3; ++i) v[i] = normal(rng);
  }
  return v.normalized();
}

// Sum of the slips of one place at every frame (3 x frames): each rises to its greatest value and falls back along sin^2.
Eigen::Matrix3Xd Slips(const MotionClip& clip, const NoiseOptions& options, double deviation, std::mt19937_64& rng) {
  Eigen::Matrix3Xd sum = Eigen::Matrix3Xd::Zero(3, clip.frame_count());
  boost::random::normal_distribution<double> greatest(0, 1);
  for (const Spell& spell : DrawSpells(options.slips_per_s, options.slip_s, clip.duration_s(), rng)) {
    const Vector3d size = RandomDirection(rng) * (deviation * greatest(rng));
    for (int f = 0; f < clip.frame_count(); ++f) {
      const double u = (f / clip.frame_rate_hz() - spell.from_s) / spell.length_s;
      if (u <= 0 || u >= 1) continue;
      const double rise = std::sin(std::numbers::pi * u);
      sum.col(f) += rise * rise * size;
    }
  }
  return sum;
}

// For every frame the one that is shown: itself, or the last before the dropout that it lies in.
std::vector<int> ShownFrames(const MotionClip& clip, const NoiseOptions& options, std::mt19937_64& rng) {
  std::vector<int> shown(clip.frame_count());
  for (int f = 0; f < clip.frame_count(); ++f) shown[f] = f;
  for (const Spell& spell : DrawSpells(options.dropouts_per_s, options.dropout_s, clip.duration_s(), rng)) {
    const double from = spell.from_s * clip.frame_rate_hz();
    const int last_seen = static_cast<int>(std::ceil(from)) - 1;
    if (last_seen < 0) continue;  // what was there before the clip is not known
    const double end = from + spell.length_s * clip.frame_rate_hz();
    for (int f = last_seen + 1; f < clip.frame_count() && f < end; ++f) shown[f] = std::min(shown[f], shown[last_seen]);
  }
  return shown;
}

void Check(const NoiseOptions& options) {
  const auto check = [](const char* name, double value, bool positive) {
    if (std::isfinite(value) && value >= 0 && !(positive && value == 0)) return;
    throw std::invalid_argument(std::string("AddNoise: ") + name + " is " + std::to_string(value) + "; must be finite and " +
                                (positive ? "> 0" : ">= 0"));
  };
  check("leaf_jitter_rad", options.leaf_jitter_rad, false);
  check("root_jitter_m", options.root_jitter_m, false);
  check("root_jitter_rad", options.root_jitter_rad, false);
  check("slips_per_s", options.slips_per_s, false);
  check("slip_rad", options.slip_rad, false);
  check("slip_m", options.slip_m, false);
  check("slip_s", options.slip_s, true);
  check("dropouts_per_s", options.dropouts_per_s, false);
  check("dropout_s", options.dropout_s, true);
  check("camera_hz", options.camera_hz, true);
}

}  // namespace

std::vector<std::vector<int>> NoisyLimbs(const Skeleton& skeleton) {
  const int joints = skeleton.joint_count(), root = skeleton.moving_root();
  static constexpr std::array kEnds = {JointRole::kHead, JointRole::kLeftWrist, JointRole::kRightWrist, JointRole::kLeftAnkle,
                                       JointRole::kRightAnkle};
  std::vector<char> taken(joints, 0);
  const auto inner = [&](int j) { return j < 0 || !skeleton.IsBody(j) || j == root; };
  const auto is_below = [&](int j, int top) {
    while (j > top) j = skeleton.parent(j);  // parents precede children
    return j == top;
  };
  std::vector<std::vector<int>> limbs;
  for (const JointRole role : kEnds) {
    const int end = skeleton.roles()[role];
    if (inner(end) || taken[end]) continue;
    std::vector<int> limb;
    // The first joint above with a bone between it and the end: turning one without would not move the end. Where it carries
    // other ends too, as a chest does, it is no part of this limb.
    int top = end;
    while (!inner(top) && skeleton.joint(top).offset_m.norm() < 1e-6) top = skeleton.parent(top);
    top = inner(top) ? -1 : skeleton.parent(top);
    const auto carries = [&](JointRole other) { return skeleton.roles().Has(other) && is_below(skeleton.roles()[other], top); };
    if (!inner(top) && std::count_if(kEnds.begin(), kEnds.end(), carries) == 1) limb.push_back(top), taken[top] = 1;
    for (int j = end; j < joints; ++j) {
      if (!taken[j] && is_below(j, end)) limb.push_back(j), taken[j] = 1;
    }
    limbs.push_back(std::move(limb));
  }
  if (!limbs.empty()) return limbs;
  std::vector<char> has_child(joints, 0);
  for (int j = 0; j < joints; ++j) {
    if (skeleton.parent(j) >= 0) has_child[skeleton.parent(j)] = 1;
  }
  for (int j = 0; j < joints; ++j) {
    if (has_child[j] || inner(j) || taken[j]) continue;
    const int parent = skeleton.parent(j);
    std::vector<int> limb;
    for (const int member : {parent, j}) {
      if (!inner(member) && !taken[member]) limb.push_back(member), taken[member] = 1;
    }
    limbs.push_back(std::move(limb));
  }
  return limbs;
}

MotionClip AddNoise(const MotionClip& clip, const NoiseOptions& options, std::uint64_t seed) {
  Check(options);
  MotionClip noisy = clip;
  const int frames = clip.frame_count(), root = clip.skeleton().moving_root();
  if (frames == 0) return noisy;
  // The first limb is the root's own place.
  std::vector<std::vector<int>> places = NoisyLimbs(clip.skeleton());
  places.insert(places.begin(), {root});
  for (size_t place = 0; place < places.size(); ++place) {
    const std::vector<int>& joints = places[place];
    const bool is_root = place == 0;
    std::mt19937_64 jitter_rng = Stream(clip.name, seed, NoiseKind::kJitter, place);
    std::mt19937_64 slip_rng = Stream(clip.name, seed, NoiseKind::kSlip, place);
    std::mt19937_64 dropout_rng = Stream(clip.name, seed, NoiseKind::kDropout, place);
    const double jitter_rad = is_root ? options.root_jitter_rad : options.leaf_jitter_rad;
    for (const int joint : joints) {
      const Eigen::MatrixXd turns = WhiteNoise(3, frames, clip.frame_rate_hz(), options.camera_hz, jitter_rng);
      for (int f = 0; f < frames && jitter_rad > 0; ++f) {
        noisy.rotation(f, joint) = noisy.rotation(f, joint) * Turn(jitter_rad * turns.col(f));
      }
    }
    const Eigen::Matrix3Xd slips = Slips(clip, options, is_root ? options.slip_m : options.slip_rad, slip_rng);
    if (is_root) {
      noisy.root_positions() += options.root_jitter_m * WhiteNoise(3, frames, clip.frame_rate_hz(), options.camera_hz, jitter_rng) + slips;
    } else {
      // The joint that moves the end takes the whole limb with it.
      for (int f = 0; f < frames; ++f) {
        if (!slips.col(f).isZero(0)) noisy.rotation(f, joints.front()) = noisy.rotation(f, joints.front()) * Turn(slips.col(f));
      }
    }
    const std::vector<int> shown = ShownFrames(clip, options, dropout_rng);
    for (int f = 0; f < frames; ++f) {
      if (shown[f] == f) continue;
      for (const int joint : joints) noisy.rotation(f, joint) = noisy.rotation(shown[f], joint);
      if (is_root) noisy.root_positions().col(f) = noisy.root_positions().col(shown[f]).eval();
    }
  }
  return noisy;
}

}  // namespace morphograph
