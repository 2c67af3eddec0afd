#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>

namespace morphograph::testing {

/// A program that runs beside the test; killed at the end if it still does.
class ChildProcess {
 public:
  /// @param command  for the shell, which it replaces: the process told to stop is the program itself.
  explicit ChildProcess(const std::string& command) {
    int ends[2];
    if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
    id_ = ::fork();
    if (id_ < 0) throw std::runtime_error("no process");
    if (id_ == 0) {
      // A test that runs in the background of a script was told to ignore these.
      for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_DFL);
      ::dup2(ends[1], STDOUT_FILENO);
      ::close(ends[0]);
      ::close(ends[1]);
      ::execl("/bin/sh", "sh", "-c", ("exec " + command).c_str(), nullptr);
      ::_exit(127);
    }
    ::close(ends[1]);
    said_ = ::fdopen(ends[0], "r");
  }
  ~ChildProcess() {
    if (id_ > 0) {
      ::kill(id_, SIGKILL);
      Wait();
    }
    std::fclose(said_);
  }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Next line of its standard output; empty when there is none.
  std::string ReadLine() {
    char line[512] = {};
    return std::fgets(line, sizeof line, said_) ? line : "";
  }

  void Signal(int signal) { ::kill(id_, signal); }

  /// Waits for its end. @return the status as waitpid() gives it.
  int Wait() {
    int status = -1;
    while (::waitpid(id_, &status, 0) < 0 && errno == EINTR) continue;
    id_ = -1;
    return status;
  }

  /// The most memory that it has had so far, MiB.
  double PeakMemoryMib() const {
    std::ifstream status("/proc/" + std::to_string(id_) + "/status");
    for (std::string word; status >> word;) {
      double kib = 0;
      if (word == "VmHWM:" && status >> kib) return kib / 1024;
    }
    throw std::runtime_error("the process does not tell its memory");
  }

 private:
  pid_t id_ = -1;
  std::FILE* said_ = nullptr;
};

/// The port in the first line of `morphograph serve`.
inline int ServedPort(ChildProcess* server) {
  const std::string line = server->ReadLine();
  const std::size_t colon = line.rfind(':');
  if (line.find("http://127.0.0.1:") == std::string::npos) throw std::runtime_error("the server said: " + line);
  return std::stoi(line.substr(colon + 1));
}

}  // namespace morphograph::testing
