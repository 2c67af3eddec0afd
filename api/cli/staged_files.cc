#include "api/cli/staged_files.h"

#include <system_error>

#include "datasets/errors.h"

namespace morphograph {

namespace fs = std::filesystem;

StagedFiles::~StagedFiles() {
  std::error_code ignored;
  files_.clear();
  for (auto folder = folders_.rbegin(); folder != folders_.rend(); ++folder) fs::remove(*folder, ignored);
}

void StagedFiles::AddFolder(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return;
  if (path.has_parent_path() && path.parent_path() != path) AddFolder(path.parent_path());
  if (!path.has_filename()) return;  // "out/" ends with an empty name
  if (!fs::create_directory(path, error)) {
    throw DatasetError(path.string(), "cannot make the folder: " +
                                          (error ? error.message() : std::string("a file of that name is in the way")));
  }
  folders_.push_back(path);
}

void StagedFiles::Add(const fs::path& path, std::string_view bytes) {
  if (fs::is_directory(path)) throw DatasetError(path.string(), "is a folder, not a file");
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
  for (const bool renamed : {false, true}) {
    for (StagedFile& file : files_) {
      if (file.is_renamed() == renamed) file.Commit();
    }
  }
  files_.clear();
  folders_.clear();
}

}  // namespace morphograph
