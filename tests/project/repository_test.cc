// What may be in the repository: no recordings, nothing large, nothing that names the machine it was made on.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>

#include "tests/project/source_tree.h"

namespace morphograph::testing {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::uintmax_t kLargestFileBytes = 2 << 20;

// Motion capture in any of its usual formats; seeds of the fuzzers and golden clips are made by hand or by the program.
bool LooksLikeARecording(std::string_view path) {
  for (const std::string_view ending : {".bvh", ".c3d", ".trc", ".amc", ".asf", ".fbx", ".mvnx"}) {
    if (path.ends_with(ending)) {
      return !path.starts_with("tests/fuzz/corpus/") && !path.starts_with("tests/golden/");
    }
  }
  return false;
}

// Names of places that exist on one machine only. Written in two parts, so that this file does not hold them.
std::vector<std::string> MachineNames(std::string_view text) {
  static const std::vector<std::string> words = {
      std::string("/work") + "/",          std::string("/ro") + "ot/",         std::string("/home") + "/",
      std::string("registry.npm") + "js", std::string("deb.deb") + "ian.org", std::string("\"reso") + "lved\":",
      std::string("artifact-") + "registry"};
  std::vector<std::string> found;
  for (const std::string& word : words) {
    if (text.find(word) != std::string_view::npos) found.push_back(word);
  }
  return found;
}

// Whether `text` holds `name` as a whole file name.
bool Names(std::string_view text, std::string_view name) {
  for (std::size_t at = text.find(name); at != std::string_view::npos; at = text.find(name, at + 1)) {
    if (at == 0 || std::string_view(" \n/").find(text[at - 1]) != std::string_view::npos) return true;
  }
  return false;
}

std::string Text(const std::string& path) {
  return ReadWhole(std::filesystem::path(MORPHOGRAPH_SOURCE_DIR) / path);
}

TEST(Repository, HoldsNoLargeFile) {
  for (const std::string& path : ProjectFiles()) {
    // A model is measured in its own test; it may take up to 5 MB.
    const std::uintmax_t limit = path.starts_with("datasets/models/") ? 5 << 20 : kLargestFileBytes;
    EXPECT_LE(std::filesystem::file_size(std::filesystem::path(MORPHOGRAPH_SOURCE_DIR) / path), limit) << path;
  }
}

TEST(Repository, HoldsNoRecording) {
  for (const std::string& path : ProjectFiles()) EXPECT_FALSE(LooksLikeARecording(path)) << path;
}

TEST(Repository, NamesNoMachine) {
  for (const std::string& path : ProjectFiles()) EXPECT_THAT(MachineNames(Text(path)), IsEmpty()) << path;
}

TEST(Repository, ChecksSeeWhatTheyLookFor) {
  EXPECT_TRUE(LooksLikeARecording("datasets/walk.bvh"));
  EXPECT_FALSE(LooksLikeARecording("tests/golden/walk.bvh"));
  std::string named = "see /work";  // in parts, for this file is looked at too
  named.append("/data, or /home").append("/me");
  EXPECT_THAT(MachineNames(named), SizeIs(2));
  EXPECT_THAT(MachineNames("see the network/homepage"), IsEmpty());
  EXPECT_TRUE(Names("add_library(x\n  internal/a.cc\n)", "a.cc"));
  EXPECT_FALSE(Names("add_library(x\n  ba.cc\n)", "a.cc"));
}

// Relative links of a Markdown text, `#...` taken off.
std::vector<std::string> Links(std::string_view text) {
  std::vector<std::string> links;
  for (std::size_t at = text.find("]("); at != std::string_view::npos; at = text.find("](", at + 1)) {
    std::string_view link = text.substr(at + 2);
    link = link.substr(0, link.find_first_of(")#"));
    if (!link.empty() && link.find("://") == std::string_view::npos) links.emplace_back(link);
  }
  return links;
}

TEST(Repository, LinksInDocumentsLead) {
  EXPECT_THAT(Links("[a](b/c.md#d) [e](https://f.org) [g](#h)"), ::testing::ElementsAre("b/c.md"));
  for (const std::string& path : ProjectFiles()) {
    if (!path.ends_with(".md")) continue;
    const auto folder = (std::filesystem::path(MORPHOGRAPH_SOURCE_DIR) / path).parent_path();
    for (const std::string& link : Links(Text(path))) {
      EXPECT_TRUE(std::filesystem::exists(folder / link)) << path << " links to " << link;
    }
  }
}

// A source that no CMakeLists.txt names is compiled nowhere, and its tests never run.
TEST(Repository, EverySourceIsBuilt) {
  std::string lists;
  const std::vector<std::string> paths = ProjectFiles();
  for (const std::string& path : paths) {
    if (path.ends_with("CMakeLists.txt")) lists += Text(path);
  }
  for (const std::string& path : paths) {
    if (!path.ends_with(".cc")) continue;
    EXPECT_TRUE(Names(lists, path.substr(path.rfind('/') + 1))) << path;
  }
}

}  // namespace
}  // namespace morphograph::testing
