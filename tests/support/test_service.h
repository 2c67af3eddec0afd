#pragma once

#include <optional>
#include <thread>

#include "api/routes.h"
#include "api/server.h"
#include "api/service.h"

namespace morphograph::testing {

/// The whole HTTP interface on a free port of the loopback, until it goes out of scope.
class TestService {
 public:
  explicit TestService(ServerOptions options = {}) {
    options.port = 0;
    if (options.threads == 0) options.threads = 2;
    options_ = options;
  }
  /// Models and training are added to `service` before this.
  void Start() {
    router.emplace(AllRoutes(&service));
    options_.ready = &service.ready;
    server_.emplace(*router, &service.metrics, options_);
    port = server_->Bind();
    thread_ = std::thread([this] { server_->Run(); });
  }
  ~TestService() { Stop(); }
  /// Answers no more. Before what it serves ends; a second time it does nothing.
  void Stop() {
    if (!thread_.joinable()) return;
    server_->Stop();
    thread_.join();
    server_.reset();
  }
  TestService(const TestService&) = delete;
  TestService& operator=(const TestService&) = delete;

  Service service;
  std::optional<Router> router;
  int port = 0;

 private:
  ServerOptions options_;
  std::optional<Server> server_;
  std::thread thread_;
};

}  // namespace morphograph::testing
