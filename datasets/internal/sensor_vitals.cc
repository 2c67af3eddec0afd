#include "datasets/internal/sensor_vitals.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "datasets/quantile.h"

namespace morphograph {
namespace {

// Half and six times gravity. On recorded bodies the middle of all lengths is 7 (a head) to 45 (the toes of a runner) m/s^2; taken for g, these would be 71 and more.
constexpr double kLeastGravity_m_s2 = 4.5, kMostGravity_m_s2 = 60;
constexpr double kLeastSteadiness = 0.12;   // length of the mean over the median length; noise that means nothing has next to 0
constexpr double kLeastPresentOfOne = 0.05;
constexpr std::size_t kLeastSamples = 4;
constexpr double kMoves_m_s2 = 0.5;         // standard deviation of the length
constexpr double kStuck_s = 1;

bool IsConstant(const SensorTrack& track) {
  return std::all_of(track.values.begin(), track.values.end(), [&](const Eigen::Vector3d& value) { return value == track.values.front(); });
}

}  // namespace

bool IsLikeGravity(double median_norm) { return median_norm >= kLeastGravity_m_s2 && median_norm <= kMostGravity_m_s2; }

double AccelerationUnit(const std::vector<SensorTrack>& tracks) {
  // The unit under which most sensors show gravity; the first of several.
  double best = 1;
  int most = 0;
  for (const double unit : {1.0, kGravityOfUnits_m_s2, kGravityOfUnits_m_s2 / 1000}) {
    int alike = 0;
    for (const SensorTrack& track : tracks) {
      const double norm = track.MedianNorm();
      alike += !track.empty() && IsLikeGravity(unit * norm) && track.Mean().norm() >= kLeastSteadiness * norm;
    }
    if (alike > most) {
      most = alike;
      best = unit;
    }
  }
  return best;
}

double LeastMean(const std::vector<SensorTrack>& tracks) {
  double least = 0;
  for (const SensorTrack& track : tracks) {
    if (track.empty() || !IsLikeGravity(track.MedianNorm())) continue;
    const double mean = track.Mean().norm();
    if (least == 0 || mean < least) least = mean;
  }
  return least;
}

std::string OddLengths(double least_mean) {
  char text[120];
  std::snprintf(text, sizeof text, "the readings of every sensor are %.0f m/s^2 or more on the average, where gravity is 9.81; are they in m/s^2?", least_mean);
  return text;
}

std::vector<std::string> CausesOfDeath(const std::vector<SensorTrack>& tracks, bool markers, double span_s) {
  std::vector<std::string> causes(tracks.size());
  bool any_moves = false;
  for (std::size_t s = 0; s < tracks.size(); ++s) any_moves = any_moves || (!tracks[s].empty() && !IsConstant(tracks[s]));
  for (std::size_t s = 0; s < tracks.size(); ++s) {
    const SensorTrack& track = tracks[s];
    char text[120];
    if (track.empty()) {
      causes[s] = "says nothing at all";
      continue;
    }
    const double heard_s = static_cast<double>(track.values.size()) * track.step_s;
    if (track.values.size() < kLeastSamples || heard_s < kLeastPresentOfOne * span_s) {
      std::snprintf(text, sizeof text, "says hardly anything in %.0f s", span_s);
      causes[s] = text;
      continue;
    }
    if (markers) continue;  // markers may stand still
    if (any_moves && IsConstant(track)) {
      causes[s] = "says the same all the time";
      continue;
    }
    const double norm = track.MedianNorm();
    if (!std::isfinite(norm)) {
      causes[s] = "shows no gravity: its readings are beyond all measure";
    } else if (!IsLikeGravity(norm)) {
      std::snprintf(text, sizeof text, "shows no gravity: its readings are %.3g m/s^2 long", norm);
      causes[s] = text;
    } else if (track.Mean().norm() < kLeastSteadiness * norm) {
      causes[s] = "is noise: its readings point nowhere on average";
    }
  }
  return causes;
}

std::vector<std::pair<std::size_t, std::size_t>> StuckRuns(const SensorTrack& track) {
  std::vector<std::pair<std::size_t, std::size_t>> runs;
  for (std::size_t first = 0; first < track.values.size();) {
    std::size_t last = first;
    while (last + 1 < track.values.size() && track.values[last + 1] == track.values[first]) ++last;
    if (track.times_s[last] - track.times_s[first] >= kStuck_s) runs.emplace_back(first, last);
    first = last + 1;
  }
  return runs;
}

bool OthersMove(const std::vector<SensorTrack>& tracks, const std::vector<int>& among, int sensor, double from_s, double to_s) {
  for (const int other : among) {
    if (other == sensor) continue;
    const SensorTrack& track = tracks[static_cast<std::size_t>(other)];
    double n = 0, sum = 0, squares = 0;
    for (auto i = static_cast<std::size_t>(std::lower_bound(track.times_s.begin(), track.times_s.end(), from_s) - track.times_s.begin());
         i < track.times_s.size() && track.times_s[i] <= to_s; ++i) {
      const double norm = track.values[i].norm();
      n += 1;
      sum += norm;
      squares += norm * norm;
    }
    if (n > 2 && squares / n - (sum / n) * (sum / n) > kMoves_m_s2 * kMoves_m_s2) return true;
  }
  return false;
}

Eigen::VectorXd TriangleMean(const Eigen::MatrixXd& values, double centre, double half_width) {
  const auto first = std::max<Eigen::Index>(0, static_cast<Eigen::Index>(std::ceil(centre - half_width)));
  const auto last = std::min<Eigen::Index>(values.cols() - 1, static_cast<Eigen::Index>(std::floor(centre + half_width)));
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(values.rows());
  double weights = 0;
  for (Eigen::Index i = first; i <= last; ++i) {
    const double weight = std::max(0.0, 1 - std::abs(static_cast<double>(i) - centre) / half_width);
    sum += weight * values.col(i);
    weights += weight;
  }
  return weights > 0 ? Eigen::VectorXd(sum / weights) : Eigen::VectorXd(values.col(std::clamp<Eigen::Index>(std::llround(centre), 0, values.cols() - 1)));
}

}  // namespace morphograph
