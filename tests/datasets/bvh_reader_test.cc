#include "datasets/bvh_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <clocale>
#include <locale>

#include "datasets/bvh_writer.h"
#include "datasets/errors.h"
#include "tests/datasets/bvh_test_files.h"
#include "tests/support/temporary_folder.h"

namespace morphograph {
namespace {

using ::testing::HasSubstr;
using testing::kSmallBvh;

std::string BvhError(std::string_view text, const BvhLimits& limits = {}) {
  try {
    ParseBvh(text, "f.bvh", limits);
  } catch (const DatasetError& error) {
    return error.what();
  }
  return "";
}

std::string Replaced(std::string text, const std::string& from, const std::string& to, bool all = false) {
  size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  while (at != std::string::npos) {
    text.replace(at, from.size(), to);
    at = all ? text.find(from, at + to.size()) : std::string::npos;
  }
  return text;
}

// A chain of joints with one channel each, `frames` rows.
std::string Chain(int joints, int frames) {
  std::string text = "HIERARCHY\n";
  for (int j = 0; j < joints; ++j) {
    text += (j == 0 ? "ROOT j" : "JOINT j") + std::to_string(j) + " { OFFSET 0 1 0 CHANNELS 1 Xrotation\n";
  }
  text += std::string(static_cast<size_t>(joints), '}') + "\nMOTION\nFrames: " + std::to_string(frames) +
          "\nFrame Time: 0.01\n";
  for (int f = 0; f < frames; ++f) {
    for (int j = 0; j < joints; ++j) text += "1 ";
    text += "\n";
  }
  return text;
}

// A root with `joints - 1` children.
std::string Star(int joints) {
  std::string text = "HIERARCHY\nROOT j0 { OFFSET 0 1 0 CHANNELS 1 Xrotation\n";
  for (int j = 1; j < joints; ++j) text += " JOINT j" + std::to_string(j) + " { OFFSET 0 1 0 }\n";
  return text + "}\nMOTION\nFrames: 0\nFrame Time: 0.01\n";
}

void ExpectSame(const BvhDocument& a, const BvhDocument& b) {
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (size_t i = 0; i < a.nodes.size(); ++i) {
    EXPECT_EQ(a.nodes[i].name, b.nodes[i].name);
    EXPECT_EQ(a.nodes[i].parent, b.nodes[i].parent);
    EXPECT_EQ(a.nodes[i].channels, b.nodes[i].channels);
    EXPECT_EQ(a.nodes[i].first_channel, b.nodes[i].first_channel);
    EXPECT_TRUE(a.nodes[i].offset == b.nodes[i].offset);
    EXPECT_EQ(a.nodes[i].end_site.has_value(), b.nodes[i].end_site.has_value());
  }
  EXPECT_EQ(a.frame_time_s, b.frame_time_s);
  EXPECT_TRUE(a.values == b.values);
}

TEST(BvhReader, ReadsHierarchyAndValues) {
  const BvhDocument document = ParseBvh(kSmallBvh, "small.bvh");
  ASSERT_EQ(document.nodes.size(), 6u);
  EXPECT_EQ(document.nodes[3].name, "LeftFoot");
  EXPECT_EQ(document.nodes[3].parent, 2);
  EXPECT_EQ(document.nodes[4].parent, 0);
  EXPECT_EQ(document.nodes[4].first_channel, 13);
  EXPECT_EQ(document.nodes[3].channels,
            (std::vector<Channel>{Channel::kYRotation, Channel::kZRotation, Channel::kXRotation}));
  EXPECT_EQ(*document.nodes[3].end_site, Eigen::Vector3d(0, -6, 14));
  EXPECT_FALSE(document.nodes[5].end_site);
  EXPECT_EQ(document.channel_count(), 22);
  EXPECT_EQ(document.frame_count(), 3);
  EXPECT_EQ(document.frame_time_s, 0.0083333);
  EXPECT_EQ(document.values(1, 2), 97);
  EXPECT_EQ(document.values(21, 0), 9);
  EXPECT_EQ(document.source, "small.bvh");
}

TEST(BvhReader, TakesTheDialectsOfTheWild) {
  const BvhDocument plain = ParseBvh(kSmallBvh, "small.bvh");
  const std::string text = kSmallBvh;
  for (const std::string& variant : {
           Replaced(text, "\n", "\r\n", true),
           Replaced(text, "\n", "\r", true),
           "\xEF\xBB\xBF" + text,
           Replaced(text, " ", "\t", true),
           Replaced(text, " ", "   ", true),
           Replaced(text, "Frames: 3", "Frames : 3"),
           Replaced(text, "Frames: 3", "Frames:3"),
           Replaced(text, "Frames: 3", "FRAMES:   +3"),
           Replaced(text, "Frame Time: 0.0083333", "Frame Time :+8.3333e-3"),
           Replaced(text, "Frame Time: 0.0083333", "Frame Time: .0083333"),
           Replaced(text, "\n1 95 2 ", "\n+1.0 9.5E1 20.e-1 "),
           Replaced(text, "\n1 95 2 ", "\n1 95\n2 "),
           Replaced(text, "End Site", "End effector"),
           Replaced(text, "HIERARCHY", "hierarchy"),
           Replaced(text, "CHANNELS", "Channels", true),
           Replaced(text, "ROOT Hips\n{", "ROOT Hips {"),
           Replaced(text, "OFFSET 99 99 99\n    CHANNELS 6 Xposition Yposition Zposition Yrotation Xrotation Zrotation",
                    "CHANNELS 6 xposition YPOSITION Zposition Yrotation Xrotation Zrotation OFFSET 99 99 99"),
           text + "\n\n \t\r\n",
       }) {
    SCOPED_TRACE(variant.substr(0, 400));
    ExpectSame(plain, ParseBvh(variant, "small.bvh"));
  }
}

TEST(BvhReader, KeepsBlanksInNamesAndMakesNamesUnique) {
  std::string text = Replaced(kSmallBvh, "JOINT LeftLeg", "JOINT  Bip01 L Calf ");
  text = Replaced(text, "JOINT LeftFoot", "JOINT Hips");
  text = Replaced(text, "JOINT RightUpLeg", "JOINT Hips_2");
  text = Replaced(text, "JOINT RightFoot", "JOINT Hips");
  const BvhDocument document = ParseBvh(text, "f.bvh");
  EXPECT_EQ(document.nodes[2].name, "Bip01 L Calf");
  EXPECT_EQ(document.nodes[3].name, "Hips_3");
  EXPECT_EQ(document.nodes[4].name, "Hips_2");
  EXPECT_EQ(document.nodes[5].name, "Hips_4");
  ExpectSame(document, ParseBvh(WriteBvh(document), "f.bvh"));
}

TEST(BvhReader, SaysWhatIsWrongAndWhere) {
  const std::string text = kSmallBvh;
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "f.bvh:1:1: the file is empty"},
      {" \r\n\t\n", "the file is empty"},
      {"\xFF\xFEH", "f.bvh:1:1: the text is UTF-16"},
      {"<html>", "f.bvh:1:1: expected 'HIERARCHY', found '<html>'"},
      {Replaced(text, "ROOT Hips", "ROOT "), "f.bvh:2:1: a joint without a name"},
      {Replaced(text, "\n{", "\n"), "f.bvh:4:3: expected '{', found 'OFFSET'"},
      {Replaced(text, "OFFSET 0 0 0", "OFFSET 0 0"), "f.bvh:5:3: OFFSET: expected a number, found 'CHANNELS'"},
      {Replaced(text, "OFFSET 0 0 0", ""), "joint 'Hips' has no OFFSET"},
      {Replaced(text, "OFFSET 0 0 0", "OFFSET 0 0 0 OFFSET 0 0 0"), "a second OFFSET in joint 'Hips'"},
      {Replaced(text, "CHANNELS 6", "CHANNELS 5"), "f.bvh:5:64: joint 'Hips' names more channels than CHANNELS counts"},
      {Replaced(text, "CHANNELS 3", "CHANNELS 4"), "says 4 but channel 4 is 'JOINT'"},
      {Replaced(text, "CHANNELS 3", "CHANNELS 7"), "7 channels; a joint has 0 to 6"},
      {Replaced(text, "CHANNELS 3", "CHANNELS -1"), "-1 channels"},
      {Replaced(text, "CHANNELS 3", "CHANNELS 99999999999999999999"), "expected a whole number"},
      {Replaced(text, "Xrotation", "Xscale"), "channel 5 is 'Xscale'"},
      {Replaced(text, "CHANNELS 1 Xrotation", "CHANNELS 2 Xrotation xROTATION"), "names channel 'xROTATION' twice"},
      {Replaced(text, "}\n  }\n  JOINT", "}\n  }\n  }\n  JOINT"), "expected 'MOTION', found 'JOINT'"},
      {Replaced(text, "MOTION", "ROOT Hips2 { OFFSET 0 0 0 } MOTION"), "a second ROOT"},
      {Replaced(text, "Frames: 3", "Frames: 2"), "f.bvh:41:1: expected the end of the file after 2 frames"},
      {Replaced(text, "Frames: 3", "Frames: 4"), "the file ends in frame 4 of 4 after 0 of 22 values"},
      {Replaced(text, "Frames: 3", "Frames: 1000000000"), "Frames: 1000000000 claimed; at most 2000000 are read"},
      {Replaced(text, "Frames: 3", "Frames: 2000000"), "the file ends in frame 4 of 2000000"},
      {Replaced(text, "Frames: 3", "Frames: -3"), "Frames: -3 is negative"},
      {Replaced(text, "Frames: 3", "Frames: many"), "f.bvh:37:9: Frames: expected a whole number, found 'many'"},
      {Replaced(text, "Frames: 3", "Frames: 9223372036854775808"), "expected a whole number"},
      {Replaced(text, "Time: 0.0083333", "Time: 0"), "f.bvh:38:13: Frame Time must be positive"},
      {Replaced(text, "Time: 0.0083333", "Time: -1"), "Frame Time must be positive"},
      {Replaced(text, "\n2 96 3 ", "\n2 96 "),
       "the file ends in frame 3 of 3 after 21 of 22 values; the line of frame 2 ends after 21 of 22 values"},
      {Replaced(text, "\n2 96 3 ", "\n2 96 3 4 "), "found '11'; the line of frame 2 holds more than 22 values"},
      {Replaced(text, "\n2 96 3 ", "\n2 nan 3 "), "f.bvh:40:3: frame value: 'nan' is not a finite number"},
      {Replaced(text, "\n2 96 3 ", "\n2 -INF 3 "), "'-INF' is not a finite number"},
      {Replaced(text, "\n2 96 3 ", "\n2 1e999 3 "), "'1e999' is out of the range"},
      {Replaced(text, "\n2 96 3 ", "\n2 9,5 3 "), "decimals need a point"},
      {Replaced(text, "\n2 96 3 ", "\n2 9x 3 "), "f.bvh:40:3: frame value: expected a number, found '9x'"},
      {Replaced(text, "\n2 96 3 ", "\n2 +-9 3 "), "found '+-9'"},
      {text + "MOTION\nFrames: 0\nFrame Time: 1\n", "f.bvh:42:1: a second MOTION section"},
      {text + "and so on", "f.bvh:42:1: expected the end of the file after 3 frames of 22 values, found 'and'"},
      {Replaced(text, "OFFSET 0 -6 14", ""), "the End Site of joint 'LeftFoot' has no OFFSET"},
      {Replaced(text, "OFFSET 0 -6 14", "CHANNELS 0"), "expected one OFFSET and '}' in the End Site"},
      {"HIERARCHY ROOT a { OFFSET 0 0 0 } MOTION Frames: 0 Frame Time: 1", "no joint has channels"},
      {Star(5000), "f.bvh:2002:2: more than 2000 joints"},
      {Chain(5000, 1), "f.bvh:502:1: joints nested deeper than 500"},
      {Chain(501, 1), "f.bvh:502:1: joints nested deeper than 500"},
  };
  for (const auto& [broken, expected] : cases) {
    EXPECT_THAT(BvhError(broken), HasSubstr(expected)) << broken.substr(0, 80);
  }
}

TEST(BvhReader, TruncationAnywhereIsAnErrorWithAPlace) {
  const std::string_view text = kSmallBvh;
  const size_t last_number = text.find_last_of(' ') + 1;  // cutting inside the last number leaves a shorter number
  for (size_t length = 0; length <= last_number; ++length) {
    const std::string error = BvhError(text.substr(0, length));
    EXPECT_THAT(error, HasSubstr("f.bvh:")) << length;
  }
  EXPECT_EQ(BvhError(text.substr(0, last_number + 1)), "");
}

TEST(BvhReader, DeepChainsUpToTheLimitAreRead) {
  EXPECT_EQ(ParseBvh(Chain(500, 2), "f").nodes.size(), 500u);
  BvhLimits generous;
  generous.max_joints = generous.max_depth = 100000;
  const BvhDocument deep = ParseBvh(Chain(100000, 1), "f", generous);  // no recursion, so no stack to overflow
  EXPECT_EQ(deep.nodes.back().parent, 99998);
}

TEST(BvhReader, ClaimedFramesCostNoMemory) {
  std::string text = Chain(400, 0);
  text = Replaced(text, "Frames: 0", "Frames: 900000");
  rusage before, after;
  getrusage(RUSAGE_SELF, &before);
  BvhLimits generous;
  generous.max_joint_frames = 1'000'000'000;
  EXPECT_THAT(BvhError(text, generous), HasSubstr("the file ends in frame 1 of 900000"));
  getrusage(RUSAGE_SELF, &after);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 50'000) << "KiB";  // 2.9 GB were claimed
}

TEST(BvhReader, TheLocaleDoesNotMatter) {
  struct CommaPoint : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const BvhDocument before = ParseBvh(kSmallBvh, "f");
  const std::string text = WriteBvh(before);
  const std::locale old = std::locale::global(std::locale(std::locale(), new CommaPoint));
  const char* const c_locale = std::setlocale(LC_ALL, nullptr);
  const std::string old_c = c_locale ? c_locale : "C";
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8"}) {
    if (std::setlocale(LC_ALL, name)) break;
  }
  const BvhDocument after = ParseBvh(kSmallBvh, "f");
  const std::string text_after = WriteBvh(before);
  std::locale::global(old);
  std::setlocale(LC_ALL, old_c.c_str());
  ExpectSame(before, after);
  EXPECT_EQ(text, text_after);
}

TEST(BvhReader, FilesThatCannotBeReadAreNamed) {
  const testing::TemporaryFolder folder;
  const auto error_of = [](const std::filesystem::path& path) {
    try {
      ReadBvhFile(path);
    } catch (const DatasetError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(error_of(folder.path()), HasSubstr("is a folder"));
  EXPECT_THAT(error_of(folder.path() / "none.bvh"), HasSubstr("none.bvh: cannot be opened: No such file"));
  EXPECT_THAT(error_of(folder.Write("x.bvh", "HIERARCHY\nROOT")), HasSubstr("x.bvh:2:1: a joint without a name"));
}

TEST(BvhReader, BoundsJointsTimesFramesWhereJointsHaveNoChannels) {
  const std::string text = testing::ManyJointsWithoutChannels(50, 40);
  BvhLimits limits;
  limits.max_joint_frames = 2000;
  EXPECT_EQ(BvhError(text, limits), "");
  limits.max_joint_frames = 1999;
  EXPECT_THAT(BvhError(text, limits), HasSubstr("40 frames of 50 joints"));
}

}  // namespace
}  // namespace morphograph
