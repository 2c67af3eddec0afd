#include "datasets/live_repair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "datasets/internal/sensor_track.h"
#include "datasets/internal/sensor_vitals.h"
#include "datasets/marker_units.h"

namespace morphograph {
namespace {

constexpr double kLongestSilence_s = 10;
constexpr double kKept_s = 3;                  // of the past
constexpr double kMeanOver_s = 5;
constexpr std::size_t kLeastWaiting = 10, kMostWaiting = 5'000, kMostKept = 10'000;  // samples
constexpr double kSpikeOfMean = 12, kLeastSpike_m_s2 = 40, kLeastMarkerSpike_m = 0.1;
constexpr double kMoving_m_s2 = 0.5;
constexpr double kShortestStep_s = 1e-4;
constexpr int kLateInARow = 30;           // samples: then it is the clock that was set back
constexpr int kRestartsUnsettled = 3;     // at the beginning
constexpr double kStall_s = 0.25;         // a silence of all is no sensor's own
constexpr double kLengthsAfter_s = 3;     // units are doubted
constexpr int kGapsTold = 5, kDeathsTold = 10;  // a sensor
constexpr int kJudgeEvery = 32;           // samples: whether there is gravity

std::string Sentence(const char* format, double a, double b = 0) {
  char text[120];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

}  // namespace

class LiveRepair::Stream {
 public:
  Stream(std::vector<std::string> names, const LiveRepairOptions& options)
      : options_(options), markers_(options.kind == ReadingsKind::kMarkers), names_(std::move(names)), sensors_(names_.size()) {}

  std::vector<Eigen::VectorXd> Push(double time_s, const Eigen::VectorXd& values) {
    if (values.size() != 3 * static_cast<Eigen::Index>(sensors_.size())) throw std::invalid_argument("LiveRepair: expected 3 values a sensor");
    if (!std::isfinite(time_s)) throw std::invalid_argument("LiveRepair: the time must be a number");
    std::vector<Eigen::VectorXd> due;
    if (any_ && time_s <= last_s_) {
      ++late_samples;
      if (++late_in_a_row_ < kLateInARow) return due;
      if (settled_) due = Due(last_s_);
      Restart(Sentence("the clock was set back from %.2f s to %.2f s", last_s_, time_s));
    }
    late_in_a_row_ = 0;
    if (any_ && time_s - last_s_ > kLongestSilence_s) {
      if (!ever_settled_ && ++restarts_unsettled_ >= kRestartsUnsettled) RefuseSteps(time_s - last_s_);
      if (settled_) due = Due(last_s_);
      Restart(Sentence("nothing came for %.0f s", time_s - last_s_));
    }
    if (!any_) first_s_ = time_s;
    if (any_) clock_s_ += std::min(time_s - last_s_, kStall_s);
    any_ = true;
    last_s_ = time_s;
    if (!settled_) {
      waiting_times_.push_back(time_s);
      waiting_.push_back(values);
      if (waiting_.size() < kLeastWaiting || (time_s - first_s_ < options_.settle_s && waiting_.size() < kMostWaiting)) return due;
      Settle();
    } else {
      Add(time_s, values);
    }
    for (Eigen::VectorXd& result : Due(time_s - Delay())) due.push_back(std::move(result));
    TellDead();
    if (!told_lengths_ && last_s_ - first_s_ > kLengthsAfter_s) TellLengths();
    Forget();
    return due;
  }

  std::vector<Eigen::VectorXd> Finish() {
    if (any_ && !settled_) Settle();
    std::vector<Eigen::VectorXd> due;
    if (any_) due = Due(last_s_);
    TellDead();
    if (settled_ && !told_lengths_) TellLengths();
    for (std::size_t s = 0; s < sensors_.size(); ++s) TellCounts(s);
    if (late_samples > 0) notes.push_back(Sentence("%.0f samples came after later ones and were passed over", static_cast<double>(late_samples)));
    return due;
  }

  double Delay() const {
    if (!settled_) return 0;
    // Two samples to judge a spike, one to bridge to, and what the average reaches ahead.
    return options_.longest_bridge_s + 3 * step_s_ + (Averages() ? 1 / options_.rate_hz : 0);
  }

  std::vector<int> Dead() const {
    if (!settled_) return dead_before_;  // what was due when the clock started anew is of them
    std::vector<int> dead;
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      if (CauseOfDeath(s)) dead.push_back(static_cast<int>(s));
    }
    return dead;
  }

  std::vector<std::string> notes;
  std::int64_t late_samples = 0, wild_samples = 0;

 private:
  struct Sensor {
    SensorTrack track;  // the last seconds
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double heard = 0;        // samples so far
    double mean_height = 0;  // of samples above the line between their neighbours
    double last_heard_s = -std::numeric_limits<double>::infinity();
    double last_heard_clock_s = 0;  // without the time in which nobody spoke
    double last_change_s = 0;
    bool has_gravity = true, told_dead = false;
    std::int64_t wild = 0;
    int gaps = 0, deaths = 0;
    std::array<double, 6> extremes = {};  // greatest of each axis, then of its opposite
    std::array<int, 6> at_extreme = {};   // samples that say exactly so
  };

  bool Averages() const { return !markers_ && 1 / step_s_ > 1.05 * options_.rate_hz; }

  [[noreturn]] static void RefuseSteps(double step_s) {
    throw std::invalid_argument(Sentence("the samples are %.4g s apart; at least 4 a second are needed (times are in seconds)", step_s));
  }

  void Restart(const std::string& why) {
    if (++restarts_ <= kDeathsTold) notes.push_back(why + "; the clock was started anew: frames go on being counted from the last one");
    dead_before_ = Dead();
    settled_ = any_ = false;
    late_in_a_row_ = 0;
    waiting_.clear();
    waiting_times_.clear();
    for (Sensor& sensor : sensors_) {  // what is only counted is told at the end
      Sensor anew;
      anew.wild = sensor.wild;
      anew.extremes = sensor.extremes;
      anew.at_extreme = sensor.at_extreme;
      anew.gaps = sensor.gaps;
      anew.deaths = sensor.deaths;
      anew.told_dead = sensor.told_dead;
      sensor = std::move(anew);
    }
    results_ = 0;
  }

  // Null for a sensor that is of use at this moment.
  const char* CauseOfDeath(std::size_t s) const {
    const Sensor& sensor = sensors_[s];
    if (!settled_) return nullptr;
    if (sensor.heard == 0) return "says nothing";
    if (!sensor.has_gravity) return "shows no gravity, or in another unit than the others";
    if (clock_s_ - sensor.last_heard_clock_s > options_.dead_after_s) return "has gone silent";
    if (!markers_ && last_s_ - sensor.last_change_s > options_.dead_after_s && OtherMoves(s)) return "says the same all the time while others move";
    return nullptr;
  }

  void TellDead() {
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      Sensor& sensor = sensors_[s];
      const char* cause = CauseOfDeath(s);
      if ((cause != nullptr) == sensor.told_dead) continue;
      sensor.told_dead = cause != nullptr;
      if (++sensor.deaths > 2 * kDeathsTold) continue;
      notes.push_back("'" + names_[s] + "' " + (cause ? std::string(cause) + Sentence("; it is left out from %.2f s on", last_s_) : Sentence("is of use again from %.2f s on", last_s_)));
    }
  }

  void TellCounts(std::size_t s) {
    const Sensor& sensor = sensors_[s];
    if (sensor.gaps > kGapsTold) notes.push_back("'" + names_[s] + Sentence("' was silent in %.0f more places", sensor.gaps - kGapsTold));
    if (sensor.wild > 0) notes.push_back("'" + names_[s] + Sentence("': %.0f wild samples were replaced", static_cast<double>(sensor.wild)));
    for (std::size_t side = 0; side < sensor.extremes.size(); ++side) {
      if (markers_ || sensor.extremes[side] < kLeastPlateau_m_s2 || sensor.at_extreme[side] < kLeastPlateauSamples) continue;
      notes.push_back("'" + names_[s] + Sentence("' is clipped at %.1f m/s^2; what was beyond is not known", sensor.extremes[side]));
      break;
    }
  }

  void Settle() {
    Eigen::MatrixXd values(3 * static_cast<Eigen::Index>(sensors_.size()), static_cast<Eigen::Index>(waiting_.size()));
    for (std::size_t i = 0; i < waiting_.size(); ++i) values.col(static_cast<Eigen::Index>(i)) = waiting_[i];
    std::vector<SensorTrack> tracks;
    for (Eigen::Index s = 0; s < values.rows() / 3; ++s) tracks.emplace_back(waiting_times_, values.middleRows<3>(3 * s));
    if (markers_) {
      Readings readings;
      readings.names.resize(sensors_.size());
      readings.times_s = waiting_times_;
      readings.values = values;
      unit_ = MetresPerMarkerUnit(readings);
    } else {
      unit_ = AccelerationUnit(tracks);
      for (std::size_t s = 0; s < tracks.size(); ++s) sensors_[s].has_gravity = tracks[s].empty() || IsLikeGravity(unit_ * tracks[s].MedianNorm());
    }
    if (unit_ == 0.01) notes.emplace_back("the markers are in centimetres; scaled to metres");
    if (unit_ == 0.001) notes.emplace_back("the markers are in millimetres; scaled to metres");
    if (unit_ == kGravityOfUnits_m_s2) notes.emplace_back("the readings are in g, not m/s^2; scaled by 9.81");
    if (unit_ == kGravityOfUnits_m_s2 / 1000) notes.emplace_back("the readings are in mg, not m/s^2; scaled by 0.00981");
    step_s_ = std::numeric_limits<double>::infinity();
    for (const SensorTrack& track : tracks) {
      if (track.step_s > 0) step_s_ = std::min(step_s_, track.step_s);
    }
    if (!std::isfinite(step_s_)) step_s_ = 1 / options_.rate_hz;
    if (step_s_ > 1.01 * kLongestStep_s) RefuseSteps(step_s_);
    if (step_s_ < kShortestStep_s) throw std::invalid_argument(Sentence("the samples are %.4g s apart; times are in seconds", step_s_));
    ever_settled_ = true;
    for (std::size_t s = 0; s < tracks.size(); ++s) sensors_[s].track.step_s = tracks[s].step_s > 0 ? tracks[s].step_s : step_s_;
    settled_ = true;
    for (std::size_t i = 0; i < waiting_.size(); ++i) Add(waiting_times_[i], waiting_[i]);
    waiting_.clear();
    waiting_times_.clear();
  }

  void Add(double time_s, const Eigen::VectorXd& values) {
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      Sensor& sensor = sensors_[s];
      const Eigen::Vector3d value = unit_ * values.segment<3>(3 * static_cast<Eigen::Index>(s));
      if (!value.allFinite()) continue;
      if (value.cwiseAbs().maxCoeff() > (markers_ ? kFarthest_m : kWidestRange_m_s2)) {
        ++wild_samples, ++sensor.wild;
        continue;
      }
      // A gap is told when it ends, but for a sensor that was told dead.
      if (sensor.heard > 0 && !sensor.told_dead && time_s - sensor.last_heard_s - sensor.track.step_s > options_.told_gap_s) {
        if (++sensor.gaps <= kGapsTold)
          notes.push_back("'" + names_[s] + Sentence("' was silent from %.2f s to %.2f s; ", sensor.last_heard_s, time_s) + (markers_ ? "held" : "filled with its mean"));
      }
      if (sensor.track.empty() || value != sensor.track.values.back()) sensor.last_change_s = time_s;
      sensor.last_heard_s = time_s;
      sensor.last_heard_clock_s = clock_s_;
      sensor.track.times_s.push_back(time_s);
      sensor.track.values.push_back(value);
      sensor.heard += 1;
      JudgeSpike(&sensor);
      if (!markers_ && static_cast<std::int64_t>(sensor.heard) % kJudgeEvery == 0) sensor.has_gravity = IsLikeGravity(sensor.track.MedianNorm());
      const double weight = std::max(1 / sensor.heard, sensor.track.step_s / kMeanOver_s);
      sensor.mean += weight * (value - sensor.mean);
    }
  }

  // Judges the last sample but one, now that both of its neighbours are known.
  void JudgeSpike(Sensor* sensor) {
    SensorTrack& track = sensor->track;
    const std::size_t samples = track.values.size();
    if (samples < 3 || track.times_s[samples - 1] - track.times_s[samples - 3] > 8 * track.step_s) return;
    const SpikeMeasure measure = MeasureSpike(track, samples - 2, 1);
    const double threshold = std::max(markers_ ? kLeastMarkerSpike_m : kLeastSpike_m_s2, kSpikeOfMean * sensor->mean_height);
    if (IsSpike(measure, 1, threshold)) {
      ++wild_samples, ++sensor->wild;
      track.times_s.erase(track.times_s.end() - 2);
      track.values.erase(track.values.end() - 2);
      return;
    }
    for (std::size_t side = 0; side < sensor->extremes.size(); ++side) {
      const double value = (side < 3 ? 1 : -1) * track.values[samples - 2][static_cast<Eigen::Index>(side % 3)];
      if (value > sensor->extremes[side] * (1 + 1e-6)) {
        sensor->extremes[side] = value;
        sensor->at_extreme[side] = 1;
      } else if (value > sensor->extremes[side] * (1 - 1e-6)) {
        ++sensor->at_extreme[side];
      }
    }
    sensor->mean_height += std::max(1 / sensor->heard, track.step_s / kMeanOver_s) * (measure.height - sensor->mean_height);
  }

  // In the time after which a sensor is taken for dead.
  bool OtherMoves(std::size_t sensor) const {
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      if (s == sensor) continue;
      const SensorTrack& track = sensors_[s].track;
      double n = 0, sum = 0, squares = 0;
      for (std::size_t i = track.values.size(); i-- > 0 && track.times_s[i] >= last_s_ - options_.dead_after_s;) {
        const double norm = track.values[i].norm();
        n += 1, sum += norm, squares += norm * norm;
      }
      if (n > 2 && squares / n - (sum / n) * (sum / n) > kMoving_m_s2 * kMoving_m_s2) return true;
    }
    return false;
  }

  void TellLengths() {
    told_lengths_ = true;
    if (markers_ || unit_ != 1) return;
    double least = std::numeric_limits<double>::infinity();
    for (const Sensor& sensor : sensors_) {
      if (sensor.heard > 0 && sensor.has_gravity) least = std::min(least, sensor.mean.norm());
    }
    if (std::isfinite(least) && least > kMostMean_m_s2) notes.push_back(OddLengths(least));
  }

  void Forget() {
    for (Sensor& sensor : sensors_) {
      std::vector<double>& times = sensor.track.times_s;
      // One is kept from which a silent sensor is continued. Rarely, so that it costs little a sample.
      if (times.size() < 64 || (times[times.size() / 2] > last_s_ - kKept_s && times.size() < kMostKept)) continue;
      const auto old = static_cast<std::ptrdiff_t>(times.size() / 2);
      times.erase(times.begin(), times.begin() + old);
      sensor.track.values.erase(sensor.track.values.begin(), sensor.track.values.begin() + old);
    }
  }

  Eigen::VectorXd At(double time_s) const {
    Eigen::VectorXd values = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(sensors_.size()));
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      if (sensors_[s].track.empty()) continue;
      GapFilling filling;
      filling.longest_bridge_s = options_.longest_bridge_s;
      if (markers_) filling.damping_s = std::numeric_limits<double>::infinity();
      filling.towards = sensors_[s].mean;
      values.segment<3>(3 * static_cast<Eigen::Index>(s)) = ValueAt(sensors_[s].track, time_s, filling);
    }
    return values;
  }

  Eigen::VectorXd ResultAt(double time_s) const {
    if (!Averages()) return At(time_s);
    // The same triangle as RepairStream()'s, over the sensors' own steps counted from the first sample.
    const double ratio = 1 / (step_s_ * options_.rate_hz), centre = (time_s - first_s_) / step_s_;
    const auto from = static_cast<std::int64_t>(std::max(0.0, std::ceil(centre - ratio))), to = static_cast<std::int64_t>(std::floor(centre + ratio));
    Eigen::MatrixXd values(3 * static_cast<Eigen::Index>(sensors_.size()), to - from + 1);
    for (std::int64_t i = from; i <= to; ++i) values.col(i - from) = At(first_s_ + static_cast<double>(i) * step_s_);
    return TriangleMean(values, centre - static_cast<double>(from), ratio);
  }

  std::vector<Eigen::VectorXd> Due(double until_s) {
    std::vector<Eigen::VectorXd> due;
    for (;; ++results_) {
      const double time_s = first_s_ + static_cast<double>(results_) / options_.rate_hz;
      if (time_s > until_s + 1e-9) return due;
      due.push_back(ResultAt(time_s));
    }
  }

  LiveRepairOptions options_;
  bool markers_;
  std::vector<std::string> names_;
  std::vector<Sensor> sensors_;
  std::vector<double> waiting_times_;  // before it has settled
  std::vector<Eigen::VectorXd> waiting_;
  bool settled_ = false, any_ = false, ever_settled_ = false, told_lengths_ = false;
  int late_in_a_row_ = 0, restarts_ = 0, restarts_unsettled_ = 0;
  double clock_s_ = 0;
  std::vector<int> dead_before_;
  double unit_ = 1, step_s_ = 0, first_s_ = 0, last_s_ = 0;
  std::int64_t results_ = 0;
};

LiveRepair::LiveRepair(std::vector<std::string> sensors, const LiveRepairOptions& options) {
  if (sensors.empty() || sensors.size() > 500) throw std::invalid_argument("LiveRepair: 1 to 500 sensors");
  if (!(options.rate_hz >= 1 && options.rate_hz <= 1000)) throw std::invalid_argument("LiveRepair: rate must be within [1, 1000] Hz");
  if (!(options.longest_bridge_s >= 0 && options.longest_bridge_s <= 1)) throw std::invalid_argument("LiveRepair: bridge must be within [0, 1] s");
  if (!(options.settle_s >= 0 && options.settle_s <= 10)) throw std::invalid_argument("LiveRepair: settle must be within [0, 10] s");
  if (!(options.dead_after_s > 0 && options.told_gap_s >= 0)) throw std::invalid_argument("LiveRepair: dead_after must be positive, told_gap not negative");
  stream_ = std::make_unique<Stream>(std::move(sensors), options);
}
LiveRepair::~LiveRepair() = default;

std::vector<Eigen::VectorXd> LiveRepair::Push(double time_s, const Eigen::VectorXd& values) { return stream_->Push(time_s, values); }
std::vector<Eigen::VectorXd> LiveRepair::Finish() { return stream_->Finish(); }
double LiveRepair::delay_s() const { return stream_->Delay(); }
std::vector<int> LiveRepair::dead_sensors() const { return stream_->Dead(); }
const std::vector<std::string>& LiveRepair::notes() const { return stream_->notes; }
std::int64_t LiveRepair::late_samples() const { return stream_->late_samples; }
std::int64_t LiveRepair::wild_samples() const { return stream_->wild_samples; }

}  // namespace morphograph
