#include "datasets/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "datasets/errors.h"

namespace morphograph {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(const fs::path& path, const char* what, int error) {
  throw DatasetError(path.string(), std::string(what) + ": " + std::strerror(error));
}

// 0 or the system's error.
int WriteAll(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return errno;
    }
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return 0;
}

// A link may lead to a file that is still to be made, which std::filesystem::canonical() would refuse.
fs::path BehindLinks(fs::path path) {
  constexpr int kMostLinks = 40;  // as the system counts them
  std::error_code error;
  for (int i = 0; i < kMostLinks && fs::is_symlink(fs::symlink_status(path, error)); ++i) {
    const fs::path target = fs::read_symlink(path, error);
    if (error) break;
    path = path.parent_path() / target;
  }
  return path;
}

bool IsPlainOrAbsent(const fs::file_status& status) { return !fs::exists(status) || fs::is_regular_file(status); }

}  // namespace

StagedFile::StagedFile(const fs::path& path, std::string_view bytes) : path_(path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) Fail(path, "cannot be written", EISDIR);
  if (!IsPlainOrAbsent(status)) {
    place_ = path;
    bytes_ = bytes;
    return;
  }
  place_ = BehindLinks(path);
  // A short name of our own: two writers of one file never share it, and it fits wherever the file's name fits.
  static std::atomic<unsigned> counter = 0;
  fs::path hidden;
  int file = -1;
  do {
    hidden = place_.parent_path() /
             (".morphograph-" + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".partial");
    file = ::open(hidden.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (file < 0 && errno == EEXIST);
  if (file < 0) Fail(path, "cannot be created", errno);
  int failure = WriteAll(file, bytes);
  struct stat existing;
  if (!failure && ::stat(place_.c_str(), &existing) == 0 && ::fchmod(file, existing.st_mode & 07777) != 0) {
    failure = errno;
  }
  if (!failure && ::fsync(file) != 0) failure = errno;
  if (::close(file) != 0 && !failure) failure = errno;
  if (failure) {
    ::unlink(hidden.c_str());
    Fail(path, "cannot be written", failure);
  }
  hidden_ = std::move(hidden);
}

StagedFile::StagedFile(StagedFile&& other) noexcept
    : path_(std::move(other.path_)),
      place_(std::move(other.place_)),
      hidden_(std::exchange(other.hidden_, {})),
      bytes_(std::move(other.bytes_)) {}

StagedFile::~StagedFile() {
  if (!hidden_.empty()) ::unlink(hidden_.c_str());
}

void StagedFile::Commit() {
  if (is_renamed()) {
    if (::rename(hidden_.c_str(), place_.c_str()) != 0) Fail(path_, "cannot be written", errno);
    hidden_.clear();
    return;
  }
  const int file = ::open(place_.c_str(), O_WRONLY | O_CLOEXEC);
  if (file < 0) Fail(path_, "cannot be opened", errno);
  int failure = WriteAll(file, bytes_);
  if (::close(file) != 0 && !failure) failure = errno;
  if (failure) Fail(path_, "cannot be written", failure);
}

void WriteFileAtomically(const fs::path& path, std::string_view bytes) { StagedFile(path, bytes).Commit(); }

bool IsSameFile(const fs::path& a, const fs::path& b) {
  std::error_code error;
  if (!IsPlainOrAbsent(fs::status(a, error)) || !IsPlainOrAbsent(fs::status(b, error))) return false;
  const auto place = [](const fs::path& path) {
    std::error_code ignored;
    const fs::path absolute = fs::absolute(path, ignored);
    const fs::path known = fs::weakly_canonical(BehindLinks(absolute), ignored);
    return ignored ? absolute.lexically_normal() : known;
  };
  return place(a) == place(b);
}

}  // namespace morphograph
