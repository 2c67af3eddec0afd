#include "api/server.h"

#include <fcntl.h>
#include <httplib.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "api/content_negotiation.h"
#include "api/error_mapping.h"
#include "api/internal/chunked_body.h"
#include "api/internal/connection_threads.h"
#include "api/internal/http_head.h"
#include "api/internal/socket_stream.h"
#include "api/internal/worker_slots.h"

// cpp-httplib accepts connections, parses and dispatches requests, reads bodies and writes answers. What it leaves
// open is closed before it sees a byte: this file reads each head itself, bounded in size and time, refuses what must
// be refused, and then lets the library's process_request() read a short head of its own making (method, "/", length)
// and behind it exactly the body's bytes. So none of these come into play: lines without bound, regular expressions
// over what clients send (routes, Range, multipart), bodies that are chunked (the library is told of none: where a route answers
// them as they come, this file reads them and closes the connection behind them), have no length, are compressed or stay
// on the socket to be read as the next request, answers compressed unasked, select() on high descriptors. The
// listening socket is ours as well: no SO_REUSEPORT, by which two servers would share a port unnoticed, and a longer
// backlog than 5.

namespace morphograph {

using Clock = std::chrono::steady_clock;

namespace {

constexpr std::size_t kSmallBody = 1 << 20;  // up to here a body counts no budget
constexpr std::chrono::seconds kLinger{5};   // for reading what a refused client still sends
constexpr std::string_view kNoRoute = "none";
constexpr std::size_t kLongestWhole = 256 << 20;  // of an answer in pieces that a client of HTTP/1.0 gets in one
constexpr std::size_t kLongestFirstLine = 64 * 1024;  // of a body that is still being sent

int ThreadCount(int asked) {
  if (asked > 0) return asked;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

// IMF-fixdate (RFC 9110, 5.6.7); never by strftime, whose names follow the locale.
std::string HttpDate() {
  static constexpr std::array<const char*, 7> kDays = {"Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"};
  static constexpr std::array<const char*, 12> kMonths = {"Jan", "Feb", "Mar", "Apr", "May", "Jun",
                                                          "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[64];
  std::snprintf(text, sizeof text, "%s, %02d %s %04d %02d:%02d:%02d GMT", kDays[static_cast<std::size_t>(utc.tm_wday)],
                utc.tm_mday, kMonths[static_cast<std::size_t>(utc.tm_mon)], utc.tm_year + 1900, utc.tm_hour, utc.tm_min,
                utc.tm_sec);
  return text;
}

Problem Busy(std::string detail) { return {503, std::move(detail), {}, 1, {}}; }

// Strangers choose methods; the table of metrics must not grow with them.
std::string_view MethodLabel(std::string_view method) {
  for (const std::string_view known : {"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
    if (method == known) return known;
  return "other";
}

// The host in an Origin, "http://[::1]:8080" or "https://name"; empty for "null".
std::string_view HostOf(std::string_view origin) {
  const std::size_t scheme = origin.find("://");
  if (scheme == std::string_view::npos) return {};
  origin.remove_prefix(scheme + 3);
  const std::size_t end = origin.starts_with('[') ? origin.find(']') + 1 : origin.find(':');
  return origin.substr(0, end);
}

// A page of another site may not change anything here behind its reader's back. (Browsers say where a request comes
// from; other programs do not.)
void RefuseCrossSite(const internal::HttpHead& head, const std::vector<std::string>& page_hosts) {
  if (head.method == "GET" || head.method == "HEAD") return;
  if (const std::string_view origin = head.Value("Origin"); !origin.empty() && !page_hosts.empty()) {
    const std::string_view host = HostOf(origin);
    const bool known = std::any_of(page_hosts.begin(), page_hosts.end(),
                                   [&](const std::string& name) { return EqualsIgnoringCase(host, name); });
    if (!known) throw ProblemError(403, "requests from pages of other hosts are not taken; see serve --page-host");
  }
  if (EqualsIgnoringCase(head.Value("Sec-Fetch-Site"), "cross-site"))
    throw ProblemError(403, "requests from pages of other sites are not taken");
}

// The part of all large bodies' budget that one request holds.
class BodyBudget {
 public:
  explicit BodyBudget(std::atomic<std::size_t>* used) : used_(used) {}
  ~BodyBudget() { Release(); }
  BodyBudget(const BodyBudget&) = delete;
  BodyBudget& operator=(const BodyBudget&) = delete;

  bool Take(std::size_t bytes, std::size_t limit) {
    if (bytes > limit || used_->fetch_add(bytes) > limit - bytes) {
      if (bytes <= limit) *used_ -= bytes;
      return false;
    }
    held_ = bytes;
    return true;
  }
  void Release() { *used_ -= std::exchange(held_, 0); }

 private:
  std::atomic<std::size_t>* used_;
  std::size_t held_ = 0;
};

// One request and what became of it; lives on the stack of its connection's thread.
struct Exchange {
  Exchange(std::atomic<std::size_t>* body_bytes, internal::SocketStream* the_socket) : socket(the_socket), budget(body_bytes) {}

  internal::SocketStream* socket;
  internal::HttpHead head;
  const Route* route = nullptr;
  std::vector<std::string> arguments;
  std::optional<HttpResponse> answer;  // given before the body was read: a refusal, or OPTIONS
  bool keep_alive = true;
  bool is_unended = false;  // an answer in pieces, whose last one is not out
  bool is_gone = false;  // the client left, or was too slow: nobody to answer
  Clock::time_point started = Clock::now();
  BodyBudget budget;
};

// The turns of a request that works for long.
class Turns : public LongWork {
 public:
  Turns(internal::WorkerSlots* slots, int workers, const Exchange& exchange, const std::atomic<bool>& stopping, std::chrono::seconds limit)
      : slots_(slots), workers_(workers), socket_(*exchange.socket), stopping_(stopping), deadline_(Clock::now() + limit) {}

  int workers() const override { return workers_; }
  Stop stop() const override {
    if (stopping_) return Stop::kStopping;
    if (Clock::now() >= deadline_) return Stop::kLate;
    return socket_.IsClosedByPeer() ? Stop::kGone : Stop::kNone;
  }
  bool TakeTurn(int worker) override {
    if (worker == 0) slots_->Yield();  // its thread has been inside since the request's own turn came
    while (stop() == Stop::kNone) {
      if (worker == 0 || slots_->EnterAsHelper(Clock::now() + kAskAgain)) return true;
    }
    return false;
  }
  void EndTurn(int worker) override {
    if (worker != 0) slots_->LeaveAsHelper();
  }

 private:
  static constexpr std::chrono::milliseconds kAskAgain{100};
  internal::WorkerSlots* slots_;
  const int workers_;
  const internal::SocketStream& socket_;
  const std::atomic<bool>& stopping_;
  const Clock::time_point deadline_;
};

// The library's handlers are told of a request nothing but what it parsed.
thread_local Exchange* current_exchange = nullptr;

// What process_request() reads and writes: one request, not a byte more.
class RequestStream : public httplib::Stream {
 public:
  RequestStream(const Exchange& exchange, internal::SocketStream* socket, const ServerOptions& options)
      : exchange_(exchange),
        socket_(socket),
        body_left_(exchange.answer ? 0 : exchange.head.body_bytes),
        body_deadline_(Clock::now() + options.body_timeout + std::chrono::seconds(body_left_ >> 20)),
        write_timeout_(options.write_timeout) {
    const std::string& method = exchange.head.method;
    head_ = exchange.answer ? (method == "HEAD" ? "HEAD" : "GET") : method;
    head_ += " / HTTP/1.1\r\nContent-Length: " + std::to_string(body_left_) + "\r\n\r\n";
  }

  bool is_readable() const override { return true; }
  bool is_writable() const override { return true; }
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  // The library compares it with select()'s limit, and has no other use for it.
  socket_t socket() const override { return 0; }

  ssize_t read(char* to, std::size_t size) override {
    if (head_at_ < head_.size()) {
      const std::size_t taken = head_.copy(to, size, head_at_);
      head_at_ += taken;
      return static_cast<ssize_t>(taken);
    }
    const std::size_t wanted = static_cast<std::size_t>(std::min<std::uint64_t>(size, body_left_));
    const std::size_t got = socket_->Read(to, wanted, body_deadline_);
    body_left_ -= got;
    return static_cast<ssize_t>(got);
  }

  // Head and body of an answer come one by one; they leave together.
  ssize_t write(const char* from, std::size_t size) override {
    if (exchange_.is_gone || failed_) return -1;
    // What is answered while the request still comes is waited for.
    if (held_.empty() && !exchange_.head.is_chunked) {
      held_.assign(from, size);
      return static_cast<ssize_t>(size);
    }
    return Send({from, size}) ? static_cast<ssize_t>(size) : -1;
  }

  /// Sends what is held back. @return whether the whole body was read and all of the answer is out.
  bool Finish() {
    if (!exchange_.is_gone && !failed_ && !held_.empty()) Send({});
    return !exchange_.is_gone && !failed_ && body_left_ == 0;
  }

 private:
  bool Send(std::string_view more) {
    // What is answered while it comes takes as long as it comes.
    if (!write_deadline_ || exchange_.head.is_chunked) write_deadline_ = Clock::now() + write_timeout_;
    // A long answer may take longer, but no slower than a mebibyte a second.
    failed_ = !socket_->Write(held_, more, *write_deadline_ + std::chrono::seconds(written_ >> 20));
    written_ += more.size();
    held_.clear();
    return !failed_;
  }

  const Exchange& exchange_;
  internal::SocketStream* socket_;
  std::string head_;
  std::size_t head_at_ = 0;
  std::uint64_t body_left_;
  const Clock::time_point body_deadline_;
  const Clock::duration write_timeout_;
  std::optional<Clock::time_point> write_deadline_;
  std::string held_;
  std::uint64_t written_ = 0;
  bool failed_ = false;
};

}  // namespace

struct Server::State : private httplib::Server {
  State(const Router& the_router, Metrics* the_metrics, ServerOptions the_options);
  ~State() override;

  int Bind();
  void Run();
  void RequestStop();  // async-signal-safe
  static void OnSignal(int);

  static std::atomic<State*> of_signals;

 private:
  // An open connection, known to the thread that stops the server.
  struct Connection {
    int socket;
    bool is_idle = false;  // may be cut off: no request of its is under way
  };
  class TaskQueue;

  bool process_and_close_socket(socket_t socket) override;
  void Serve(Connection* connection, bool is_refused);
  bool ReadHead(internal::SocketStream* socket, Connection* connection, Exchange* exchange);
  void CheckRequest(Exchange* exchange);
  void Handle(httplib::Response& out, const httplib::ContentReader* reader);
  HttpResponse CarryOut(Exchange* exchange, HttpRequest* request);
  void Answer(HttpResponse response, httplib::Response& out);
  bool Respond(Exchange* exchange, internal::SocketStream* socket);
  bool SetIdle(Connection* connection, bool is_idle);

  const Router& router_;
  Metrics* metrics_;
  const ServerOptions options_;
  internal::WorkerSlots slots_;
  std::atomic<std::size_t> body_bytes_{0};
  std::atomic<bool> stopping_{false};
  std::atomic<int> listener_{-1};

  std::mutex mutex_;
  std::condition_variable closed_;
  std::set<Connection*> connections_;
  // Last, so that they have ended before anything that they refer to is gone.
  internal::ConnectionThreads threads_;
};

std::atomic<Server::State*> Server::State::of_signals{nullptr};

// The library's own queue grows without bound. This one takes what the connections' threads take, and what they do
// not take is carried out by the accepting thread itself, where a connection is closed at once.
class Server::State::TaskQueue : public httplib::TaskQueue {
 public:
  explicit TaskQueue(internal::ConnectionThreads* threads) : threads_(threads) {}
  void enqueue(std::function<void()> work) override {
    if (!threads_->TryStart(work)) work();
  }
  void shutdown() override {}

 private:
  internal::ConnectionThreads* threads_;
};

namespace {

thread_local bool is_accepting_thread = false;

}  // namespace

Server::State::State(const Router& the_router, Metrics* the_metrics, ServerOptions the_options)
    : router_(the_router),
      metrics_(the_metrics),
      options_(std::move(the_options)),
      slots_(ThreadCount(options_.threads), options_.max_queued, the_metrics),
      // Refused connections are told so, but only as many again: past that they are simply closed.
      threads_(static_cast<std::size_t>(2 * options_.max_connections)) {
  new_task_queue = [this] { return new TaskQueue(&threads_); };
  set_pre_routing_handler([this](const httplib::Request&, httplib::Response& out) {
    if (!current_exchange->answer) return HandlerResponse::Unhandled;
    Answer(std::move(*current_exchange->answer), out);
    return HandlerResponse::Handled;
  });
  const auto with_body = [this](const httplib::Request&, httplib::Response& out, const httplib::ContentReader& reader) {
    Handle(out, &reader);
  };
  Get("/", [this](const httplib::Request&, httplib::Response& out) { Handle(out, nullptr); });
  Post("/", with_body);
  Put("/", with_body);
  Patch("/", with_body);
  Delete("/", with_body);
  // Without one the library would tell clients an exception's text in a header.
  set_exception_handler([this](const httplib::Request&, httplib::Response& out, std::exception_ptr error) {
    Answer(ProblemResponse(ProblemFrom(error)), out);
  });
  set_post_routing_handler([this](const httplib::Request&, httplib::Response& out) {
    for (const char* name : {"Connection", "Keep-Alive", "Accept-Ranges"}) out.headers.erase(name);
    if (out.status == 204 || out.status == 304) out.headers.erase("Content-Length");
    Exchange& exchange = *current_exchange;
    if (stopping_) exchange.keep_alive = false;
    if (!exchange.keep_alive) {
      out.set_header("Connection", "close");
    } else if (exchange.head.minor_version == 0) {
      out.set_header("Connection", "keep-alive");
    }
  });
}

Server::State::~State() {
  threads_.Join();
  State* self = this;
  of_signals.compare_exchange_strong(self, nullptr);
  if (listener_ >= 0) ::close(listener_);
}

int Server::State::Bind() {
  const std::string port = std::to_string(options_.port);
  const auto fail = [&](const std::string& reason) {
    throw std::runtime_error("cannot listen on " + options_.host + ":" + port + ": " + reason);
  };
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(options_.host.c_str(), port.c_str(), &hints, &found); error != 0)
    fail(::gai_strerror(error));
  const int socket = ::socket(found->ai_family, found->ai_socktype | SOCK_CLOEXEC, found->ai_protocol);
  const int on = 1;
  const bool is_bound = socket >= 0 && ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) == 0 &&
                        ::bind(socket, found->ai_addr, found->ai_addrlen) == 0 && ::listen(socket, SOMAXCONN) == 0;
  const int error = errno;
  ::freeaddrinfo(found);
  if (!is_bound) {
    if (socket >= 0) ::close(socket);
    fail(std::generic_category().message(error));
  }
  listener_ = socket;
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(address).sin6_port
                                             : reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

void Server::State::Run() {
  is_accepting_thread = true;
  if (options_.ready) {
    *options_.ready = true;
    if (stopping_) *options_.ready = false;  // told to before, or just now
  }
  while (!stopping_) {
    // The library gives up at the first failed accept, be it that the client had gone already. It is given a
    // descriptor of its own, and another one after that.
    svr_sock_ = ::fcntl(listener_, F_DUPFD_CLOEXEC, 0);
    if (svr_sock_ != INVALID_SOCKET) listen_after_bind();
    svr_sock_ = INVALID_SOCKET;
    if (!stopping_) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  is_accepting_thread = false;
  {
    std::unique_lock lock(mutex_);
    for (const Connection* connection : connections_)
      if (connection->is_idle) ::shutdown(connection->socket, SHUT_RDWR);
    if (!closed_.wait_for(lock, options_.stop_timeout, [&] { return connections_.empty(); }))
      for (const Connection* connection : connections_) ::shutdown(connection->socket, SHUT_RDWR);
  }
  threads_.Join();
}

void Server::State::RequestStop() {
  stopping_ = true;
  if (options_.ready) *options_.ready = false;
  // Wakes the accepting thread; clients that come now are told that nobody listens.
  if (const int listener = listener_; listener >= 0) ::shutdown(listener, SHUT_RDWR);
}

void Server::State::OnSignal(int) {
  const int saved = errno;
  if (State* state = of_signals) state->RequestStop();
  errno = saved;
}

bool Server::State::process_and_close_socket(socket_t socket) {
  Connection connection{socket};
  bool is_refused = false;
  {
    const std::lock_guard lock(mutex_);
    is_refused = static_cast<int>(connections_.size()) >= options_.max_connections;
    connections_.insert(&connection);
    metrics_->connections = static_cast<int>(connections_.size());
  }
  if (!is_accepting_thread && !stopping_) {
    try {
      Serve(&connection, is_refused);
    } catch (const std::exception& error) {
      // Out of memory, most likely: this connection ends, the server goes on.
      std::fprintf(stderr, "morphograph: internal error: %s\n", error.what());
    } catch (...) {
      std::fputs("morphograph: internal error of unknown type\n", stderr);
    }
  }
  const std::lock_guard lock(mutex_);
  connections_.erase(&connection);
  metrics_->connections = static_cast<int>(connections_.size());
  ::close(socket);  // under the lock: nobody may shut down the descriptor's next owner
  closed_.notify_all();
  return true;
}

bool Server::State::SetIdle(Connection* connection, bool is_idle) {
  const std::lock_guard lock(mutex_);
  connection->is_idle = is_idle;
  return !stopping_;
}

void Server::State::Serve(Connection* connection, bool is_refused) {
  const int on = 1;
  // set_tcp_nodelay() reaches only a listening socket of the library's own. An answer leaves at once, not 40 ms later.
  ::setsockopt(connection->socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  internal::SocketStream socket(connection->socket);
  while (true) {
    Exchange exchange(&body_bytes_, &socket);
    if (is_refused) {
      ++metrics_->refused;
      exchange.answer = ProblemResponse(Busy("too many connections are open; try again"));
      exchange.keep_alive = false;
    } else if (!ReadHead(&socket, connection, &exchange)) {
      return;
    }
    const bool is_whole = Respond(&exchange, &socket);
    if (exchange.is_gone) return;
    if (!is_whole || !exchange.keep_alive) break;
  }
  if (SetIdle(connection, true)) socket.Linger(Clock::now() + kLinger);
}

/// The next request's head, checked, or the answer that refuses it. False when there is none to be answered.
bool Server::State::ReadHead(internal::SocketStream* socket, Connection* connection, Exchange* exchange) {
  if (!SetIdle(connection, true)) return false;
  const Clock::time_point deadline = Clock::now() + options_.head_timeout;
  try {
    std::size_t end;
    while (true) {
      // Empty lines before a request are skipped (RFC 9112, 2.2).
      while (socket->buffered().starts_with("\r\n")) socket->Consume(2);
      end = socket->buffered().find("\r\n\r\n");
      if (end != std::string_view::npos && end <= internal::kMaxHeadBytes) break;
      internal::CheckUnfinishedHead(socket->buffered());
      if (!socket->Fill(deadline, internal::kMaxHeadBytes)) return false;
    }
    SetIdle(connection, false);
    exchange->started = Clock::now();
    const std::string text(socket->buffered().substr(0, end + 2));
    socket->Consume(end + 4);
    internal::ParseHttpHead(text, &exchange->head);
    exchange->keep_alive = exchange->head.keep_alive;
    CheckRequest(exchange);
  } catch (...) {
    SetIdle(connection, false);
    exchange->started = Clock::now();
    exchange->answer = ProblemResponse(ProblemFrom(std::current_exception()));
    exchange->keep_alive = false;
  }
  if (!exchange->answer && exchange->head.expects_continue && (exchange->head.body_bytes > 0 || exchange->head.is_chunked))
    return socket->Write("HTTP/1.1 100 Continue\r\n\r\n", {}, Clock::now() + options_.write_timeout);
  return true;
}

/// Everything that can be refused before a body is read. @throws ProblemError
void Server::State::CheckRequest(Exchange* exchange) {
  const internal::HttpHead& head = exchange->head;
  if (head.method == "OPTIONS") {
    if (head.body_bytes > 0) throw ProblemError(413, "this method takes no body");
    if (head.is_chunked) throw ProblemError(411, "this method takes no body");
    const std::string allowed = head.path.starts_with('/') ? router_.Allowed(head.path) : "GET, HEAD, POST, DELETE, OPTIONS";
    if (allowed.empty()) throw ProblemError(404, "there is nothing here");
    exchange->answer.emplace();
    exchange->answer->status = 204;
    exchange->answer->Set("Allow", allowed);
    return;
  }
  auto [route, arguments] = router_.Find(head.method, head.path);
  exchange->route = route;
  exchange->arguments = std::move(arguments);
  if (head.body_bytes > route->max_body) {
    throw ProblemError(413, route->max_body == 0
                                ? std::string("this route takes no body")
                                : "the body has " + std::to_string(head.body_bytes) + " bytes; at most " +
                                      std::to_string(route->max_body) + " are taken here");
  }
  if (head.is_chunked) {
    if (route->live_type.empty() || !EqualsIgnoringCase(MediaTypeOf(head.Value("Content-Type")), route->live_type))
      throw ProblemError(411, "chunked transfers are not taken here; send a Content-Length");
    exchange->keep_alive = false;
  }
  RefuseCrossSite(head, options_.page_hosts);
  if (head.body_bytes > kSmallBody && !exchange->budget.Take(head.body_bytes, options_.max_body_bytes)) {
    ++metrics_->refused;
    throw ProblemError(Busy("too many large bodies are on their way; try again"));
  }
}

/// Has the library parse, dispatch and answer the request. @return whether the connection can take another one.
bool Server::State::Respond(Exchange* exchange, internal::SocketStream* socket) {
  RequestStream stream(*exchange, socket, options_);
  current_exchange = exchange;
  bool is_closed = false;
  bool is_processed = false;
  try {
    is_processed = process_request(stream, /*close_connection=*/false, is_closed, {});
  } catch (...) {
    current_exchange = nullptr;
    throw;
  }
  current_exchange = nullptr;
  return stream.Finish() && is_processed && !is_closed && !exchange->is_unended;
}

void Server::State::Handle(httplib::Response& out, const httplib::ContentReader* reader) {
  Exchange& exchange = *current_exchange;
  HttpRequest request;
  request.method = exchange.route->method;
  request.path = exchange.head.path;
  request.arguments = std::move(exchange.arguments);
  request.headers = exchange.head.headers;
  const auto length = static_cast<std::size_t>(exchange.head.body_bytes);
  if (exchange.head.is_chunked) {
    const auto body = std::make_shared<internal::ChunkedBody>(exchange.socket, options_.body_timeout, &stopping_);
    // The first line is waited for here, where no worker's turn is spent on it.
    while (request.body.find('\n') == std::string::npos) {
      const std::string piece = body->Next();
      if (piece.empty()) break;
      request.body += piece;
      if (std::min(request.body.find('\n'), request.body.size()) > kLongestFirstLine) throw ProblemError(413, "the first line is too long");
    }
    request.incoming = [body] { return body->Next(); };
  } else if (length > 0) {
    request.body.reserve(std::min(length, kSmallBody));
    const bool is_whole = reader && (*reader)([&](const char* data, std::size_t size) {
      // Room for a large body is taken once its sender has shown that it means it.
      if (request.body.size() + size > request.body.capacity()) request.body.reserve(length);
      request.body.append(data, size);
      return true;
    });
    if (!is_whole) {
      exchange.is_gone = true;  // a body cut short by its sender is not answered: nobody is there
      return;
    }
  }
  Answer(CarryOut(&exchange, &request), out);
}

HttpResponse Server::State::CarryOut(Exchange* exchange, HttpRequest* request) {
  const Route& route = *exchange->route;
  Turns turns(&slots_, ThreadCount(options_.threads), *exchange, stopping_, options_.work_timeout);
  request->work = &turns;
  const auto carry_out = [&] {
    try {
      return route.handler(*request);
    } catch (...) {
      return ProblemResponse(ProblemFrom(std::current_exception()));
    }
  };
  if (route.immediate) return carry_out();
  switch (slots_.Enter(Clock::now() + options_.queue_timeout)) {
    case internal::WorkerSlots::Entry::kFull:
      ++metrics_->refused;
      return ProblemResponse(Busy("too many requests are waiting; try again"));
    case internal::WorkerSlots::Entry::kLate:
      ++metrics_->refused;
      return ProblemResponse(Busy("the request waited too long for its turn; try again"));
    case internal::WorkerSlots::Entry::kEntered:
      break;
  }
  const std::unique_ptr<internal::WorkerSlots, void (*)(internal::WorkerSlots*)> leave(
      &slots_, [](internal::WorkerSlots* slots) { slots->Leave(); });
  return carry_out();
}

void Server::State::Answer(HttpResponse response, httplib::Response& out) {
  Exchange& exchange = *current_exchange;
  exchange.budget.Release();
  const std::chrono::duration<double> elapsed = Clock::now() - exchange.started;
  metrics_->CountRequest(MethodLabel(exchange.head.method),
                         exchange.route ? std::string_view(exchange.route->pattern) : kNoRoute, response.status,
                         elapsed.count());
  out.status = response.status;
  out.headers.clear();
  out.set_header("Date", HttpDate());
  out.set_header("X-Content-Type-Options", "nosniff");
  for (const auto& [name, value] : response.headers) {
    out.headers.erase(name);
    out.set_header(name, value);
  }
  if (response.status == 204 || response.status == 304) response.body.clear();
  if (!response.more) {
    out.body = std::move(response.body);
  } else if (exchange.head.minor_version == 0) {  // knows no chunks
    for (std::string piece = response.more(); !piece.empty() && !stopping_; piece = response.more()) {
      out.body += piece;
      if (out.body.size() > kLongestWhole) throw ProblemError(505, "so long an answer takes HTTP/1.1");
    }
  } else {
    const std::string type(response.Header("Content-Type"));
    out.headers.erase("Content-Type");
    exchange.is_unended = true;
    out.set_chunked_content_provider(type, [more = std::move(response.more), &exchange](std::size_t, httplib::DataSink& sink) {
      const std::string piece = more();
      if (piece.empty()) {
        exchange.is_unended = false;
        sink.done();
        return true;
      }
      return sink.write(piece.data(), piece.size());
    });
  }
}

Server::Server(const Router& router, Metrics* metrics, ServerOptions options)
    : state_(std::make_unique<State>(router, metrics, std::move(options))) {}

Server::~Server() = default;

int Server::Bind() { return state_->Bind(); }

void Server::Run() { state_->Run(); }

void Server::Stop() { state_->RequestStop(); }

void Server::StopOnSignals() {
  State::of_signals = state_.get();
  struct sigaction action {};
  action.sa_handler = &State::OnSignal;
  // A second signal ends the process as usual.
  action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
  for (const int signal : {SIGINT, SIGTERM}) ::sigaction(signal, &action, nullptr);
}

}  // namespace morphograph
