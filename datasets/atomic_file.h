#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace morphograph {

/// New content of a file, complete on disk but not yet in its place: Commit() puts it there, else it goes away again.
///
/// It waits beside its place under a hidden name, and a rename replaces what is there, so that a failure leaves no partial file and an existing
/// one whole. A symbolic link stays, the file behind it is replaced; an existing file keeps its mode. What is no file (a device, a
/// pipe, a socket) is never replaced: it is written to by Commit().
class StagedFile {
 public:
  /// @throws DatasetError naming `path` and the system's reason.
  StagedFile(const std::filesystem::path& path, std::string_view bytes);
  ~StagedFile();
  StagedFile(StagedFile&& other) noexcept;
  StagedFile& operator=(StagedFile&&) = delete;

  /// Whether a rename makes it appear: then Commit() hardly fails any more.
  bool is_renamed() const { return !hidden_.empty(); }

  /// @throws DatasetError naming the path and the system's reason.
  void Commit();

 private:
  std::filesystem::path path_;    // as given
  std::filesystem::path place_;   // behind links
  std::filesystem::path hidden_;  // empty: nothing waits on disk
  std::string bytes_;             // of what is no file
};

/// One StagedFile, committed.
void WriteFileAtomically(const std::filesystem::path& path, std::string_view bytes);

/// Whether two paths mean one file, so that the second would replace the first. Never for devices and pipes, which take both. Neither
/// need exist.
bool IsSameFile(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace morphograph
