#include "api/cli/staged_files.h"

#include <system_error>
#include <utility>

#include "datasets/errors.h"

namespace morphograph {

namespace fs = std::filesystem;

StagedFiles::StagedFiles()
    : guard_([this] {
        mutex_.lock();  // for good: nothing may be added any more
        RemoveAll();
      }) {}

StagedFiles::~StagedFiles() {
  const std::lock_guard lock(mutex_);
  RemoveAll();
}

void StagedFiles::RemoveAll() {
  // Devices and pipes are left alone: one may be written to at this moment, and nothing of them lies on disk.
  for (StagedFile& file : files_) {
    if (file.is_renamed()) const StagedFile gone(std::move(file));
  }
  std::error_code ignored;
  for (auto folder = folders_.rbegin(); folder != folders_.rend(); ++folder) fs::remove(*folder, ignored);
}

void StagedFiles::AddFolder(const fs::path& path) {
  const std::lock_guard lock(mutex_);
  MakeFolder(path);
}

void StagedFiles::MakeFolder(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return;
  if (path.has_parent_path() && path.parent_path() != path) MakeFolder(path.parent_path());
  if (!path.has_filename()) return;  // "out/" ends with an empty name
  if (!fs::create_directory(path, error)) {
    throw DatasetError(path.string(), "cannot make the folder: " +
                                          (error ? error.message() : std::string("a file of that name is in the way")));
  }
  folders_.push_back(path);
}

void StagedFiles::Add(const fs::path& path, std::string_view bytes) {
  if (fs::is_directory(path)) throw DatasetError(path.string(), "is a folder, not a file");
  const std::lock_guard lock(mutex_);
  try {
    files_.emplace_back(path, bytes);
  } catch (const DatasetError&) {
    std::error_code error;
    if (!path.parent_path().empty() && !fs::is_directory(path.parent_path(), error))
      throw DatasetError(path.string(), "cannot write: there is no folder " + path.parent_path().string());
    throw;
  }
}

void StagedFiles::Commit() {
  std::vector<StagedFile*> devices;
  for (StagedFile& file : files_) {
    if (!file.is_renamed()) devices.push_back(&file);
  }
  // Not under the lock: a pipe may wait for its reader as long as it likes, and must not hold back an interruption.
  for (StagedFile* device : devices) device->Commit();
  const std::lock_guard lock(mutex_);
  for (StagedFile& file : files_) {
    if (file.is_renamed()) file.Commit();
  }
  files_.clear();
  folders_.clear();
}

}  // namespace morphograph
