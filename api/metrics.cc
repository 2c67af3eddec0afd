#include "api/metrics.h"

#include <charconv>

namespace morphograph {
namespace {

std::string Shortest(double value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

void Describe(std::string* text, std::string_view name, std::string_view type, std::string_view help) {
  *text += "# HELP ";
  (*text += name) += ' ';
  (*text += help) += "\n# TYPE ";
  (*text += name) += ' ';
  (*text += type) += '\n';
}

void Sample(std::string* text, std::string_view name, const std::string& labels, const std::string& value) {
  *text += name;
  if (!labels.empty()) *text += '{' + labels + '}';
  *text += ' ' + value + '\n';
}

}  // namespace

void Metrics::Histogram::Add(double seconds) {
  ++count;
  sum_s += seconds;
  for (std::size_t i = 0; i < kBounds_s.size(); ++i)
    if (seconds <= kBounds_s[i]) ++below[i];
}

void Metrics::Histogram::Append(std::string* text, std::string_view name, const std::string& labels) const {
  const std::string stem(name);
  const std::string prefix = labels.empty() ? "" : labels + ",";
  for (std::size_t i = 0; i < kBounds_s.size(); ++i)
    Sample(text, stem + "_bucket", prefix + "le=\"" + Shortest(kBounds_s[i]) + "\"", std::to_string(below[i]));
  Sample(text, stem + "_bucket", prefix + "le=\"+Inf\"", std::to_string(count));
  Sample(text, stem + "_sum", labels, Shortest(sum_s));
  Sample(text, stem + "_count", labels, std::to_string(count));
}

void Metrics::CountRequest(std::string_view method, std::string_view route, int status, double seconds) {
  const std::lock_guard lock(mutex_);
  ++requests_[{std::string(method), std::string(route), status}];
  latency_[std::string(route)].Add(seconds);
}

void Metrics::CountClip(int frames, double seconds) {
  const std::lock_guard lock(mutex_);
  clip_frames_ += static_cast<std::uint64_t>(frames);
  synthesis_.Add(seconds);
}

std::string Metrics::PrometheusText() const {
  std::string text;
  const auto single = [&](std::string_view name, std::string_view type, std::string_view help, std::uint64_t value) {
    Describe(&text, name, type, help);
    Sample(&text, name, "", std::to_string(value));
  };
  single("morphograph_connections", "gauge", "Open connections.", static_cast<std::uint64_t>(connections.load()));
  single("morphograph_queue_depth", "gauge", "Requests waiting for a worker or worked on.",
         static_cast<std::uint64_t>(queued.load()));
  single("morphograph_refused_total", "counter", "Requests and connections refused because of load.", refused.load());
  single("morphograph_models", "gauge", "Models served.", static_cast<std::uint64_t>(models.load()));
  Describe(&text, "morphograph_jobs", "gauge", "Training jobs that are not finished.");
  Sample(&text, "morphograph_jobs", "state=\"queued\"", std::to_string(jobs_waiting.load()));
  Sample(&text, "morphograph_jobs", "state=\"running\"", std::to_string(jobs_running.load()));

  const std::lock_guard lock(mutex_);
  single("morphograph_clip_frames_total", "counter", "Frames synthesised.", clip_frames_);
  Describe(&text, "morphograph_clip_seconds", "histogram", "Time to make one clip, in seconds.");
  synthesis_.Append(&text, "morphograph_clip_seconds", "");
  Describe(&text, "morphograph_http_requests_total", "counter", "Requests answered.");
  for (const auto& [key, count] : requests_) {
    const auto& [method, route, status] = key;
    Sample(&text, "morphograph_http_requests_total",
           "method=\"" + method + "\",route=\"" + route + "\",status=\"" + std::to_string(status) + "\"",
           std::to_string(count));
  }
  Describe(&text, "morphograph_http_request_seconds", "histogram", "Time from request to answer, in seconds.");
  for (const auto& [route, histogram] : latency_)
    histogram.Append(&text, "morphograph_http_request_seconds", "route=\"" + route + "\"");
  return text;
}

}  // namespace morphograph
