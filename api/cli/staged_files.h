#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "datasets/atomic_file.h"

namespace morphograph {

/// Output files of one command. All of them are complete on disk before the first is put in its place; until then a failure changes
/// nothing.
///
/// Each waits as a StagedFile for Commit(), which writes to devices and pipes first, since they can still fail, and then renames. Without
/// Commit(), everything is removed again, folders that were made included.
class StagedFiles {
 public:
  StagedFiles() = default;
  ~StagedFiles();
  StagedFiles(const StagedFiles&) = delete;
  StagedFiles& operator=(const StagedFiles&) = delete;

  /// Makes a folder, parents included, unless it is there. @throws DatasetError
  void AddFolder(const std::filesystem::path& path);
  /// @throws DatasetError naming the path and the system's reason.
  void Add(const std::filesystem::path& path, std::string_view bytes);
  void Commit();

 private:
  std::vector<std::filesystem::path> folders_;  // made here, outermost first
  std::vector<StagedFile> files_;
};

}  // namespace morphograph
