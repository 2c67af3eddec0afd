#include "datasets/atomic_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "datasets/errors.h"
#include "tests/support/temporary_folder.h"

namespace morphograph {
namespace {

using ::testing::HasSubstr;

std::string Content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

size_t FilesIn(const std::filesystem::path& folder) {
  const std::filesystem::directory_iterator entries(folder);
  return static_cast<size_t>(std::distance(begin(entries), end(entries)));
}

TEST(WriteFileAtomically, ReplacesKeepsModeAndFollowsLinks) {
  const testing::TemporaryFolder folder;
  const auto file = folder.Write("a.txt", "old");
  ::chmod(file.c_str(), 0640);
  std::filesystem::create_symlink("a.txt", folder.path() / "link.txt");
  WriteFileAtomically(folder.path() / "link.txt", "new");
  EXPECT_EQ(Content(file), "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder.path() / "link.txt"));
  struct stat status;
  ASSERT_EQ(::stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
  WriteFileAtomically(folder.path() / "b.txt", "");
  EXPECT_EQ(Content(folder.path() / "b.txt"), "");
  EXPECT_EQ(FilesIn(folder.path()), 3u);
  WriteFileAtomically("/dev/null", "gone");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(WriteFileAtomically, AFailureLeavesNothingBehindAndNamesTheCause) {
  const testing::TemporaryFolder folder;
  folder.Write("sub/file", "kept");
  for (const auto& [path, cause] : {std::pair{folder.path() / "sub", "Is a directory"},
                                    std::pair{folder.path() / "none" / "x", "No such file or directory"},
                                    std::pair{folder.path() / "sub" / "file" / "x", "Not a directory"}}) {
    try {
      WriteFileAtomically(path, "text");
      ADD_FAILURE() << path;
    } catch (const DatasetError& error) {
      EXPECT_THAT(error.what(), HasSubstr(path.string()));
      EXPECT_THAT(error.what(), HasSubstr(cause));
    }
  }
  EXPECT_EQ(FilesIn(folder.path()), 1u);
  EXPECT_EQ(FilesIn(folder.path() / "sub"), 1u);
  EXPECT_EQ(Content(folder.path() / "sub" / "file"), "kept");
}

TEST(StagedFile, AppearsOnlyWhenItIsCommitted) {
  const testing::TemporaryFolder folder;
  const auto old = folder.Write("a.txt", "old");
  {
    const StagedFile dropped(old, "new"), fresh(folder.path() / "b.txt", "new");
    EXPECT_EQ(Content(old), "old");
    EXPECT_EQ(FilesIn(folder.path()), 3u);
  }
  EXPECT_EQ(FilesIn(folder.path()), 1u);
  StagedFile first(old, "first"), second(old, "second");
  StagedFile moved(std::move(first));
  second.Commit();
  moved.Commit();
  EXPECT_EQ(Content(old), "first");
  EXPECT_EQ(FilesIn(folder.path()), 1u);
}

TEST(StagedFile, MakesTheFileThatALinkPromises) {
  const testing::TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "sub");
  std::filesystem::create_symlink("sub/later.txt", folder.path() / "link.txt");
  WriteFileAtomically(folder.path() / "link.txt", "text");
  EXPECT_TRUE(std::filesystem::is_symlink(folder.path() / "link.txt"));
  EXPECT_EQ(Content(folder.path() / "sub" / "later.txt"), "text");
}

TEST(StagedFile, WritesToPipesAndLeavesThemBe) {
  const testing::TemporaryFolder folder;
  const std::filesystem::path pipe = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  StagedFile file(pipe, "through");
  EXPECT_FALSE(file.is_renamed());
  file.Commit();
  char text[16] = {};
  EXPECT_EQ(::read(reader, text, sizeof text), 7);
  EXPECT_STREQ(text, "through");
  ::close(reader);
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
  EXPECT_EQ(FilesIn(folder.path()), 1u);
}

TEST(IsSameFile, LooksBehindNames) {
  const testing::TemporaryFolder folder;
  const std::filesystem::path a = folder.Write("a", ""), sub = folder.path() / "sub";
  std::filesystem::create_directory(sub);
  std::filesystem::create_symlink("later", folder.path() / "link");
  EXPECT_TRUE(IsSameFile(a, sub / ".." / "a"));
  EXPECT_TRUE(IsSameFile(folder.path() / "link", folder.path() / "later"));
  EXPECT_TRUE(IsSameFile(folder.path() / "none" / "x", folder.path() / "none" / "." / "x"));
  EXPECT_FALSE(IsSameFile(a, folder.path() / "b"));
  EXPECT_FALSE(IsSameFile("/dev/null", "/dev/null"));
}

}  // namespace
}  // namespace morphograph
