#include "datasets/bvh_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/random/uniform_int_distribution.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <charconv>
#include <cmath>
#include <limits>
#include <random>

#include "datasets/bvh_reader.h"
#include "datasets/errors.h"
#include "tests/datasets/bvh_test_files.h"

namespace morphograph {
namespace {

using ::testing::HasSubstr;

BvhDocument OneValue(double value) {
  BvhDocument document;
  document.nodes.resize(1);
  document.nodes[0].name = "root";
  document.nodes[0].channels = {Channel::kXPosition};
  document.frame_time_s = 0.01;
  document.values.resize(1, 1);
  document.values << value;
  return document;
}

std::string Written(double value, int decimals) {
  const std::string text = WriteBvh(OneValue(value), {decimals});
  const size_t start = text.rfind('\n', text.size() - 2) + 1;
  return text.substr(start, text.size() - start - 1);
}

// Of the exact value, ties to even; no sign on zero.
std::string Reference(double value, int decimals) {
  char text[400];
  const std::string plain(text, std::to_chars(text, text + 400, value, std::chars_format::fixed, decimals).ptr);
  return plain.find_first_of("123456789") == std::string::npos && plain[0] == '-' ? plain.substr(1) : plain;
}

TEST(BvhWriter, RoundsLikeToChars) {
  std::mt19937_64 rng(11);
  boost::random::uniform_real_distribution<double> mantissa(-1, 1);
  boost::random::uniform_int_distribution<int> exponent(-12, 18), half(-2000000, 2000000);
  for (const int decimals : {0, 1, 4, 6, 9, 15}) {
    for (int i = 0; i < 4000; ++i) {
      const double value = mantissa(rng) * std::pow(10.0, exponent(rng));
      ASSERT_EQ(Written(value, decimals), Reference(value, decimals)) << value << " " << decimals;
      // On or one step beside a tie.
      const double tie = (half(rng) + 0.5) * std::pow(10.0, -decimals);
      for (const double near : {tie, std::nextafter(tie, 1e9), std::nextafter(tie, -1e9)}) {
        ASSERT_EQ(Written(near, decimals), Reference(near, decimals)) << near << " " << decimals;
      }
    }
  }
  EXPECT_EQ(Written(-0.0, 6), "0.000000");
  EXPECT_EQ(Written(-1e-9, 6), "0.000000");
  EXPECT_EQ(Written(0.5, 0), "0");
  EXPECT_EQ(Written(1.5, 0), "2");
  EXPECT_EQ(Written(-179.9999996, 6), "-180.000000");
  EXPECT_EQ(Written(1.7e308, 15), Reference(1.7e308, 15));
}

TEST(BvhWriter, FrameTimeHasSevenDigitsAndReadsBackExactly) {
  for (const double time : {1.0 / 30, 1.0 / 120, 0.0083333, 0.008333, 0.01, 1.0, 0.1 + 0.2, 1e-5 / 3}) {
    BvhDocument document = OneValue(0);
    document.frame_time_s = time;
    const std::string text = WriteBvh(document);
    EXPECT_EQ(ParseBvh(text, "f").frame_time_s, time);
    const size_t start = text.find("Frame Time: ") + 12;
    const std::string digits = text.substr(start, text.find('\n', start) - start);
    EXPECT_GE(digits.size() - digits.find('.') - 1, 7u) << digits;
    EXPECT_EQ(digits.find('e'), std::string::npos);
  }
}

TEST(BvhWriter, WritesDepthFirstWhateverTheOrderOfNodes) {
  const BvhDocument document = ParseBvh(testing::kSmallBvh, "f");
  BvhDocument shuffled = document;  // breadth first: Hips, LeftUpLeg, RightUpLeg, LeftLeg, RightFoot, LeftFoot
  const int order[] = {0, 1, 4, 2, 5, 3};
  const int parents[] = {-1, 0, 0, 1, 2, 3};
  for (int i = 0; i < 6; ++i) {
    shuffled.nodes[i] = document.nodes[order[i]];
    shuffled.nodes[i].parent = parents[i];
  }
  EXPECT_EQ(WriteBvh(shuffled), WriteBvh(document));
}

TEST(BvhWriter, RefusesWhatBvhCannotHold) {
  EXPECT_THROW(WriteBvh(BvhDocument()), std::invalid_argument);
  EXPECT_THROW(WriteBvh(OneValue(std::nan(""))), std::invalid_argument);
  EXPECT_THROW(WriteBvh(OneValue(std::numeric_limits<double>::infinity())), std::invalid_argument);
  EXPECT_THROW(WriteBvh(OneValue(1), {-1}), std::invalid_argument);
  EXPECT_THROW(WriteBvh(OneValue(1), {16}), std::invalid_argument);
  BvhDocument document = OneValue(1);
  document.frame_time_s = 0;
  EXPECT_THROW(WriteBvh(document), std::invalid_argument);
  document = OneValue(1);
  document.nodes[0].name = "a\nb";
  EXPECT_THROW(WriteBvh(document), std::invalid_argument);
  document = OneValue(1);
  document.nodes[0].first_channel = 1;
  EXPECT_THROW(WriteBvh(document), std::invalid_argument);
  document = OneValue(1);
  document.nodes[0].offset.x() = std::nan("");
  EXPECT_THROW(WriteBvh(document), std::invalid_argument);
  document = OneValue(1);
  document.nodes[0].parent = 0;
  EXPECT_THROW(WriteBvh(document), std::invalid_argument);
}

}  // namespace
}  // namespace morphograph
