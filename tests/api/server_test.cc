#include "api/server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <latch>
#include <thread>
#include <utility>
#include <vector>

#include "api/problem.h"
#include "tests/support/raw_http.h"

namespace morphograph {
namespace {

using std::chrono::milliseconds;
using testing::Ask;
using testing::RawConnection;
using testing::RawResponse;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::size_t kLimit = 1 << 20;

// Gives back what comes, as it comes, each piece with a bar behind it.
HttpResponse Live(const HttpRequest& request) {
  HttpResponse response;
  response.Set("Content-Type", "text/plain");
  response.more = [begun = false, ended = false, body = request.body, incoming = request.incoming]() mutable -> std::string {
    if (ended) return {};
    if (!std::exchange(begun, true)) return body + "|";
    try {
      const std::string piece = incoming ? incoming() : std::string();
      ended = piece.empty();
      return ended ? piece : piece + "|";
    } catch (const ProblemError& error) {
      ended = true;
      return ProblemLine(error.problem());
    }
  };
  return response;
}

class ServerTest : public ::testing::Test {
 protected:
  void Start(ServerOptions options = {}) {
    options.port = 0;
    if (options.threads == 0) options.threads = 2;
    server_.emplace(router_, &metrics_, options);
    port_ = server_->Bind();
    thread_ = std::thread([this] { server_->Run(); });
  }
  void TearDown() override {
    held_ = false;
    if (!server_) return;
    ExpectStillServes();
    server_->Stop();
    thread_.join();
  }
  void ExpectStillServes() { EXPECT_EQ(Ask(port_, "GET", "/hello").body, "hello"); }

  std::string Post(std::size_t length, const std::string& more = "") {
    return "POST /echo HTTP/1.1\r\nHost: test\r\n" + more + "Content-Length: " + std::to_string(length) + "\r\n\r\n";
  }

  // What the server answers to raw bytes, after which it must close.
  RawResponse AnswerTo(const std::string& bytes) {
    RawConnection connection(port_);
    connection.Send(bytes);
    auto response = connection.Read();
    EXPECT_TRUE(response) << "no answer to: " << bytes.substr(0, 60);
    if (!response) return {};
    EXPECT_EQ(response->headers["connection"], "close") << bytes;
    EXPECT_TRUE(connection.IsClosedWithin(2000));
    return *response;
  }

  static HttpResponse Text(std::string text) {
    HttpResponse response;
    response.body = std::move(text);
    return response;
  }

  std::atomic<bool> held_{true};
  std::atomic<int> carried_{0};
  std::latch entered_{1};
  Metrics metrics_;
  Router router_{{
      {"GET", "/hello", [](const HttpRequest&) { return Text("hello"); }, 0, true},
      {"POST", "/echo", [this](const HttpRequest& request) { ++carried_; return Text(request.body); }, kLimit},
      {"DELETE", "/thing", [](const HttpRequest&) { return Text("gone"); }},
      {"GET", "/throw", [](const HttpRequest&) -> HttpResponse { throw std::runtime_error("secret /etc/passwd"); }},
      {"GET", "/throw-int", [](const HttpRequest&) -> HttpResponse { throw 7; }},
      {"GET", "/hold",
       [this](const HttpRequest&) {
         if (carried_++ == 0) entered_.count_down();
         while (held_) std::this_thread::sleep_for(milliseconds(2));
         return Text("held");
       }},
      {"POST", "/live", [](const HttpRequest& request) { return Live(request); }, kLimit, false, "text/live"},
      {"GET", "/items/{name}", [](const HttpRequest& request) { return Text(request.arguments[0]); }},
  }};
  std::optional<Server> server_;
  std::thread thread_;
  int port_ = 0;
};

TEST_F(ServerTest, AnswersManyRequestsOnOneConnectionAlsoWhenSentAtOnce) {
  Start();
  RawConnection connection(port_);
  connection.Send(Post(3) + "one" + Post(3) + "two" + "GET /hello HTTP/1.1\r\nHost: test\r\n\r\n");
  for (const char* body : {"one", "two", "hello"}) {
    const auto response = connection.Read();
    ASSERT_TRUE(response);
    EXPECT_EQ(response->body, body);
    EXPECT_EQ(response->headers.at("x-content-type-options"), "nosniff");
    EXPECT_TRUE(response->headers.count("date"));
  }
}

TEST_F(ServerTest, HeadHasTheLengthButNoBody) {
  Start();
  RawConnection connection(port_);
  connection.Send("HEAD /hello HTTP/1.1\r\nHost: test\r\n\r\nGET /hello HTTP/1.1\r\nHost: test\r\n\r\n");
  const auto head = connection.Read(5000, /*head_only=*/true);
  ASSERT_TRUE(head);
  EXPECT_EQ(head->headers.at("content-length"), "5");
  const auto get = connection.Read();
  ASSERT_TRUE(get);
  EXPECT_EQ(get->body, "hello");
}

TEST_F(ServerTest, UnknownPathsAndMethodsAreProblems) {
  Start();
  const RawResponse unknown = Ask(port_, "GET", "/nothing");
  EXPECT_EQ(unknown.status, 404);
  EXPECT_EQ(unknown.headers.at("content-type"), "application/problem+json");
  const RawResponse wrong = Ask(port_, "DELETE", "/hello");
  EXPECT_EQ(wrong.status, 405);
  EXPECT_EQ(wrong.headers.at("allow"), "GET, HEAD, OPTIONS");
  EXPECT_EQ(Ask(port_, "BREW", "/hello").status, 405);
  EXPECT_EQ(Ask(port_, "OPTIONS", "/echo").headers.at("allow"), "POST, OPTIONS");
}

TEST_F(ServerTest, DecodesPathArgumentsAndIgnoresTheQuery) {
  Start();
  EXPECT_EQ(Ask(port_, "GET", "/items/a%20b%2Fc?x=/items/d").body, "a b/c");
  EXPECT_EQ(Ask(port_, "GET", "/items/%4").status, 400);
  EXPECT_EQ(Ask(port_, "GET", "/items/").status, 404);
  EXPECT_EQ(Ask(port_, "GET", "http://elsewhere/items/x").body, "x");
}

TEST_F(ServerTest, RefusesAGigabyteByItsAnnouncementAlone) {
  Start();
  RawConnection connection(port_);
  connection.Send(Post(std::size_t{1} << 30));
  const auto response = connection.Read(2000);  // before a byte of the body has been sent
  ASSERT_TRUE(response);
  EXPECT_EQ(response->status, 413);
  EXPECT_THAT(response->body, HasSubstr("1048576"));
}

TEST_F(ServerTest, AClientThatSendsItsHugeBodyAnywayStillSeesTheRefusal) {
  Start();
  RawConnection connection(port_);
  connection.Send(Post(std::size_t{64} << 20));
  const std::string block(1 << 20, 'x');
  for (int i = 0; i < 64 && connection.Send(block); ++i) continue;
  const auto response = connection.Read();
  ASSERT_TRUE(response);
  EXPECT_EQ(response->status, 413);
}

TEST_F(ServerTest, RefusesChunkedBodiesWithoutReadingThem) {
  Start();
  EXPECT_EQ(AnswerTo("POST /echo HTTP/1.1\r\nHost: t\r\nTransfer-Encoding: chunked\r\n\r\n").status, 411);
  EXPECT_EQ(AnswerTo("POST /echo HTTP/1.1\r\nHost: t\r\nTransfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n").status,
            411);
  EXPECT_EQ(AnswerTo("GET /hello HTTP/1.1\r\nHost: t\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n").status, 411);
  EXPECT_EQ(AnswerTo("POST /live HTTP/1.1\r\nHost: t\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n").status, 411);  // of no type
  // What follows is never a request of its own.
  for (const std::string head : {"OPTIONS /hello HTTP/1.1\r\n", "GET /hello HTTP/1.1\r\n", "POST /live HTTP/1.1\r\nContent-Type: text/live\r\n"}) {
    RawConnection connection(port_);
    connection.Send(head + "Host: t\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\nGET /items/smuggled HTTP/1.1\r\nHost: t\r\n\r\n");
    const auto response = connection.Read();
    ASSERT_TRUE(response) << head;
    EXPECT_EQ(response->headers.at("connection"), "close") << head;
    EXPECT_FALSE(connection.Read(300)) << head;
  }
}

// Lines are answered as they come: the answer to one is read before the next is sent.
TEST_F(ServerTest, AnswersBodiesThatAreStillBeingSentWhereTheRouteTakesThem) {
  Start();
  const std::string head = "POST /live HTTP/1.1\r\nHost: t\r\nContent-Type: text/live\r\nTransfer-Encoding: chunked\r\n\r\n";
  RawConnection connection(port_);
  ASSERT_TRUE(connection.Send(head + "5\r\nfirst\r\n1\r\n\n\r\n"));
  ASSERT_EQ(connection.ReadSome("first\n|"), "first\n|");
  ASSERT_TRUE(connection.Send("6\r\nsecond\r\n"));
  ASSERT_EQ(connection.ReadSome("second|"), "second|");
  ASSERT_TRUE(connection.Send("0\r\n\r\n"));
  EXPECT_TRUE(connection.IsClosedWithin(10'000, "0\r\n\r\n"));
  // Framed in every way but the right one.
  for (const std::string chunks : {"5;x=1\r\nfirst\r\n", "-5\r\nfirst\r\n", "\r\nfirst\r\n", "1000000\r\n", "5\nfirst\r\n", "g\r\n"}) {
    const RawResponse refused = AnswerTo(head + chunks);
    EXPECT_EQ(refused.status, 400) << chunks;
  }
  for (const std::string chunks : {"6\r\nfirst\n\r\n3\r\nsecond\r\n", "6\r\nfirst\n\r\n0\r\nTrailer: x\r\n\r\n"}) {
    RawConnection broken(port_);
    ASSERT_TRUE(broken.Send(head + chunks));
    EXPECT_EQ(broken.ReadSome("not well formed"), "not well formed") << chunks;
    EXPECT_TRUE(broken.IsClosedWithin(10'000, "not well formed"));
  }
  EXPECT_EQ(AnswerTo("POST /live HTTP/1.1\r\nHost: t\r\nContent-Type: text/live\r\nTransfer-Encoding: gzip, chunked\r\n\r\n").status, 411);
  EXPECT_EQ(AnswerTo("POST /live HTTP/1.0\r\nHost: t\r\nContent-Type: text/live\r\nTransfer-Encoding: chunked\r\n\r\n").status, 411);
  EXPECT_EQ(AnswerTo(head + "20000\r\n" + std::string(0x20000, 'x')).status, 413);  // a first line without end
  EXPECT_EQ(AnswerTo(head + "6\r\nfirst \r\n20000\r\nline\n" + std::string(0x20000 - 5, 'x') + "\r\n0\r\n\r\n").status, 200);
}

TEST_F(ServerTest, BodiesThatStopComingAreLetGo) {
  ServerOptions options;
  options.body_timeout = std::chrono::seconds(1);
  Start(options);
  const std::string head = "POST /live HTTP/1.1\r\nHost: t\r\nContent-Type: text/live\r\nTransfer-Encoding: chunked\r\n\r\n";
  EXPECT_EQ(AnswerTo(head + "3\r\nfir").status, 408);
  // Bytes that drip win no time; lines do.
  RawConnection drip(port_);
  drip.Send(head);
  const auto begun = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - begun < milliseconds(1500) && drip.Send("1\r\nx\r\n")) std::this_thread::sleep_for(milliseconds(100));
  const auto refused = drip.Read(1000);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->status, 408);
  RawConnection later(port_);
  ASSERT_TRUE(later.Send(head + "6\r\nfirst\n\r\n"));
  EXPECT_EQ(later.ReadSome("no line came for 1 seconds"), "no line came for 1 seconds");
}

TEST_F(ServerTest, BodiesWhereNoneIsTakenCannotPassAsANextRequest) {
  Start();
  const std::string smuggled = "GET /items/smuggled HTTP/1.1\r\nHost: t\r\n\r\n";
  for (const std::string method : {"GET /hello", "HEAD /hello", "DELETE /thing", "OPTIONS /hello"}) {
    RawConnection connection(port_);
    connection.Send(method + " HTTP/1.1\r\nHost: t\r\nContent-Length: " + std::to_string(smuggled.size()) + "\r\n\r\n" +
                    smuggled);
    const auto response = connection.Read(5000, method.starts_with("HEAD"));
    ASSERT_TRUE(response) << method;
    EXPECT_EQ(response->status, 413) << method;
    EXPECT_EQ(response->headers.at("connection"), "close");
    // Whatever follows is the refusal's own body at most, never a second answer.
    EXPECT_FALSE(connection.Read(300));
  }
}

TEST_F(ServerTest, RefusesFramingsThatTwoReadersMayReadDifferently) {
  Start();
  const std::string post = "POST /echo HTTP/1.1\r\nHost: t\r\n";
  for (const std::string headers :
       {"Content-Length: 3\r\nContent-Length: 4\r\n", "Content-Length: 3\r\nContent-Length: 3\r\n",
        "Content-Length: -1\r\n", "Content-Length: +3\r\n", "Content-Length: 3,3\r\n", "Content-Length: 0x3\r\n",
        "Content-Length: 99999999999999999999\r\n", "Content-Length : 3\r\n", "Content-Length\r\n", "Bad Name: 1\r\n"})
    EXPECT_EQ(AnswerTo(post + headers + "\r\nabc").status, 400) << headers;
  const int both = AnswerTo(post + "Content-Length: 3\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n").status;
  EXPECT_TRUE(both == 400 || both == 411) << both;
  EXPECT_EQ(carried_, 0);
}

TEST_F(ServerTest, RefusesWhatIsNotHttp) {
  Start();
  EXPECT_EQ(AnswerTo("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03 not for here\r\n\r\n").status, 400);
  EXPECT_EQ(AnswerTo("GET /hello\r\n\r\n").status, 400);
  EXPECT_EQ(AnswerTo("GET hello HTTP/1.1\r\nHost: t\r\n\r\n").status, 400);
  EXPECT_EQ(AnswerTo("GET /hello HTTP/1.1\r\n\r\n").status, 400);  // no Host
  EXPECT_EQ(AnswerTo("GET /hello HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n").status, 400);
  EXPECT_EQ(AnswerTo("GET /hello HTTP/3.7\r\nHost: t\r\n\r\n").status, 505);
  EXPECT_EQ(AnswerTo("POST /echo HTTP/1.1\r\nHost: t\r\nContent-Encoding: gzip\r\nContent-Length: 3\r\n\r\nabc").status,
            415);
  EXPECT_EQ(AnswerTo("POST /echo HTTP/1.1\r\nHost: t\r\nExpect: miracles\r\nContent-Length: 3\r\n\r\nabc").status, 417);
}

// What the library below would do with these headers: parse the body, unpack it, compress or cut the answer, or match
// a regular expression against them, recursing byte by byte.
TEST_F(ServerTest, HeadersThatTheLibraryWouldActOnReachOnlyTheHandler) {
  Start();
  const std::string form = "--b\r\nContent-Disposition: form-data; name=\"a\"\r\n\r\nx\r\n--b--\r\n";
  EXPECT_EQ(Ask(port_, "POST", "/echo", "Content-Type: multipart/form-data; boundary=b\r\n", form).body, form);
  EXPECT_EQ(Ask(port_, "POST", "/echo", "Content-Type: multipart/form-data; boundary=b\r\n", "no form").body, "no form");
  const std::string pairs(100'000, 'a');  // forms in a URL's style have a limit of their own
  EXPECT_EQ(Ask(port_, "POST", "/echo", "Content-Type: application/x-www-form-urlencoded\r\n", pairs).body, pairs);
  const RawResponse plain = Ask(port_, "GET", "/hello", "Accept-Encoding: gzip, br\r\nRange: bytes=1-2\r\n");
  EXPECT_EQ(plain.status, 200);
  EXPECT_EQ(plain.body, "hello");
  std::string ranges = "0-1";
  while (ranges.size() < 14'000) ranges += ",0-1";
  EXPECT_EQ(Ask(port_, "GET", "/hello", "Range: bytes=" + ranges + "\r\n").body, "hello");
  EXPECT_EQ(Ask(port_, "GET", "/items/" + std::string(8'000, 'a')).body.size(), 8'000u);
}

TEST_F(ServerTest, APostWithoutALengthHasNoBody) {
  Start();
  RawConnection connection(port_);
  connection.Send("POST /echo HTTP/1.1\r\nHost: t\r\n\r\nGET /hello HTTP/1.1\r\nHost: t\r\n\r\n");
  const auto empty = connection.Read(2000);
  ASSERT_TRUE(empty);
  EXPECT_EQ(empty->status, 200);
  EXPECT_EQ(empty->body, "");
  EXPECT_EQ(connection.Read(2000).value_or(RawResponse{}).body, "hello");
}

TEST_F(ServerTest, LinesEndWithCarriageReturnAndLineFeedOnly) {
  Start();
  EXPECT_EQ(AnswerTo("POST /echo HTTP/1.1\r\nHost: t\r\nX: y\nContent-Length: 3\r\n\r\n").status, 400);
  EXPECT_EQ(AnswerTo("POST /echo HTTP/1.1\r\nHost: t\r\nX: y\r\n Content-Length: 3\r\n\r\n").status, 400);
  EXPECT_EQ(AnswerTo("\x16\x03\x01").status, 400);  // does not wait for the end of a head that never comes
}

TEST_F(ServerTest, OldClientsKeepAConnectionOnlyWhenTheyAskTo) {
  Start();
  EXPECT_EQ(AnswerTo("GET /hello HTTP/1.0\r\n\r\n").body, "hello");
  RawConnection kept(port_);
  for (int i = 0; i < 2; ++i) {
    kept.Send("GET /hello HTTP/1.0\r\nConnection: keep-alive\r\n\r\n");
    EXPECT_EQ(kept.Read(2000).value_or(RawResponse{}).headers["connection"], "keep-alive");
  }
}

TEST_F(ServerTest, ARequestDoesNotWaitForeverForItsTurn) {
  ServerOptions options;
  options.threads = 1;
  options.queue_timeout = std::chrono::seconds(0);
  Start(options);
  std::thread client([&] { EXPECT_EQ(Ask(port_, "GET", "/hold").body, "held"); });
  entered_.wait();
  const RawResponse late = Ask(port_, "GET", "/items/x");
  EXPECT_EQ(late.status, 503);
  EXPECT_GE(std::stoi(late.headers.at("retry-after")), 1);
  held_ = false;
  client.join();
  EXPECT_EQ(metrics_.queued, 0);
}

TEST_F(ServerTest, BoundsTheHead) {
  Start();
  EXPECT_EQ(AnswerTo("GET /" + std::string(9000, 'a') + " HTTP/1.1\r\nHost: t\r\n\r\n").status, 414);
  EXPECT_EQ(AnswerTo("GET /hello HTTP/1.1\r\nHost: t\r\nX: " + std::string(20'000, 'a') + "\r\n\r\n").status, 431);
  std::string many = "GET /hello HTTP/1.1\r\nHost: t\r\n";
  for (int i = 0; i < 5000; ++i) many += "X" + std::to_string(i) + ": y\r\n";
  EXPECT_EQ(AnswerTo(many + "\r\n").status, 431);
  // A line that never ends is cut off too, not collected.
  RawConnection endless(port_);
  const std::string block(64 * 1024, 'a');
  endless.Send("GET /hello HTTP/1.1\r\nHost: t\r\nX: ");
  for (int i = 0; i < 4 && endless.Send(block); ++i) continue;
  const auto response = endless.Read();
  ASSERT_TRUE(response);
  EXPECT_EQ(response->status, 431);
}

TEST_F(ServerTest, AsksForTheBodyOfAClientThatWaits) {
  Start();
  RawConnection connection(port_);
  connection.Send(Post(5, "Expect: 100-continue\r\n"));
  std::this_thread::sleep_for(milliseconds(50));
  connection.Send("later");
  const auto response = connection.Read();
  ASSERT_TRUE(response);
  EXPECT_EQ(response->body, "later");
}

TEST_F(ServerTest, NeverShowsItsInsides) {
  Start();
  ::testing::internal::CaptureStderr();
  for (const std::string path : {"/throw", "/throw-int"}) {
    const RawResponse response = Ask(port_, "GET", path);
    EXPECT_EQ(response.status, 500);
    EXPECT_EQ(response.headers.at("content-type"), "application/problem+json");
    EXPECT_THAT(response.body, Not(HasSubstr("passwd")));
    for (const auto& [name, value] : response.headers) EXPECT_THAT(value, Not(HasSubstr("passwd"))) << name;
  }
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("passwd"));  // the operator does see it
}

TEST_F(ServerTest, TellsWaitingClientsThatItIsBusyAndStaysAlive) {
  ServerOptions options;
  options.threads = 1;
  options.max_queued = 1;
  Start(options);
  std::vector<std::thread> clients;
  std::atomic<int> held = 0;
  for (int i = 0; i < 2; ++i) {
    clients.emplace_back([&] { held += Ask(port_, "GET", "/hold").status == 200; });
    if (i == 0) entered_.wait();
  }
  while (metrics_.queued < 2) std::this_thread::sleep_for(milliseconds(1));
  const RawResponse refused = Ask(port_, "GET", "/items/x");
  EXPECT_EQ(refused.status, 503);
  EXPECT_GE(std::stoi(refused.headers.at("retry-after")), 1);
  EXPECT_EQ(Ask(port_, "GET", "/hello").status, 200);  // immediate routes do not queue
  held_ = false;
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(held, 2);
  EXPECT_EQ(metrics_.refused, 1u);
  EXPECT_EQ(metrics_.queued, 0);
}

TEST_F(ServerTest, RefusesConnectionsPastItsLimit) {
  ServerOptions options;
  options.max_connections = 3;
  Start(options);
  {
    RawConnection a(port_), b(port_), c(port_);
    while (metrics_.connections < 3) std::this_thread::sleep_for(milliseconds(1));
    RawConnection d(port_);
    const auto response = d.Read();
    ASSERT_TRUE(response);
    EXPECT_EQ(response->status, 503);
    EXPECT_TRUE(response->headers.count("retry-after"));
    a.Send("GET /hello HTTP/1.1\r\nHost: t\r\n\r\n");
    EXPECT_EQ(a.Read().value_or(RawResponse{}).body, "hello");
  }
  while (metrics_.connections > 0) std::this_thread::sleep_for(milliseconds(1));
}

TEST_F(ServerTest, SlowClientsHoldNoWorkerAndAreLetGo) {
  ServerOptions options;
  options.head_timeout = std::chrono::seconds(1);
  options.body_timeout = std::chrono::seconds(1);
  options.threads = 1;
  Start(options);
  RawConnection silent(port_), dripping(port_), starving(port_);
  starving.Send(Post(10) + "abc");
  for (int i = 0; i < 14; ++i) {
    dripping.Send(i == 0 ? "GET /hello HTTP/1.1\r\nX: " : "a");
    std::this_thread::sleep_for(milliseconds(100));
    if (i == 3) ExpectStillServes();
  }
  EXPECT_TRUE(silent.IsClosedWithin(1000));
  EXPECT_TRUE(dripping.IsClosedWithin(1000));
  EXPECT_TRUE(starving.IsClosedWithin(1000));
}

TEST_F(ServerTest, BoundsAllLargeBodiesTogether) {
  Router router({{"POST", "/large", [](const HttpRequest& request) { return Text(std::to_string(request.body.size())); },
                  std::size_t{8} << 20}});
  ServerOptions options;
  options.port = 0;
  options.max_body_bytes = std::size_t{12} << 20;
  Server server(router, &metrics_, options);
  const int port = server.Bind();
  std::thread thread([&] { server.Run(); });
  const std::string head = "POST /large HTTP/1.1\r\nHost: t\r\nContent-Length: 8388608\r\n\r\n";
  {
    RawConnection first(port);
    first.Send(head + "x");
    std::this_thread::sleep_for(milliseconds(100));
    RawConnection second(port);
    second.Send(head);
    EXPECT_EQ(second.Read().value_or(RawResponse{}).status, 503);
    first.Send(std::string(8388607, 'x'));
    EXPECT_EQ(first.Read().value_or(RawResponse{}).body, "8388608");
    RawConnection third(port);
    third.Send(head + std::string(8388608, 'x'));
    EXPECT_EQ(third.Read().value_or(RawResponse{}).body, "8388608");
  }
  server.Stop();
  thread.join();
}

TEST_F(ServerTest, StopFinishesWhatIsUnderWay) {
  Start();
  std::optional<RawResponse> answer;
  std::thread client([&] { answer = Ask(port_, "GET", "/hold"); });
  RawConnection idle(port_);
  entered_.wait();
  server_->Stop();
  EXPECT_TRUE(idle.IsClosedWithin(2000));
  held_ = false;
  thread_.join();
  client.join();
  EXPECT_EQ(answer.value_or(RawResponse{}).body, "held");
  EXPECT_THROW(RawConnection late(port_), std::runtime_error);
  server_.reset();
}

TEST_F(ServerTest, TwoServersNeverShareAPort) {
  Start();
  ServerOptions options;
  options.port = port_;
  Server second(router_, &metrics_, options);
  try {
    second.Bind();
    ADD_FAILURE() << "bound the same port";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("127.0.0.1:" + std::to_string(port_)));
  }
}

TEST_F(ServerTest, RefusesChangesAskedByPagesOfOtherSites) {
  Start();
  EXPECT_EQ(Ask(port_, "POST", "/echo", "Sec-Fetch-Site: cross-site\r\n", "x").status, 403);
  EXPECT_EQ(Ask(port_, "POST", "/echo", "Sec-Fetch-Site: same-origin\r\n", "x").status, 200);
  EXPECT_EQ(Ask(port_, "GET", "/hello", "Sec-Fetch-Site: cross-site\r\n").status, 200);
}

TEST_F(ServerTest, RefusesChangesAskedByPagesOfUnknownHosts) {
  ServerOptions options;
  options.page_hosts = {"localhost", "[::1]", "motion.example.org"};
  Start(options);
  const auto status = [&](const std::string& origin) {
    return Ask(port_, "POST", "/echo", "Origin: " + origin + "\r\n", "x").status;
  };
  // A page whose own name was made to lead here is of the same site, to the browser.
  EXPECT_EQ(Ask(port_, "POST", "/echo", "Origin: http://evil.example:8080\r\nSec-Fetch-Site: same-origin\r\n", "x").status, 403);
  for (const char* other : {"http://evil.example", "null", "http://localhost.evil.example", "http://[::2]:8080", "localhost"})
    EXPECT_EQ(status(other), 403) << other;
  for (const char* known : {"http://localhost", "http://LOCALHOST:8080", "http://[::1]:8080", "https://motion.example.org"})
    EXPECT_EQ(status(known), 200) << known;
  EXPECT_EQ(Ask(port_, "POST", "/echo", "", "x").status, 200);  // no browser
  EXPECT_EQ(Ask(port_, "GET", "/hello", "Origin: http://evil.example\r\n").status, 200);
}

TEST_F(ServerTest, CountsByRouteNotByPath) {
  Start();
  for (int i = 0; i < 5; ++i) Ask(port_, "GET", "/items/" + std::to_string(i));
  Ask(port_, "GET", "/stray");
  const std::string text = metrics_.PrometheusText();
  EXPECT_THAT(text, HasSubstr("morphograph_http_requests_total{method=\"GET\",route=\"/items/{name}\",status=\"200\"} 5"));
  EXPECT_THAT(text, HasSubstr("morphograph_http_requests_total{method=\"GET\",route=\"none\",status=\"404\"} 1"));
  EXPECT_THAT(text, HasSubstr("morphograph_http_request_seconds_bucket{route=\"/items/{name}\",le=\"+Inf\"} 5"));
  EXPECT_THAT(text, Not(HasSubstr("stray")));
}

TEST(ServerReadiness, LastsFromRunToStop) {
  const Router router{std::vector<Route>()};
  Metrics metrics;
  std::atomic<bool> ready = false;
  ServerOptions options;
  options.port = 0;
  options.ready = &ready;
  Server server(router, &metrics, options);
  server.Bind();
  EXPECT_FALSE(ready);
  std::thread running([&] { server.Run(); });
  for (int i = 0; i < 1000 && !ready; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_TRUE(ready);
  server.Stop();
  EXPECT_FALSE(ready);  // at once, whatever is still under way
  running.join();
  EXPECT_FALSE(ready);
}

}  // namespace
}  // namespace morphograph
