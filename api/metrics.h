#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <tuple>

namespace morphograph {

/// Counters of one process, told as Prometheus text (exposition format 0.0.4). Safe from any thread.
class Metrics {
 public:
  /// One answered request. `route` is the pattern, never the path, so that strangers cannot grow the table.
  void CountRequest(std::string_view method, std::string_view route, int status, double seconds);
  void CountClip(int frames, double seconds);

  std::atomic<int> connections{0};
  std::atomic<int> queued{0};   // requests that wait for a worker or are worked on
  std::atomic<std::uint64_t> refused{0};  // answered 503 because of load
  std::atomic<int> models{0};
  std::atomic<int> jobs_waiting{0};
  std::atomic<int> jobs_running{0};

  std::string PrometheusText() const;

 private:
  static constexpr std::array<double, 12> kBounds_s = {0.001, 0.0025, 0.005, 0.01, 0.025, 0.05,
                                                       0.1,   0.25,   0.5,   1.0,  2.5,   10.0};
  struct Histogram {
    std::array<std::uint64_t, kBounds_s.size()> below{};
    std::uint64_t count = 0;
    double sum_s = 0;
    void Add(double seconds);
    void Append(std::string* text, std::string_view name, const std::string& labels) const;
  };

  mutable std::mutex mutex_;
  std::map<std::tuple<std::string, std::string, int>, std::uint64_t> requests_;  // method, route, status
  std::map<std::string, Histogram, std::less<>> latency_;                        // by route
  Histogram synthesis_;
  std::uint64_t clip_frames_ = 0;
};

}  // namespace morphograph
