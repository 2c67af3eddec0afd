#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "api/metrics.h"
#include "api/router.h"

namespace morphograph {

/// Bounds of a server; whatever a client does, memory and time stay inside them.
struct ServerOptions {
  std::atomic<bool>* ready = nullptr;  // if given, true from Run() on, false from the moment that the server is told to stop
  std::string host = "127.0.0.1";
  int port = 8080;  // 0: any free one
  // Hosts whose pages may change something here, as browsers name them in Origin; empty: any. A page can make its own host name lead
  // to this machine's loopback, and is no stranger to the browser then.
  std::vector<std::string> page_hosts;
  int threads = 0;  // requests carried out at a time; 0: one a core
  int max_connections = 256;                       // beyond: 503
  int max_queued = 64;                             // requests waiting for their turn; beyond: 503
  std::size_t max_body_bytes = std::size_t{512} << 20;  // of all large bodies held at a time; beyond: 503
  std::chrono::seconds head_timeout{15};   // for the next request's line and headers, idle time included
  std::chrono::seconds body_timeout{20};   // plus one second for each MiB announced
  std::chrono::seconds write_timeout{60};
  std::chrono::seconds queue_timeout{10};  // a request that waited longer is answered 503
  std::chrono::seconds work_timeout{120};  // for a request that works for long, its turns waited for included
  std::chrono::seconds stop_timeout{10};   // for requests under way when the server is told to stop
};

/// HTTP/1.1 server on cpp-httplib, whose known holes are fenced in (see server.cc).
///
/// Every connection has a thread of its own while it is open, so that a slow client holds back nobody else; at most
/// `threads` of them carry out a request at a time. Refused before any body is read: chunked bodies (411) but where a
/// route answers them as they come (Route::live_type), bodies
/// above the route's limit (413), bodies where none is taken, repeated lengths, coded bodies, unknown routes.
class Server {
 public:
  /// @param router, metrics  must outlive the server.
  Server(const Router& router, Metrics* metrics, ServerOptions options);
  ~Server();

  /// Starts to listen. @return the port. @throws std::runtime_error naming host, port and the system's reason.
  int Bind();

  /// Serves until Stop(). Requests under way are finished, then it returns.
  void Run();

  /// Asks Run() to return. From any thread, also before Run().
  void Stop();

  /// Lets SIGINT and SIGTERM call Stop(), the first time that they come. For one server of a process.
  void StopOnSignals();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace morphograph
