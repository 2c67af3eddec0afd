#pragma once

#include <filesystem>
#include <mutex>
#include <string_view>
#include <vector>

#include "api/cli/interrupt_guard.h"
#include "datasets/atomic_file.h"

namespace morphograph {

/// Output files of one command. All of them are complete on disk before the first is put in its place; until then a failure changes
/// nothing.
///
/// Each waits as a StagedFile for Commit(), which writes to devices and pipes first, since they can still fail, and then renames. Without
/// Commit(), everything is removed again, folders that were made included; SIGINT, SIGTERM and SIGHUP end the process no sooner than that.
class StagedFiles {
 public:
  StagedFiles();
  ~StagedFiles();
  StagedFiles(const StagedFiles&) = delete;
  StagedFiles& operator=(const StagedFiles&) = delete;

  /// Makes a folder, parents included, unless it is there. @throws DatasetError
  void AddFolder(const std::filesystem::path& path);
  /// @throws DatasetError naming the path and the system's reason.
  void Add(const std::filesystem::path& path, std::string_view bytes);
  void Commit();

 private:
  void MakeFolder(const std::filesystem::path& path);
  void RemoveAll();

  std::mutex mutex_;  // held while files come and go, so that an interruption falls between two steps
  std::vector<std::filesystem::path> folders_;  // made here, outermost first
  std::vector<StagedFile> files_;
  InterruptGuard guard_;  // last: its thread uses what stands above
};

}  // namespace morphograph
