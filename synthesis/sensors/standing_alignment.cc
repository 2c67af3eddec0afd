#include "synthesis/sensors/standing_alignment.h"

#include <limits>
#include <stdexcept>

#include "datasets/low_pass.h"
#include "datasets/quantile.h"
#include "datasets/sensor_alignment.h"
#include "datasets/turn_between.h"
#include "datasets/virtual_sensors.h"

namespace morphograph {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double kLeastStanding_s = 1, kLeastTold_s = 0.5;
constexpr double kUnrest_hz = 3;          // noise counts little below it, steps do
constexpr double kNearGravity_m_s2 = 1;
constexpr double kMotion_hz = 6;          // of the motion that sensors are compared over
constexpr double kMostDelay_s = 0.2;
constexpr double kLeastAgreement = 0.5;   // correlation
constexpr double kLeastDelay_s = 0.025;   // less is not told from none

struct Span {
  Index first, count;
};

Span SpanOf(const Eigen::MatrixXd& readings, double rate_hz, const StandingPhase& phase) {
  const auto first = static_cast<Index>(std::lround(phase.from_s * rate_hz)), last = static_cast<Index>(std::lround(phase.to_s * rate_hz));
  if (!(phase.from_s >= 0) || last >= readings.cols() + 1 || last - first < static_cast<Index>(kLeastTold_s * rate_hz))
    throw std::invalid_argument("a standing phase must last " + std::to_string(kLeastTold_s).substr(0, 3) + " s or more and lie within the readings");
  return {first, std::min(last, readings.cols() - 1) - first + 1};
}

// This share of a turn.
Eigen::Quaterniond Part(const Eigen::Quaterniond& turn, double share) { return Eigen::Quaterniond::Identity().slerp(share, turn); }

// Root mean square about the mean, over columns.
double Spread(const Eigen::Ref<const Eigen::MatrixXd>& values) {
  return std::sqrt((values.colwise() - values.rowwise().mean()).squaredNorm() / static_cast<double>(values.cols()));
}

double Correlation(Eigen::VectorXd a, Eigen::VectorXd b) {
  a.array() -= a.mean();
  b.array() -= b.mean();
  const double scale = a.norm() * b.norm();
  return scale > 0 ? a.dot(b) / scale : 0;
}

// Seconds by which `later` comes after `reference`: the shift of the highest correlation, between samples by a parabola; 0 where it is low.
double DelayOf(const Eigen::VectorXd& reference, const Eigen::VectorXd& later, double rate_hz) {
  const auto most = static_cast<Index>(std::lround(kMostDelay_s * rate_hz));
  const Index samples = reference.size();
  if (samples < 4 * most + 4) return 0;
  Eigen::VectorXd correlations(2 * most + 1);
  // The same samples of the reference at every shift, or ends would decide.
  for (Index shift = -most; shift <= most; ++shift)
    correlations[shift + most] = Correlation(reference.segment(most, samples - 2 * most), later.segment(most + shift, samples - 2 * most));
  Index best = 0;
  if (correlations.maxCoeff(&best) < kLeastAgreement || best == 0 || best == 2 * most) return 0;
  const double before = correlations[best - 1], at = correlations[best], after = correlations[best + 1];
  const double bend = before - 2 * at + after;
  return (static_cast<double>(best - most) + (bend < 0 ? 0.5 * (before - after) / bend : 0)) / rate_hz;
}

Eigen::Matrix3Xd Shifted(const Eigen::Matrix3Xd& readings, double samples) {
  Eigen::Matrix3Xd shifted(3, readings.cols());
  for (Index i = 0; i < readings.cols(); ++i) {
    const double at = std::clamp(static_cast<double>(i) + samples, 0.0, static_cast<double>(readings.cols() - 1));
    const auto low = std::min(static_cast<Index>(at), std::max<Index>(readings.cols() - 2, 0));
    const Index high = std::min(low + 1, readings.cols() - 1);
    shifted.col(i) = readings.col(low) + (at - static_cast<double>(low)) * (readings.col(high) - readings.col(low));
  }
  return shifted;
}

}  // namespace

std::optional<StandingPhase> FindStanding(const Eigen::MatrixXd& readings, double rate_hz) {
  if (!(rate_hz > 0)) throw std::invalid_argument("FindStanding: the rate must be positive");
  const auto window = static_cast<Index>(std::lround(kLeastStanding_s * rate_hz));
  if (readings.cols() < window) return std::nullopt;
  const Eigen::MatrixXd smooth = LowPass(readings, rate_hz, kUnrest_hz);
  const auto lies_still = [&](Index first) {
    for (Index s = 0; s < smooth.rows(); s += 3) {
      const auto sensor = smooth.block(s, first, 3, window);
      if (std::abs(sensor.rowwise().mean().norm() - kGravity_m_s2) > kNearGravity_m_s2 || Spread(sensor) > kMostUnrest_m_s2) return false;
    }
    return true;
  };
  std::optional<StandingPhase> longest;
  for (Index first = 0; first + window <= smooth.cols(); ++first) {
    if (!lies_still(first)) continue;
    Index last = first;  // beginnings of windows
    while (last + window < smooth.cols() && lies_still(last + 1)) ++last;
    const StandingPhase phase{static_cast<double>(first) / rate_hz, static_cast<double>(last + window - 1) / rate_hz};
    if (!longest || phase.to_s - phase.from_s > longest->to_s - longest->from_s) longest = phase;
    first = last;
  }
  return longest;
}

Eigen::VectorXd UnrestOf(const Eigen::MatrixXd& readings, double rate_hz, const StandingPhase& phase) {
  const Span span = SpanOf(readings, rate_hz, phase);
  const Eigen::MatrixXd smooth = LowPass(readings, rate_hz, kUnrest_hz).middleCols(span.first, span.count);
  Eigen::VectorXd unrest(readings.rows() / 3);
  for (Index s = 0; s < unrest.size(); ++s) unrest[s] = Spread(smooth.middleRows<3>(3 * s));
  return unrest;
}

SensorTurns AlignByStanding(const WornSensors& worn, const Eigen::MatrixXd& readings, double rate_hz, const StandingPhase& phase) {
  if (readings.rows() != 3 * worn.up.cols()) throw std::invalid_argument("AlignByStanding: readings of other sensors");
  const Span span = SpanOf(readings, rate_hz, phase);
  SensorTurns turns;
  turns.standing = phase;
  turns.guessed = !worn.standing;
  for (Index s = 0; s < worn.up.cols(); ++s) {
    const Vector3d up = readings.block(3 * s, span.first, 3, span.count).rowwise().mean();
    turns.sensors.push_back({Part(TurnBetween(up.normalized(), worn.up.col(s)), TiltTrust(worn.spread_rad[s])), 0});
  }
  return turns;
}

void AlignByMotion(const WornSensors& worn, const Eigen::MatrixXd& readings, const Eigen::MatrixXd& expected, double rate_hz, SensorTurns* turns) {
  if (expected.rows() != readings.rows() || expected.cols() != readings.cols() || readings.rows() != 3 * static_cast<Index>(turns->sensors.size()))
    throw std::invalid_argument("AlignByMotion: readings of other sensors, or not as many as are expected");
  const Span standing = SpanOf(readings, rate_hz, turns->standing);
  std::vector<Index> moving;
  for (Index i = 0; i < readings.cols(); ++i)
    if (i < standing.first || i >= standing.first + standing.count) moving.push_back(i);
  if (moving.size() < static_cast<std::size_t>(rate_hz)) return;
  const Eigen::MatrixXd found = LowPass(AlignedReadings(readings, rate_hz, *turns), rate_hz, kMotion_hz), wanted = LowPass(expected, rate_hz, kMotion_hz);

  Eigen::VectorXd delays(static_cast<Index>(turns->sensors.size()));
  for (Index s = 0; s < delays.size(); ++s) {
    WornTurn& turn = turns->sensors[static_cast<std::size_t>(s)];
    const Eigen::Quaterniond best(BestRotation(found(Eigen::seqN(3 * s, 3), moving), wanted(Eigen::seqN(3 * s, 3), moving)));
    // Swing and twist: what of the turn is about the vertical, and what across it.
    const Vector3d up = worn.up.col(s);
    const Eigen::Quaterniond yaw(Eigen::AngleAxisd(2 * std::atan2(best.vec().dot(up), best.w()), up));
    const Eigen::Quaterniond tilt = best * yaw.conjugate();
    turn.told_from_worn = (Part(tilt, 1 - TiltTrust(worn.spread_rad[s])) * yaw * turn.told_from_worn).normalized();
    delays[s] = DelayOf(wanted.middleRows<3>(3 * s).colwise().norm(), found.middleRows<3>(3 * s).colwise().norm(), rate_hz) + turn.delay_s;
  }
  // All readings may come late alike: that shifts the clip, and no sensor against another.
  const double usual_s = Median({delays.begin(), delays.end()});
  for (Index s = 0; s < delays.size(); ++s) {
    const double delay_s = delays[s] - usual_s;
    turns->sensors[static_cast<std::size_t>(s)].delay_s = std::abs(delay_s) < kLeastDelay_s ? 0 : delay_s;
  }
}

Eigen::MatrixXd AlignedReadings(const Eigen::MatrixXd& readings, double rate_hz, const SensorTurns& turns) {
  if (readings.rows() != 3 * static_cast<Index>(turns.sensors.size())) throw std::invalid_argument("AlignedReadings: readings of other sensors");
  Eigen::MatrixXd aligned(readings.rows(), readings.cols());
  for (std::size_t s = 0; s < turns.sensors.size(); ++s) {
    const auto row = 3 * static_cast<Index>(s);
    const Eigen::Matrix3Xd turned = turns.sensors[s].told_from_worn.toRotationMatrix() * readings.middleRows<3>(row);
    aligned.middleRows<3>(row) = turns.sensors[s].delay_s == 0 ? turned : Shifted(turned, turns.sensors[s].delay_s * rate_hz);
  }
  return aligned;
}

}  // namespace morphograph
