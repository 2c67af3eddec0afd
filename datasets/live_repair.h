#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "datasets/readings_reader.h"

namespace morphograph {

struct LiveRepairOptions {
  ReadingsKind kind = ReadingsKind::kAccelerations;
  double rate_hz = 30;             // of the result, [1, 1000]
  double longest_bridge_s = 0.08;  // a longer gap is continued from its beginning towards the sensor's mean, without waiting for its end
  double settle_s = 0.5;           // looked at before the first result: units, the sensors' own rate
  double dead_after_s = 1;         // of silence, or of saying the same while others move
  double told_gap_s = 0.25;        // longer ones are told one by one
};

/// RepairStream() for a stream that is still running: a sample in, repaired samples out at a steady rate.
///
/// A result for time t comes with the first sample later than t by `delay_s()`, once `settle_s` have passed; it does not change afterwards. Units are decided then, dead sensors all along
/// (a sensor that speaks again lives again). What is found is told as it is found; what is counted, at the end. Spikes are judged against a running mean of how far samples stand out of their neighbours, instead of the whole stream's quantile. There is no low-pass.
class LiveRepair {
 public:
  /// @param sensors  names, for what is told. @throws std::invalid_argument for no sensors or options out of range.
  explicit LiveRepair(std::vector<std::string> sensors, const LiveRepairOptions& options = {});
  ~LiveRepair();

  /// @param values  (3 * sensors); what is lost is NaN.
  /// @return repaired samples that are now due, none or several; (3 * sensors), all finite, 0 for a sensor that never spoke.
  /// A time that does not come after the last is passed over and counted. After a silence of more than 10 s of all sensors the clock starts anew.
  /// @throws std::invalid_argument for another number of values, a time that is not finite, or samples so far apart that nothing can be made of them.
  std::vector<Eigen::VectorXd> Push(double time_s, const Eigen::VectorXd& values);
  /// What is still due at the end of the stream.
  std::vector<Eigen::VectorXd> Finish();

  /// How much later than its own time a result comes, at most, apart from waiting for the next sample: the gap that is bridged, a few samples, and half the average. 0 before it has settled.
  double delay_s() const;
  /// Sensors that are of no use at this moment, rising.
  std::vector<int> dead_sensors() const;
  /// What was found so far, one sentence each, in the order of time: units, sensors that die and live again, gaps; after Finish() also what was replaced, passed over or clipped.
  const std::vector<std::string>& notes() const;
  std::int64_t late_samples() const;
  std::int64_t wild_samples() const;

 private:
  class Stream;
  std::unique_ptr<Stream> stream_;
};

}  // namespace morphograph
