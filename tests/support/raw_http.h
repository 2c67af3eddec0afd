#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cctype>
#include <chrono>
#include <cstdlib>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace morphograph::testing {

/// How long an answer is waited for: a bound on what hangs, which leaves a sanitizer its time.
inline constexpr int kPatience_ms = 180'000;

/// An answer as it came over the wire; header names in lower case.
struct RawResponse {
  int status = 0;
  std::map<std::string, std::string> headers;
  std::string body;
};

/// A plain TCP connection to the loopback: sends exactly the bytes given, right or wrong.
class RawConnection {
 public:
  explicit RawConnection(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      ::close(socket_);
      throw std::runtime_error("cannot connect");
    }
  }
  ~RawConnection() { ::close(socket_); }
  RawConnection(const RawConnection&) = delete;
  RawConnection& operator=(const RawConnection&) = delete;

  /// False when the other side has closed.
  bool Send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }

  /// Reads one whole answer; empty when the connection ends or `timeout_ms` passes first.
  std::optional<RawResponse> Read(int timeout_ms = kPatience_ms, bool head_only = false) {
    std::size_t end;
    while ((end = pending_.find("\r\n\r\n")) == std::string::npos)
      if (!Fill(timeout_ms)) return std::nullopt;
    RawResponse response = ParseHead(pending_.substr(0, end + 2));
    pending_.erase(0, end + 4);
    if (response.status == 100) return Read(timeout_ms, head_only);
    const auto length = response.headers.find("content-length");
    if (const auto coding = response.headers.find("transfer-encoding"); coding != response.headers.end() && coding->second == "chunked") {
      if (!ReadChunks(timeout_ms, &response.body)) return std::nullopt;
      return response;
    }
    std::size_t wanted = length == response.headers.end() ? 0 : std::strtoull(length->second.c_str(), nullptr, 10);
    if (head_only) wanted = 0;
    while (pending_.size() < wanted)
      if (!Fill(timeout_ms)) return std::nullopt;
    response.body = pending_.substr(0, wanted);
    pending_.erase(0, wanted);
    return response;
  }

  /// Reads on until `text` has come; what was found, or else all that came.
  std::string ReadSome(const std::string& text, int timeout_ms = kPatience_ms) {
    while (pending_.find(text) == std::string::npos)
      if (!Fill(timeout_ms)) return pending_;
    return text;
  }

  /// Whether the other side closes within the time, with nothing more to read, or with `text` in what was still to be read.
  bool IsClosedWithin(int timeout_ms, const std::string& text = {}) {
    while (Fill(timeout_ms)) continue;
    return closed_ && (text.empty() ? pending_.empty() : pending_.find(text) != std::string::npos);
  }

 private:
  bool Fill(int timeout_ms) {
    pollfd waiting{socket_, POLLIN, 0};
    if (::poll(&waiting, 1, timeout_ms) <= 0) return false;
    char buffer[65536];
    const ssize_t got = ::recv(socket_, buffer, sizeof buffer, 0);
    if (got <= 0) {
      closed_ = true;
      return false;
    }
    pending_.append(buffer, static_cast<std::size_t>(got));
    return true;
  }

  bool ReadChunks(int timeout_ms, std::string* body) {
    while (true) {
      std::size_t line_end;
      while ((line_end = pending_.find("\r\n")) == std::string::npos)
        if (!Fill(timeout_ms)) return false;
      const std::size_t size = std::strtoull(pending_.c_str(), nullptr, 16);
      while (pending_.size() < line_end + 2 + size + 2)
        if (!Fill(timeout_ms)) return false;
      body->append(pending_, line_end + 2, size);
      pending_.erase(0, line_end + 2 + size + 2);
      if (size == 0) return true;
    }
  }

  static RawResponse ParseHead(const std::string& head) {
    RawResponse response;
    response.status = std::atoi(head.c_str() + std::string_view("HTTP/1.1 ").size());
    for (std::size_t at = head.find("\r\n") + 2; at < head.size();) {
      const std::size_t line_end = head.find("\r\n", at);
      const std::string line = head.substr(at, line_end - at);
      const std::size_t colon = line.find(": ");
      std::string name = line.substr(0, colon);
      for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      if (colon != std::string::npos) response.headers[name] = line.substr(colon + 2);
      at = line_end + 2;
    }
    return response;
  }

  int socket_;
  bool closed_ = false;
  std::string pending_;
};

/// One request on a connection of its own. `headers` are whole lines, each ended by CRLF.
inline RawResponse Ask(int port, const std::string& method, const std::string& target, const std::string& headers = "",
                       const std::string& body = "") {
  RawConnection connection(port);
  std::string text = method + " " + target + " HTTP/1.1\r\nHost: test\r\nConnection: close\r\n" + headers;
  if (!body.empty()) text += "Content-Length: " + std::to_string(body.size()) + "\r\n";
  connection.Send(text + "\r\n" + body);
  return connection.Read(kPatience_ms, method == "HEAD").value_or(RawResponse{});
}

}  // namespace morphograph::testing
