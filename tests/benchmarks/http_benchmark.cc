// Latency and throughput of POST /v1/clips over the loopback, real sockets, 10 s clips.
//
//   build/release/http_benchmark [--model FILE] [--seconds 5] [--threads N]
//
// Server and clients share the machine. Without --model a small model of synthetic walks is learned first. Times are
// wall clock, from the first byte sent to the last byte received on a kept connection.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <thread>

#include "graph/model_io.h"
#include "tests/support/raw_http.h"
#include "tests/support/small_model.h"
#include "tests/support/test_service.h"

namespace morphograph {
namespace {

using Clock = std::chrono::steady_clock;

struct Series {
  std::vector<double> ms;
  std::size_t bytes = 0;
  int failures = 0;
};

Series AskFor(int port, double seconds, std::uint64_t first_seed, const std::string& accept) {
  Series series;
  testing::RawConnection connection(port);
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  for (std::uint64_t seed = first_seed; Clock::now() < end; ++seed) {
    const std::string body = R"({"model":"walk","duration":10,"seed":)" + std::to_string(seed) + "}";
    const auto start = Clock::now();
    connection.Send("POST /v1/clips HTTP/1.1\r\nHost: b\r\nAccept: " + accept + "\r\nContent-Type: application/json\r\nContent-Length: " +
                    std::to_string(body.size()) + "\r\n\r\n" + body);
    const auto response = connection.Read();
    if (!response || response->status != 200) {
      ++series.failures;
      break;
    }
    series.ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
    series.bytes += response->body.size();
  }
  return series;
}

void Measure(int port, int connections, double seconds, const std::string& accept) {
  std::vector<Series> all(static_cast<std::size_t>(connections));
  std::vector<std::thread> clients;
  const auto start = Clock::now();
  for (int i = 0; i < connections; ++i) {
    clients.emplace_back([&, i] {
      all[static_cast<std::size_t>(i)] = AskFor(port, seconds, 1 + 1'000'000u * static_cast<unsigned>(i), accept);
    });
  }
  for (std::thread& client : clients) client.join();
  const double elapsed = std::chrono::duration<double>(Clock::now() - start).count();
  Series sum;
  for (const Series& series : all) {
    sum.ms.insert(sum.ms.end(), series.ms.begin(), series.ms.end());
    sum.bytes += series.bytes;
    sum.failures += series.failures;
  }
  if (sum.ms.empty()) {
    std::printf("%2d connections, %s: no answers\n", connections, accept.c_str());
    return;
  }
  std::sort(sum.ms.begin(), sum.ms.end());
  const auto quantile = [&](double q) { return sum.ms[static_cast<std::size_t>(q * static_cast<double>(sum.ms.size() - 1))]; };
  std::printf("%2d connections, %-17s: %7.1f clips/s, median %6.2f ms, p95 %6.2f ms, p99 %6.2f ms, %4zu kB a clip, %d failed\n",
              connections, accept.c_str(), static_cast<double>(sum.ms.size()) / elapsed, quantile(0.5), quantile(0.95),
              quantile(0.99), sum.bytes / sum.ms.size() / 1000, sum.failures);
}

}  // namespace
}  // namespace morphograph

int main(int argc, char** argv) {
  using namespace morphograph;
  double seconds = 5;
  ServerOptions options;
  std::shared_ptr<const MotionGraph> model;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--model") == 0) model = LoadModel(argv[i + 1]);
    if (std::strcmp(argv[i], "--seconds") == 0) seconds = std::atof(argv[i + 1]);
    if (std::strcmp(argv[i], "--threads") == 0) options.threads = std::atoi(argv[i + 1]);
  }
  if (options.threads == 0) options.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  if (!model) model = testing::SmallModel();
  testing::TestService app(options);
  app.service.models.Add("walk", model);
  app.Start();
  std::printf("%d worker threads\n", options.threads);
  AskFor(app.port, 0.2, 99, "text/plain");  // warm
  for (const char* accept : {"text/plain", "application/json"})
    for (const int connections : {1, 8}) Measure(app.port, connections, seconds, accept);
}
