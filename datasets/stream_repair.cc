#include "datasets/stream_repair.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "datasets/errors.h"
#include "datasets/internal/sensor_track.h"
#include "datasets/internal/sensor_vitals.h"
#include "datasets/low_pass.h"
#include "datasets/marker_units.h"
#include "datasets/quantile.h"

namespace morphograph {
namespace {

constexpr double kMostSpan_s = 86400;
constexpr double kMostValues = 50e6;
constexpr double kLeastPresent = 0.02;       // of the samples due, all sensors together
constexpr std::size_t kGapsTold = 5;         // a sensor

constexpr double kSpikeQuantile = 0.9, kSpikeFactor = 8;
constexpr double kLeastSpike_m_s2 = 15, kLeastSpike_m = 0.05;
constexpr double kUsualWidths = 2;

std::string Text(const char* format, double a, double b = 0, double c = 0) {
  char text[160];
  std::snprintf(text, sizeof text, format, a, b, c);
  return text;
}

std::string JoinedNames(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

class StreamRepair {
 public:
  StreamRepair(const Readings& readings, const StreamRepairOptions& options, const std::string& source)
      : in_(readings), options_(options), source_(source), markers_(options.kind == ReadingsKind::kMarkers) {}

  RepairedReadings Run() {
    CheckInput();
    MakeTracks();
    FindUnits();
    FindDead();
    for (const int s : living_) CutStuckRuns(s);
    for (const int s : living_) RemoveSpikes(s);
    if (!markers_) {
      for (const int s : living_) FindClipping(s);
    }
    for (const int s : living_) TellGaps(s);
    Summarise();
    Sample();
    return std::move(out_);
  }

 private:
  void CheckInput() {
    const auto samples = static_cast<std::size_t>(in_.sample_count());
    if (in_.values.cols() != in_.sample_count() || in_.values.rows() != 3 * in_.sensor_count()) {
      throw std::invalid_argument("RepairStream: values must be (3 * names x times)");
    }
    if (options_.rate_hz != 0 && !(options_.rate_hz >= 1 && options_.rate_hz <= 1000)) throw std::invalid_argument("RepairStream: rate must be 0 or within [1, 1000] Hz");
    if (!(options_.cutoff_hz >= 0 && options_.longest_bridge_s >= 0 && options_.told_gap_s >= 0)) throw std::invalid_argument("RepairStream: options must not be negative");
    if (in_.sensor_count() == 0) throw DatasetError(source_, "there is no sensor");
    if (samples < 3) throw DatasetError(source_, "fewer than 3 samples");
    for (std::size_t i = 0; i + 1 < samples; ++i) {
      if (!(in_.times_s[i] < in_.times_s[i + 1])) throw std::invalid_argument("RepairStream: times must rise");
    }
    span_s_ = in_.times_s.back() - in_.times_s.front();
    if (!(span_s_ <= kMostSpan_s)) throw DatasetError(source_, Text("the time stamps span %.0f s, more than a day; are they in seconds?", span_s_));
  }

  void MakeTracks() {
    for (int s = 0; s < in_.sensor_count(); ++s) tracks_.emplace_back(in_.times_s, in_.values.middleRows<3>(3 * s));
  }

  void FindUnits() {
    if (markers_) {
      out_.unit_factor = MetresPerMarkerUnit(in_);
      if (out_.unit_factor == 0.01) out_.notes.emplace_back("the markers are in centimetres, as their distances show; scaled to metres");
      if (out_.unit_factor == 0.001) out_.notes.emplace_back("the markers are in millimetres, as their distances show; scaled to metres");
    } else {
      out_.unit_factor = AccelerationUnit(tracks_);
      if (out_.unit_factor == kGravityOfUnits_m_s2) out_.notes.emplace_back("the readings are in g, not m/s^2: at rest they are 1; scaled by 9.81");
      if (const double least = LeastMean(tracks_); out_.unit_factor == 1 && least > kMostMean_m_s2) out_.notes.push_back(OddLengths(least));
      if (out_.unit_factor == kGravityOfUnits_m_s2 / 1000) out_.notes.emplace_back("the readings are in mg, not m/s^2: at rest they are 1000; scaled by 0.00981");
    }
    for (SensorTrack& track : tracks_) {
      for (Eigen::Vector3d& value : track.values) value *= out_.unit_factor;
    }
  }

  void FindDead() {
    const std::vector<std::string> causes = CausesOfDeath(tracks_, markers_, span_s_);
    std::vector<std::string> sentences;
    for (int s = 0; s < in_.sensor_count(); ++s) {
      const std::string& cause = causes[static_cast<std::size_t>(s)];
      if (cause.empty()) {
        living_.push_back(s);
      } else {
        out_.dead_sensors.push_back(s);
        sentences.push_back("'" + in_.names[static_cast<std::size_t>(s)] + "' " + cause);
      }
    }
    if (living_.empty()) {
      const std::string all = JoinedNames(sentences);
      const bool no_gravity = all.find("gravity") != std::string::npos;
      throw DatasetError(source_, std::string("no ") + (markers_ ? "marker" : "sensor") + " is alive: " + all +
                                      (no_gravity ? "; accelerations with gravity are needed, near 9.81 m/s^2 at rest" : ""));
    }
    for (const std::string& sentence : sentences) out_.notes.push_back(sentence + "; it is left out");
    double fastest_s = std::numeric_limits<double>::infinity();
    for (const int s : living_) fastest_s = std::min(fastest_s, Track(s).step_s);
    native_hz_ = 1 / fastest_s;
    if (fastest_s > 1.01 * kLongestStep_s) throw DatasetError(source_, Text("the samples are %.4g s apart; at least 4 a second are needed (times are in seconds)", fastest_s));
    if (span_s_ * native_hz_ * 3 * in_.sensor_count() > kMostValues) throw DatasetError(source_, Text("the time stamps span %.0f s at %.0f samples a second: too many", span_s_, native_hz_));
  }

  SensorTrack& Track(int sensor) { return tracks_[static_cast<std::size_t>(sensor)]; }
  const std::string& Name(int sensor) const { return in_.names[static_cast<std::size_t>(sensor)]; }

  void Erase(int sensor, const std::vector<char>& gone) {
    SensorTrack& track = Track(sensor);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < track.values.size(); ++i) {
      if (gone[i]) continue;
      track.times_s[kept] = track.times_s[i];
      track.values[kept++] = track.values[i];
    }
    track.times_s.resize(kept);
    track.values.resize(kept);
  }

  void CutStuckRuns(int sensor) {
    if (markers_) return;
    const SensorTrack& track = Track(sensor);
    std::vector<char> gone(track.values.size(), 0);
    bool any = false;
    for (const auto& [first, last] : StuckRuns(track)) {
      if (!OthersMove(tracks_, living_, sensor, track.times_s[first], track.times_s[last])) continue;
      // The first of them may have been true.
      std::fill(gone.begin() + static_cast<std::ptrdiff_t>(first) + 1, gone.begin() + static_cast<std::ptrdiff_t>(last) + 1, 1);
      out_.notes.push_back("'" + Name(sensor) + Text("' says the same from %.2f s to %.2f s while others move; taken as lost", track.times_s[first], track.times_s[last]));
      any = true;
    }
    if (any) Erase(sensor, gone);
  }

  void RemoveSpikes(int sensor) {
    const SensorTrack& track = Track(sensor);
    const std::size_t samples = track.values.size();
    came_ += static_cast<double>(samples);
    std::vector<char> gone(samples, 0);
    int spikes = 0;
    const auto mark = [&](std::size_t i) {
      spikes += gone[i] ? 0 : 1;
      gone[i] = 1;
    };
    for (std::size_t i = 0; i < samples; ++i) {
      if (track.values[i].cwiseAbs().maxCoeff() > (markers_ ? kFarthest_m : kWidestRange_m_s2)) mark(i);
    }
    if (samples >= 5) {
      std::vector<double> heights;
      for (std::size_t i = 1; i + 1 < samples; ++i) heights.push_back(MeasureSpike(track, i, 1).height);
      const double threshold = std::max(markers_ ? kLeastSpike_m : kLeastSpike_m_s2, kSpikeFactor * Quantile(heights, kSpikeQuantile));
      for (std::size_t width = 1; width <= kUsualWidths; ++width) {
        for (std::size_t i = 1; i + width < samples; ++i) {
          if (gone[i - 1] || gone[i + width] || track.times_s[i + width] - track.times_s[i - 1] > 4 * static_cast<double>(width + 1) * track.step_s) continue;
          if (!IsSpike(MeasureSpike(track, i, width), width, threshold)) continue;
          for (std::size_t n = 0; n < width; ++n) mark(i + n);
        }
      }
    }
    if (spikes == 0) return;
    spikes_ += spikes;
    out_.notes.push_back("'" + Name(sensor) + Text("': %.0f wild samples of %.0f were replaced", spikes, static_cast<double>(samples)));
    Erase(sensor, gone);
    if (Track(sensor).values.size() < 2) throw DatasetError(source_, "'" + Name(sensor) + "' holds hardly anything but wild samples");
  }

  void FindClipping(int sensor) {
    const SensorTrack& track = Track(sensor);
    std::vector<char> clipped(track.values.size(), 0);
    double range = 0;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {1.0, -1.0}) {
        double top = 0;
        for (const Eigen::Vector3d& value : track.values) top = std::max(top, sign * value[axis]);
        if (top < kLeastPlateau_m_s2) continue;
        // One sample at the top is a peak; a plateau has two or more side by side, or, of short blows, the very same top again and again.
        const auto same = std::count_if(track.values.begin(), track.values.end(), [&](const Eigen::Vector3d& value) { return sign * value[axis] == top; });
        const auto at_top = [&](std::size_t i) { return sign * track.values[i][axis] > top * (1 - 1e-6); };
        std::vector<std::size_t> plateau;
        for (std::size_t i = 0; i < track.values.size(); ++i) {
          const bool beside = (i > 0 && at_top(i - 1)) || (i + 1 < track.values.size() && at_top(i + 1));
          if (at_top(i) && (beside || same >= kLeastPlateauSamples)) plateau.push_back(i);
        }
        if (static_cast<int>(plateau.size()) < kLeastPlateauSamples) continue;
        for (const std::size_t i : plateau) clipped[i] = 1;
        range = std::max(range, top);
      }
    }
    const auto count = static_cast<double>(std::count(clipped.begin(), clipped.end(), 1));
    if (count == 0) return;
    clipped_ += count;
    out_.notes.push_back("'" + Name(sensor) + Text("' is clipped at %.1f m/s^2 in %.1f %% of its samples; what was beyond is not known", range,
                                                   100 * count / static_cast<double>(track.values.size())));
  }

  void TellGaps(int sensor) {
    const SensorTrack& track = Track(sensor);
    const double step_s = track.step_s;
    due_ += span_s_ / step_s + 1;
    present_ += static_cast<double>(track.values.size());
    std::vector<std::pair<double, double>> gaps;
    const auto consider = [&](double from_s, double to_s, double silent_s) {
      if (silent_s < 0.5 * step_s) return;
      out_.longest_gap_s = std::max(out_.longest_gap_s, silent_s);
      if (silent_s > options_.told_gap_s) gaps.emplace_back(from_s, to_s);
    };
    consider(in_.times_s.front(), track.times_s.front(), track.times_s.front() - in_.times_s.front());
    for (std::size_t i = 0; i + 1 < track.times_s.size(); ++i) consider(track.times_s[i], track.times_s[i + 1], track.times_s[i + 1] - track.times_s[i] - step_s);
    consider(track.times_s.back(), in_.times_s.back(), in_.times_s.back() - track.times_s.back());
    for (std::size_t i = 0; i < std::min(gaps.size(), kGapsTold); ++i) {
      out_.notes.push_back("'" + Name(sensor) + Text("' is silent from %.2f s to %.2f s; ", gaps[i].first, gaps[i].second) + (markers_ ? "bridged straight, or held" : "filled with its mean"));
    }
    if (gaps.size() > kGapsTold) out_.notes.push_back("'" + Name(sensor) + Text("' is silent in %.0f more places", static_cast<double>(gaps.size() - kGapsTold)));
  }

  void Summarise() {
    out_.lost_share = std::max(0.0, 1 - present_ / due_);
    out_.spike_share = spikes_ / came_;
    out_.clipped_share = clipped_ / present_;
    if (present_ < kLeastPresent * due_) throw DatasetError(source_, Text("only %.2g %% of the samples are there", 100 * present_ / due_));
    if (out_.lost_share > 0.001) out_.notes.push_back(Text("%.1f %% of the samples never came or were wild; the longest gap is %.2f s", 100 * out_.lost_share, out_.longest_gap_s));
    std::vector<double> steps;
    for (const int s : living_) {
      const SensorTrack& track = Track(s);
      for (std::size_t i = 0; i + 1 < track.times_s.size(); ++i) {
        // A lost packet makes a step of whole ones; what is left over is the clock's.
        const double part = (track.times_s[i + 1] - track.times_s[i]) / track.step_s;
        steps.push_back(std::abs(part - std::max(1.0, std::round(part))));
      }
    }
    if (const double jitter = Quantile(std::move(steps), 0.9); jitter > 0.1) out_.notes.push_back(Text("steps of time are uneven by %.0f %% and more in a tenth of the samples", 100 * jitter));
  }

  GapFilling Filling(int sensor) {
    GapFilling filling;
    filling.longest_bridge_s = options_.longest_bridge_s;
    if (markers_) filling.damping_s = std::numeric_limits<double>::infinity();
    filling.towards = Track(sensor).Mean();
    return filling;
  }

  // Every living sensor at steady times from the first to the last.
  Eigen::MatrixXd AtRate(double rate_hz) {
    const auto count = static_cast<Eigen::Index>(std::floor(span_s_ * rate_hz * (1 + 1e-12) + 1e-6)) + 1;
    Eigen::MatrixXd values = Eigen::MatrixXd::Zero(in_.values.rows(), count);
    for (const int s : living_) {
      const GapFilling filling = Filling(s);
      for (Eigen::Index i = 0; i < count; ++i) values.col(i).segment<3>(3 * s) = ValueAt(Track(s), in_.times_s.front() + static_cast<double>(i) / rate_hz, filling);
    }
    return values;
  }

  void Sample() {
    const double wanted_hz = options_.rate_hz > 0 ? options_.rate_hz : native_hz_;
    const bool average = !markers_ && native_hz_ > 1.05 * wanted_hz;
    const bool direct = !average && options_.cutoff_hz == 0;
    Eigen::MatrixXd values = AtRate(direct ? wanted_hz : native_hz_);
    if (options_.cutoff_hz > 0) values = LowPass(values, native_hz_, options_.cutoff_hz);
    if (average) {
      values = TriangleAverage(values, native_hz_, wanted_hz);
    } else if (!direct) {
      values = Interpolated(values, wanted_hz);
    }
    out_.rate_hz = wanted_hz;
    out_.readings.names = in_.names;
    for (Eigen::Index i = 0; i < values.cols(); ++i) out_.readings.times_s.push_back(in_.times_s.front() + static_cast<double>(i) / wanted_hz);
    out_.readings.values = std::move(values);
  }

  // A second difference with step h is the acceleration averaged under a triangle of half width h.
  static Eigen::MatrixXd TriangleAverage(const Eigen::MatrixXd& values, double from_hz, double to_hz) {
    const double ratio = from_hz / to_hz;
    const auto count = static_cast<Eigen::Index>(std::floor(static_cast<double>(values.cols() - 1) / ratio + 1e-6)) + 1;
    Eigen::MatrixXd averaged(values.rows(), count);
    for (Eigen::Index i = 0; i < count; ++i) averaged.col(i) = TriangleMean(values, static_cast<double>(i) * ratio, ratio);
    return averaged;
  }

  Eigen::MatrixXd Interpolated(const Eigen::MatrixXd& values, double to_hz) {
    std::vector<double> times;
    for (Eigen::Index i = 0; i < values.cols(); ++i) times.push_back(in_.times_s.front() + static_cast<double>(i) / native_hz_);
    for (const int s : living_) tracks_[static_cast<std::size_t>(s)] = SensorTrack(times, values.middleRows<3>(3 * s));
    return AtRate(to_hz);
  }

  const Readings& in_;
  const StreamRepairOptions& options_;
  const std::string& source_;
  const bool markers_;
  double span_s_ = 0, native_hz_ = 0;
  double due_ = 0, present_ = 0, came_ = 0, spikes_ = 0, clipped_ = 0;
  std::vector<SensorTrack> tracks_;
  std::vector<int> living_;
  RepairedReadings out_;
};

}  // namespace

RepairedReadings RepairStream(const Readings& readings, const StreamRepairOptions& options, const std::string& source) {
  return StreamRepair(readings, options, source).Run();
}

}  // namespace morphograph
