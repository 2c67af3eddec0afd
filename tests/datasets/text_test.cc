// Text from outside: files, encodings, and what errors say.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "datasets/bvh_reader.h"
#include "datasets/clip_conversion.h"
#include "datasets/error_reason.h"
#include "datasets/errors.h"
#include "datasets/file_text.h"
#include "datasets/text_encoding.h"
#include "tests/datasets/bvh_test_files.h"
#include "tests/support/temporary_folder.h"

namespace morphograph {
namespace {

using ::testing::HasSubstr;

TEST(TextEncoding, KnowsUtf8) {
  for (const char* sound : {"", "plain", "\xC3\xBC", "\xE2\x82\xAC", "\xF0\x9F\x9A\xB6", "\xEF\xBF\xBF", "\xF4\x8F\xBF\xBF"}) {
    EXPECT_TRUE(IsUtf8(sound)) << sound;
    EXPECT_EQ(Utf8FromUnknown(sound), sound);
  }
  for (const char* broken : {"\xFC", "\xC3", "\x80", "\xC0\xAF", "\xE0\x80\xAF", "\xED\xA0\x80", "\xF5\x80\x80\x80", "\xF4\x90\x80\x80",
                             "\xE2\x82", "\xC3(", "\xF0\x9F\x9A"}) {
    EXPECT_FALSE(IsUtf8(broken));
    EXPECT_TRUE(IsUtf8(Utf8FromUnknown(broken)));
  }
  EXPECT_EQ(Utf8FromUnknown("R\xFC""cken \xA9"), "R\xC3\xBC""cken \xC2\xA9");
}

TEST(TextEncoding, JointNamesComeOutAsUtf8AndTheImportSaysSo) {
  std::string text = testing::kSmallBvh;
  text.replace(text.find("LeftFoot"), 8, "LeftFoot_\xE4");
  ClipImportReport report;
  const MotionClip clip = ImportClip(ParseBvh(text, "caf\xE9/b\xF6.bvh"), {}, &report);
  EXPECT_EQ(clip.name, "b\xC3\xB6");
  EXPECT_THAT(report.note, HasSubstr("Latin-1"));
  EXPECT_EQ(clip.skeleton().joint(3).name, "LeftFoot_\xC3\xA4");
}

TEST(ErrorReason, LeavesOutTheFunctionAndNothingElse) {
  const auto reason = [](const char* text) { return ReasonOf(std::invalid_argument(text)); };
  EXPECT_EQ(reason("Retarget: the rest pose is odd"), "the rest pose is odd");
  EXPECT_EQ(reason("TimeWarp::Fit: the path is empty"), "the path is empty");
  EXPECT_EQ(reason("no such joint: x"), "no such joint: x");
  EXPECT_EQ(reason("a.bvh: broken"), "a.bvh: broken");
  EXPECT_EQ(reason("BVH: broken"), "BVH: broken");
}

TEST(FileText, SaysWhyAFileGivesNone) {
  const testing::TemporaryFolder folder;
  EXPECT_EQ(ReadFileText(folder.Write("a", "text\n")), "text\n");
  const auto error_of = [](const std::filesystem::path& path) -> std::string {
    try {
      ReadFileText(path);
    } catch (const DatasetError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(error_of(folder.Write("empty", "")), HasSubstr("empty: is empty"));
  EXPECT_THAT(error_of(folder.path()), HasSubstr("is a folder"));
  EXPECT_THAT(error_of(folder.path() / "none"), HasSubstr("cannot be opened: No such file"));
}

}  // namespace
}  // namespace morphograph
