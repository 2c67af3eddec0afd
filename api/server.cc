#include "api/server.h"

#include <algorithm>
#include <array>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <limits>
#include <optional>
#include <set>
#include <thread>

#include "api/error_mapping.h"

namespace morphograph {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using tcp = boost::asio::ip::tcp;
using Clock = std::chrono::steady_clock;

namespace {

constexpr std::size_t kMaxHead = 16 * 1024;         // request line and headers
constexpr std::size_t kMaxTarget = 8 * 1024;
constexpr std::size_t kSmallBody = 1 << 20;         // up to here a body counts no budget
constexpr std::chrono::seconds kLinger{5};          // for reading what a refused client still sends
constexpr std::string_view kNoRoute = "none";

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

std::string_view View(beast::string_view text) { return {text.data(), text.size()}; }

Problem ProblemOfParser(const beast::error_code& error) {
  if (error == http::error::header_limit)
    return {431, "request line and headers exceed " + std::to_string(kMaxHead) + " bytes", {}, {}, {}};
  if (error == http::error::bad_version) return {505, "only HTTP/1.0 and HTTP/1.1 are spoken here", {}, {}, {}};
  if (error == http::error::body_limit) return {413, "the body is too large", {}, {}, {}};
  return {400, "this is not a well-formed HTTP request", {}, {}, {}};
}

}  // namespace

struct Server::State {
  State(const Router& the_router, Metrics* the_metrics, ServerOptions the_options)
      : router(the_router),
        metrics(the_metrics),
        options(std::move(the_options)),
        acceptor(io),
        retry(io),
        signals(io),
        stop_timer(io),
        workers(static_cast<std::size_t>(ThreadCount(options.threads))) {}

  const Router& router;
  Metrics* metrics;
  const ServerOptions options;
  // Touched by the I/O thread only. Before `io`, whose end takes the last sessions along.
  std::set<Session*> sessions;
  std::size_t body_bytes = 0;
  int queued = 0;
  bool stopping = false;

  asio::io_context io{1};
  tcp::acceptor acceptor;
  asio::steady_timer retry;  // after a failed accept
  asio::signal_set signals;
  asio::steady_timer stop_timer;
  // Last, so that it is joined before anything that its work refers to is gone.
  asio::thread_pool workers;

  void Accept();
  void BeginStop();
  HttpResponse Carry(const Route& route, const HttpRequest& request);
};

/// One connection: reads a head, checks it, reads the body, has it carried out, writes the answer, and again.
class Server::Session : public std::enable_shared_from_this<Session> {
 public:
  Session(tcp::socket socket, State* state) : stream_(std::move(socket)), state_(state) {
    state_->sessions.insert(this);
    state_->metrics->connections = static_cast<int>(state_->sessions.size());
  }
  ~Session() {
    ReleaseBody();
    state_->sessions.erase(this);
    state_->metrics->connections = static_cast<int>(state_->sessions.size());
    if (state_->stopping && state_->sessions.empty()) state_->stop_timer.cancel();
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  void Start() {
    beast::error_code ignored;
    stream_.socket().set_option(tcp::no_delay(true), ignored);  // an answer leaves at once
    ReadHead();
  }

  void Refuse(const Problem& problem) {
    started_ = Clock::now();
    ++state_->metrics->refused;
    Answer(ProblemResponse(problem), /*keep_alive=*/false);
  }

  /// Closes at once when nothing is under way; else after the answer.
  void CloseWhenIdle() {
    if (phase_ == Phase::kIdle || phase_ == Phase::kLingering) Close();
  }

  void Close() {
    beast::error_code ignored;
    stream_.socket().close(ignored);
  }

 private:
  enum class Phase { kIdle, kBusy, kLingering };

  void ReadHead() {
    if (state_->stopping) return Linger();
    phase_ = Phase::kIdle;
    route_ = nullptr;
    parser_.emplace();
    parser_->header_limit(kMaxHead);
    // The route sets the limit, once it is known. (Not boost::none: 1.74 takes that for a limit of nothing.)
    parser_->body_limit(std::numeric_limits<std::uint64_t>::max());
    stream_.expires_after(state_->options.head_timeout);
    http::async_read_header(stream_, buffer_, *parser_,
                            beast::bind_front_handler(&Session::OnHead, shared_from_this()));
  }

  void OnHead(const beast::error_code& error, std::size_t) {
    started_ = Clock::now();
    phase_ = Phase::kBusy;
    if (error == http::error::end_of_stream) return Linger();
    if (error && error.category() != http::make_error_code(http::error::bad_method).category()) return;  // gone or slow
    try {
      if (error) throw ProblemError(ProblemOfParser(error));
      CheckHead();
    } catch (...) {
      return Answer(ProblemResponse(ProblemFrom(std::current_exception())), /*keep_alive=*/false);
    }
    const auto& head = parser_->get();
    if (head.method() == http::verb::options) return AnswerOptions();
    stream_.expires_after(state_->options.body_timeout + std::chrono::seconds(body_length_ >> 20));
    if (body_length_ > 0 && head.count(http::field::expect) > 0) {
      static constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
      return asio::async_write(stream_, asio::buffer(kContinue.data(), kContinue.size()),
                               [self = shared_from_this()](const beast::error_code& failed, std::size_t) {
                                 if (!failed) self->ReadBody();
                               });
    }
    ReadBody();
  }

  /// Everything that can be refused before a body is read. @throws ProblemError
  void CheckHead() {
    const auto& head = parser_->get();
    if (head.version() != 10 && head.version() != 11) throw ProblemError(ProblemOfParser(http::error::bad_version));
    // Two readers that disagree on where a body ends can be played off against each other (request smuggling):
    // only one framing is taken here, one Content-Length.
    if (head.count(http::field::transfer_encoding) > 0)
      throw ProblemError(411, "chunked and otherwise coded transfers are not taken; send a Content-Length");
    if (head.count(http::field::content_length) > 1 ||
        head[http::field::content_length].find(',') != beast::string_view::npos)
      throw ProblemError(400, "Content-Length stands twice");
    if (head.count(http::field::content_encoding) > 0)
      throw ProblemError(415, "coded bodies are not taken; send the body as it is");
    if (head.version() == 11 && head.count(http::field::host) != 1)
      throw ProblemError(400, "HTTP/1.1 needs exactly one Host header");
    if (head.count(http::field::expect) > 0 && !beast::iequals(head[http::field::expect], "100-continue"))
      throw ProblemError(417, "the only expectation met here is 100-continue");
    if (head.target().size() > kMaxTarget)
      throw ProblemError(414, "the request target exceeds " + std::to_string(kMaxTarget) + " bytes");

    std::string_view target = View(head.target());
    // Absolute form: the authority is ours, whatever it says (RFC 9112, 3.2.2).
    if (target.starts_with("http://")) target.remove_prefix(std::min(target.find('/', 7), target.size()));
    path_ = std::string(target.substr(0, target.find('?')));
    body_length_ = parser_->content_length().value_or(0);
    if (head.method() == http::verb::options) {
      if (body_length_ > 0) throw ProblemError(413, "this method takes no body");
      return;
    }
    auto [route, arguments] = state_->router.Find(View(head.method_string()), path_);
    route_ = route;
    arguments_ = std::move(arguments);
    if (body_length_ > route_->max_body) {
      throw ProblemError(413, route_->max_body == 0
                                  ? std::string("this route takes no body")
                                  : "the body has " + std::to_string(body_length_) + " bytes; at most " +
                                        std::to_string(route_->max_body) + " are taken here");
    }
    RefuseCrossSite(head);
    parser_->body_limit(route_->max_body);
    if (body_length_ > kSmallBody) {
      if (state_->body_bytes + body_length_ > state_->options.max_body_bytes) {
        ++state_->metrics->refused;
        throw ProblemError(Busy("too many large bodies are on their way; try again"));
      }
      reserved_ = body_length_;
      state_->body_bytes += reserved_;
    }
  }

  /// A page of another site may not change anything here behind its reader's back. (Browsers say where a request
  /// comes from; other programs do not.)
  static void RefuseCrossSite(const http::request_header<>& head) {
    if (head.method() == http::verb::get || head.method() == http::verb::head) return;
    if (beast::iequals(head["Sec-Fetch-Site"], "cross-site"))
      throw ProblemError(403, "requests from pages of other sites are not taken");
  }

  void ReadBody() {
    http::async_read(stream_, buffer_, *parser_, beast::bind_front_handler(&Session::OnBody, shared_from_this()));
  }

  void OnBody(const beast::error_code& error, std::size_t) {
    if (error) {
      // A body cut short by its sender is not answered: nobody is there. A parser's complaint is.
      if (error.category() != http::make_error_code(http::error::bad_method).category() ||
          error == http::error::partial_message)
        return;
      return Answer(ProblemResponse(ProblemOfParser(error)), /*keep_alive=*/false);
    }
    auto request = std::make_shared<HttpRequest>();
    auto& message = parser_->get();
    request->method = route_->method;
    request->path = path_;
    request->arguments = std::move(arguments_);
    request->body = std::move(message.body());
    for (const auto& field : message)
      request->headers.emplace_back(std::string(View(field.name_string())), std::string(View(field.value())));
    if (route_->immediate) return Answer(state_->Carry(*route_, *request), message.keep_alive());
    Enqueue(std::move(request));
  }

  void Enqueue(std::shared_ptr<HttpRequest> request) {
    const bool keep_alive = parser_->get().keep_alive();
    if (state_->queued >= state_->options.max_queued + ThreadCount(state_->options.threads)) {
      ++state_->metrics->refused;
      return Answer(ProblemResponse(Busy("too many requests are waiting; try again")), keep_alive);
    }
    state_->metrics->queued = ++state_->queued;
    stream_.expires_never();
    // The guard keeps the I/O thread alive while no input or output is pending.
    asio::post(state_->workers, [self = shared_from_this(), request = std::move(request), keep_alive, arrived = started_,
                                 guard = asio::make_work_guard(state_->io)]() mutable {
      State& state = *self->state_;
      HttpResponse response = Clock::now() - arrived > state.options.queue_timeout
                                  ? ProblemResponse(Busy("the request waited too long for a worker; try again"))
                                  : state.Carry(*self->route_, *request);
      request.reset();
      asio::post(state.io, [self = std::move(self), response = std::move(response), keep_alive,
                            guard = std::move(guard)]() mutable {
        State& owner = *self->state_;
        owner.metrics->queued = --owner.queued;
        self->ReleaseBody();
        self->Answer(std::move(response), keep_alive);
      });
    });
  }

  void AnswerOptions() {
    const std::string allowed = path_.starts_with('/') ? state_->router.Allowed(path_) : "GET, HEAD, POST, DELETE, OPTIONS";
    if (allowed.empty()) return Answer(ProblemResponse({404, "there is nothing here", {}, {}, {}}), false);
    HttpResponse response;
    response.status = 204;
    response.Set("Allow", allowed);
    Answer(std::move(response), parser_->get().keep_alive());
  }

  void Answer(HttpResponse response, bool keep_alive) {
    phase_ = Phase::kBusy;
    ReleaseBody();
    const bool is_request = parser_ && parser_->is_header_done();
    const auto method = is_request ? parser_->get().method() : http::verb::unknown;
    const auto elapsed = std::chrono::duration<double>(Clock::now() - started_);
    state_->metrics->CountRequest(method == http::verb::unknown ? "other" : View(http::to_string(method)),
                                  route_ ? std::string_view(route_->pattern) : kNoRoute, response.status,
                                  elapsed.count());

    keep_alive = keep_alive && !state_->stopping;
    message_.emplace();
    message_->version(is_request ? parser_->get().version() : 11);
    message_->result(static_cast<unsigned>(response.status));
    message_->reason(beast::string_view(StatusTitle(response.status).data(), StatusTitle(response.status).size()));
    message_->set(http::field::date, HttpDate());
    message_->set("X-Content-Type-Options", "nosniff");
    for (const auto& [name, value] : response.headers) message_->set(name, value);
    message_->keep_alive(keep_alive);
    if (response.status != 204 && response.status != 304) message_->content_length(response.body.size());
    message_->body() = std::move(response.body);

    stream_.expires_after(state_->options.write_timeout);
    auto on_written = [self = shared_from_this(), keep_alive](const beast::error_code& error, std::size_t) {
      self->serializer_.reset();
      self->message_.reset();
      if (error) return;
      if (keep_alive) {
        self->ReadHead();
      } else {
        self->Linger();
      }
    };
    serializer_.emplace(*message_);
    if (method == http::verb::head || response.status == 204 || response.status == 304) {
      http::async_write_header(stream_, *serializer_, std::move(on_written));
    } else {
      http::async_write(stream_, *serializer_, std::move(on_written));
    }
  }

  /// Half-closes, then reads and drops what still comes for a while: closing with unread input would reset the
  /// connection and could take the answer away from the client before it has read it.
  void Linger() {
    phase_ = Phase::kLingering;
    beast::error_code error;
    stream_.socket().shutdown(tcp::socket::shutdown_send, error);
    if (error || state_->stopping) return Close();
    stream_.expires_after(kLinger);
    buffer_.clear();
    Drain();
  }

  void Drain() {
    stream_.async_read_some(buffer_.prepare(64 * 1024),
                            [self = shared_from_this()](const beast::error_code& error, std::size_t) {
                              if (!error) self->Drain();
                            });
  }

  void ReleaseBody() {
    state_->body_bytes -= reserved_;
    reserved_ = 0;
  }

  beast::tcp_stream stream_;
  State* state_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  std::optional<http::response<http::string_body>> message_;
  std::optional<http::response_serializer<http::string_body>> serializer_;
  Phase phase_ = Phase::kIdle;
  Clock::time_point started_ = Clock::now();
  const Route* route_ = nullptr;
  std::vector<std::string> arguments_;
  std::string path_;
  std::uint64_t body_length_ = 0;
  std::size_t reserved_ = 0;
};

HttpResponse Server::State::Carry(const Route& route, const HttpRequest& request) {
  try {
    return route.handler(request);
  } catch (...) {
    return ProblemResponse(ProblemFrom(std::current_exception()));
  }
}

void Server::State::Accept() {
  acceptor.async_accept([this](const beast::error_code& error, tcp::socket socket) {
    if (stopping) return;
    if (error) {
      // Out of descriptors, or the client has gone already: neither ends the server.
      retry.expires_after(std::chrono::milliseconds(20));
      retry.async_wait([this](const beast::error_code& cancelled) {
        if (!cancelled && !stopping) Accept();
      });
      return;
    }
    const bool full = static_cast<int>(sessions.size()) >= options.max_connections;
    // Refused connections are told so, but only as many again: past that they are simply closed.
    if (static_cast<int>(sessions.size()) < 2 * options.max_connections) {
      const auto session = std::make_shared<Session>(std::move(socket), this);
      if (full) {
        session->Refuse(Busy("too many connections are open; try again"));
      } else {
        session->Start();
      }
    }
    Accept();
  });
}

void Server::State::BeginStop() {
  if (stopping) return;
  stopping = true;
  beast::error_code ignored;
  acceptor.close(ignored);
  retry.cancel();
  signals.cancel(ignored);
  if (sessions.empty()) return;
  for (Session* session : sessions) session->CloseWhenIdle();
  stop_timer.expires_after(options.stop_timeout);
  stop_timer.async_wait([this](const beast::error_code& cancelled) {
    if (cancelled) return;
    for (Session* session : sessions) session->Close();
  });
}

Server::Server(const Router& router, Metrics* metrics, ServerOptions options)
    : state_(std::make_unique<State>(router, metrics, std::move(options))) {}

Server::~Server() {
  state_->workers.join();
}

int Server::Bind() {
  const ServerOptions& options = state_->options;
  beast::error_code error;
  tcp::resolver resolver(state_->io);
  const auto found = resolver.resolve(options.host, std::to_string(options.port), tcp::resolver::passive, error);
  tcp::endpoint endpoint;
  if (!error) {
    endpoint = found.begin()->endpoint();
    state_->acceptor.open(endpoint.protocol(), error);
  }
  if (!error) state_->acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) state_->acceptor.bind(endpoint, error);
  if (!error) state_->acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) {
    throw std::runtime_error("cannot listen on " + options.host + ":" + std::to_string(options.port) + ": " +
                             error.message());
  }
  return state_->acceptor.local_endpoint().port();
}

void Server::Run() {
  asio::post(state_->io, [state = state_.get()] {
    if (!state->stopping) state->Accept();
  });
  while (true) {
    try {
      state_->io.run();
      return;
    } catch (const std::exception& error) {
      // A handler of ours threw (out of memory): its connection is gone, the server goes on.
      std::fprintf(stderr, "morphograph: internal error: %s\n", error.what());
    } catch (...) {
      std::fputs("morphograph: internal error of unknown type\n", stderr);
    }
  }
}

void Server::Stop() {
  asio::post(state_->io, [state = state_.get()] { state->BeginStop(); });
}

void Server::StopOnSignals() {
  state_->signals.add(SIGINT);
  state_->signals.add(SIGTERM);
  state_->signals.async_wait([state = state_.get()](const beast::error_code& cancelled, int) {
    if (!cancelled) state->BeginStop();
  });
}

}  // namespace morphograph
