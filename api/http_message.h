#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace morphograph {

/// What a handler that works for long asks of its server between the parts of its work, so that others come to theirs and nobody works
/// for a client that has gone. Safe from any thread.
class LongWork {
 public:
  enum class Stop {
    kNone,
    kGone,      // the client has closed its side
    kStopping,  // the server is told to stop
    kLate,      // it has taken as long as any request may
  };
  virtual ~LongWork() = default;

  /// How many workers the handler may use at a time: 0 is the handler's own thread, the others are threads that it starts.
  virtual int workers() const = 0;
  /// Waits until a worker may do the next part; others' requests come first if they waited before. False: stop, see stop().
  virtual bool TakeTurn(int worker) = 0;
  /// Due after each TakeTurn() that gave true.
  virtual void EndTurn(int worker) = 0;
  virtual Stop stop() const = 0;
};

/// A request as handlers see it: already framed, bounded and routed.
struct HttpRequest {
  std::string method;  // "GET", …; HEAD arrives as GET
  std::string path;    // as sent, without the query
  std::vector<std::pair<std::string, std::string>> headers;
  std::string body;
  /// Of a body that is still being sent (Route::live_type): what comes next, once there is any, and "" at the end. `body` holds what came first, a line at
  /// least. May be called while the answer goes out, from HttpResponse::more. @throws ProblemError for a body that is cut short or not well formed.
  std::function<std::string()> incoming = {};
  std::vector<std::string> arguments;  // what the route's {…} stand for, percent-decoded
  LongWork* work = nullptr;  // none where nobody waits for turns (tests)

  /// First header of that name, whatever its case; empty when absent.
  std::string_view Header(std::string_view name) const;
};

struct HttpResponse {
  int status = 200;
  std::vector<std::pair<std::string, std::string>> headers;  // Content-Length, Date and Connection are the server's
  std::string body;
  /// Where it is set, the body comes piece by piece in place of `body`: called again and again, until a piece is empty. After the handler
  /// has returned; an answer whose pieces are dear should have made them before.
  std::function<std::string()> more;

  void Set(std::string name, std::string value) { headers.emplace_back(std::move(name), std::move(value)); }
  std::string_view Header(std::string_view name) const;
};

/// ASCII comparison without case, whatever the locale.
bool EqualsIgnoringCase(std::string_view a, std::string_view b);

}  // namespace morphograph
