// Runs a fuzz harness without libFuzzer: first every seed of a folder as it stands, then mutated seeds from a fixed
// generator. The input that ended the process is left in the file `crash-<run>`, and `NAME crash-<run>` repeats it.

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/random/uniform_int_distribution.hpp>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

constexpr std::size_t kMaxInputBytes = 1 << 16;
// No input of a few kilobytes may need more memory than this, sanitizers' own included.
constexpr long kMostMemory_kB = 1'000'000;

// What parsers trip over: numbers at the edges of their types, openers without closers, odd bytes.
constexpr std::array<std::string_view, 24> kTokens = {
    "0",     "-1",    "1e309", "-1e-400", "nan",    "inf",       "2147483648", "18446744073709551616",
    "1e",    ".",     "{",     "}",       "[[[[[[", "\"",        "\\u0000",    "\xEF\xBB\xBF",
    "\r\n",  "\t",    "null",  "true",    "JOINT",  "CHANNELS ", "End Site",   "999999999"};

std::string current_input;
long current_run = 0;

// Only async-signal-safe calls: the heap may be what is broken.
void SaveInputAndDie(int signal) {
  char name[32] = "crash-";
  int at = 6;
  for (long digits = std::max(1L, current_run); digits > 0 && at < 30; digits /= 10) {
    name[at++] = static_cast<char>('0' + digits % 10);
  }
  std::reverse(name + 6, name + at);
  const int file = open(name, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file >= 0) {
    if (write(file, current_input.data(), current_input.size()) < 0) _exit(2);
    close(file);
  }
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void Run(std::string input) {
  current_input = std::move(input);
  ++current_run;
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(current_input.data()), current_input.size());
  struct rusage usage;
  if (getrusage(RUSAGE_SELF, &usage) == 0 && usage.ru_maxrss > kMostMemory_kB) {
    std::fprintf(stderr, "violated: %ld kB of memory\n", usage.ru_maxrss);
    std::abort();
  }
}

std::vector<std::string> ReadSeeds(const std::vector<std::filesystem::path>& paths) {
  std::vector<std::filesystem::path> files;
  for (const auto& path : paths) {
    if (std::filesystem::is_directory(path)) {
      for (const auto& entry : std::filesystem::directory_iterator(path)) files.push_back(entry.path());
    } else {
      files.push_back(path);
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> seeds;
  for (const auto& file : files) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) {
      std::fprintf(stderr, "cannot read %s\n", file.c_str());
      std::exit(2);
    }
    seeds.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return seeds;
}

class Mutator {
 public:
  Mutator(const std::vector<std::string>& seeds, std::uint64_t seed) : seeds_(seeds), rng_(seed) {}

  std::string Next() {
    std::string text = seeds_[Below(seeds_.size())];
    const std::size_t changes = 1 + Below(6);
    for (std::size_t i = 0; i < changes; ++i) Change(&text);
    if (text.size() > kMaxInputBytes) text.resize(kMaxInputBytes);
    return text;
  }

 private:
  std::size_t Below(std::size_t count) {
    return boost::random::uniform_int_distribution<std::size_t>(0, count - 1)(rng_);
  }

  void Change(std::string* text) {
    const std::size_t at = Below(text->size() + 1);
    const std::size_t length = std::min(text->size() - at, 1 + Below(40));
    switch (Below(8)) {
      case 0:
        if (at < text->size()) (*text)[at] = static_cast<char>((*text)[at] ^ (1 << Below(8)));
        break;
      case 1:
        if (at < text->size()) (*text)[at] = static_cast<char>(Below(256));
        break;
      case 2:
        text->erase(at, length);
        break;
      case 3:
        text->insert(at, std::string(*text, at, length));
        break;
      case 4:
        text->replace(at, std::min<std::size_t>(length, 1 + Below(4)), kTokens[Below(kTokens.size())]);
        break;
      case 5:
        text->insert(at, kTokens[Below(kTokens.size())]);
        break;
      case 6:
        text->resize(at);
        break;
      default: {
        const std::string& other = seeds_[Below(seeds_.size())];
        const std::size_t from = Below(other.size() + 1);
        text->insert(at, other, from, 1 + Below(400));
      }
    }
  }

  const std::vector<std::string>& seeds_;
  std::mt19937_64 rng_;
};

}  // namespace

int main(int argc, char** argv) {
  long runs = 0;
  long seconds = 10;
  std::uint64_t seed = 1;
  std::vector<std::filesystem::path> paths;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.starts_with("--runs=")) {
      runs = std::stol(argument.substr(7));
    } else if (argument.starts_with("--seconds=")) {
      seconds = std::stol(argument.substr(10));
    } else if (argument.starts_with("--seed=")) {
      seed = std::stoull(argument.substr(7));
    } else {
      paths.emplace_back(argument);
    }
  }
  const std::vector<std::string> seeds = ReadSeeds(paths);
  if (seeds.empty()) {
    std::fprintf(stderr, "usage: %s [--runs=N] [--seconds=S] [--seed=N] seed files or folders\n", argv[0]);
    return 2;
  }
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL}) std::signal(signal, SaveInputAndDie);

  for (const std::string& text : seeds) Run(text);
  Mutator mutator(seeds, seed);
  const auto stop = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
  while (current_run < runs && std::chrono::steady_clock::now() < stop) Run(mutator.Next());
  std::printf("%ld inputs, %zu of them seeds\n", current_run, seeds.size());
  return 0;
}
