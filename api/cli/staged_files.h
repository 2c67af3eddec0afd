#pragma once

#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

namespace morphograph {

/// Output files of one command: all of them appear, or none does, and existing ones are replaced only at the end.
///
/// Each is written beside its place under a hidden name and renamed by Commit(); without it, everything is removed again,
/// folders that were made included.
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
  std::vector<std::pair<std::filesystem::path, std::filesystem::path>> files_;  // hidden name, place
};

}  // namespace morphograph
