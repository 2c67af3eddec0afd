#pragma once

#include <filesystem>
#include <string>

namespace morphograph {

/// The bytes of a file, or of a pipe until it ends.
/// @throws DatasetError naming the path: it cannot be opened or read (with the system's reason), is a folder, or is empty.
std::string ReadFileText(const std::filesystem::path& path);

}  // namespace morphograph
