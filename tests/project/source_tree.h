#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

namespace morphograph::testing {

struct SourceFile {
  std::string path;  // from the root, '/' between folders
  std::string text;
};

inline std::string ReadWhole(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// Paths from the root of all files that are ours: hidden folders such as .git, builds, output and npm's are left out.
inline std::vector<std::string> ProjectFiles() {
  const std::filesystem::path root = MORPHOGRAPH_SOURCE_DIR;
  std::vector<std::string> paths;
  for (auto entry = std::filesystem::recursive_directory_iterator(root); entry != std::filesystem::end(entry); ++entry) {
    const std::string name = entry->path().filename().string();
    if (name == ".git" || name == "build" || name == "out" || name == "node_modules" || name == ".cache") {
      entry.disable_recursion_pending();
    } else if (entry->is_regular_file()) {
      paths.push_back(entry->path().lexically_relative(root).generic_string());
    }
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

/// The C++ files among them.
inline std::vector<SourceFile> SourceFiles() {
  std::vector<SourceFile> files;
  for (const std::string& path : ProjectFiles()) {
    if (path.ends_with(".h") || path.ends_with(".cc")) {
      files.push_back({path, ReadWhole(std::filesystem::path(MORPHOGRAPH_SOURCE_DIR) / path)});
    }
  }
  return files;
}

/// What a file includes, in order, without quotes or brackets.
inline std::vector<std::string> Includes(std::string_view text) {
  constexpr std::string_view kDirective = "#include";
  std::vector<std::string> includes;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!line.starts_with(kDirective)) continue;
    line.remove_prefix(kDirective.size());
    const std::size_t open = line.find_first_of("<\"");
    if (open == std::string_view::npos) continue;
    line.remove_prefix(open + 1);
    includes.emplace_back(line.substr(0, line.find_first_of(">\"")));
  }
  return includes;
}

}  // namespace morphograph::testing
