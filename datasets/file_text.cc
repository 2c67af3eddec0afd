#include "datasets/file_text.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "datasets/errors.h"

namespace morphograph {

std::string ReadFileText(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) throw DatasetError(path.string(), "is a folder, not a file");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw DatasetError(path.string(), std::string("cannot be opened: ") + std::strerror(errno ? errno : EIO));
  }
  std::string text;
  file.seekg(0, std::ios::end);
  if (const std::streamoff size = file.tellg(); size > 0) text.reserve(static_cast<size_t>(size));
  file.clear();
  file.seekg(0, std::ios::beg);
  file.clear();  // a pipe cannot seek but reads
  std::array<char, 1 << 16> block;
  while (file.read(block.data(), block.size()) || file.gcount() > 0) {
    text.append(block.data(), static_cast<size_t>(file.gcount()));
  }
  if (file.bad()) throw DatasetError(path.string(), "cannot be read");
  if (text.empty()) throw DatasetError(path.string(), "is empty");
  return text;
}

}  // namespace morphograph
