#include "datasets/readings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "datasets/errors.h"
#include "tests/support/random_matrix.h"

namespace morphograph {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string ErrorOf(const std::string& text) {
  try {
    ParseReadingsCsv(text, "a.csv");
  } catch (const DatasetError& error) {
    return error.what();
  }
  return "no error";
}

constexpr char kHeader[] = "time,foot.x,foot.y,foot.z\n";

TEST(ReadingsCsv, ComesBackAsItWas) {
  std::mt19937_64 rng(3);
  Readings readings;
  readings.names = {"left_wrist", "right wrist", "h\xC3\xBC" "fte"};
  for (int i = 0; i < 50; ++i) readings.times_s.push_back(-0.3 + 0.017 * i + 1e-6 * (i % 3));
  readings.values = 20 * testing::RandomNormal(9, 50, rng);
  readings.values.block<3, 4>(3, 10).setConstant(std::nan(""));
  readings.values(0, 0) = 1.25e-12;
  const Readings again = ParseReadingsCsv(ReadingsCsv(readings), "again.csv");
  EXPECT_EQ(again.names, readings.names);
  ASSERT_EQ(again.sample_count(), 50);
  for (int i = 0; i < 50; ++i) {
    EXPECT_NEAR(again.times_s[static_cast<std::size_t>(i)], readings.times_s[static_cast<std::size_t>(i)], 5e-7);
    for (int r = 0; r < 9; ++r) {
      EXPECT_EQ(std::isnan(again.values(r, i)), std::isnan(readings.values(r, i)));
      if (std::isnan(readings.values(r, i))) continue;
      EXPECT_NEAR(again.values(r, i), readings.values(r, i), 5e-9 * std::abs(readings.values(r, i)));
    }
  }
  EXPECT_EQ(ReadingsCsv(again), ReadingsCsv(readings));
}

TEST(ReadingsCsv, TakesWhatSpreadsheetsWrite) {
  const Readings readings = ParseReadingsCsv(
      "\xEF\xBB\xBF# walked on the grass\r\n\r\n time , foot.x,foot.y ,foot.z\r\n0, +1,2.5e0,\t-3\r\n\r\n# a pause\r\n0.5,,NaN,nan", "a.csv");
  EXPECT_THAT(readings.names, ElementsAre("foot"));
  EXPECT_THAT(readings.times_s, ElementsAre(0, 0.5));
  EXPECT_EQ(readings.values.col(0), Eigen::Vector3d(1, 2.5, -3));
  EXPECT_TRUE(readings.values.col(1).array().isNaN().all());
}

TEST(ReadingsCsv, NamesInLatin1BecomeUtf8) {
  EXPECT_THAT(ParseReadingsCsv("time,fu\xDF.x,fu\xDF.y,fu\xDF.z\n0,1,2,3\n", "a.csv").names, ElementsAre("fu\xC3\x9F"));
}

TEST(ReadingsCsv, SamplesAreSortedAndTheLastOfOneTimeCounts) {
  const Readings readings = ParseReadingsCsv(std::string(kHeader) + "2,1,1,1\n1,2,2,2\n2,3,3,3\n0,4,4,4\n1,5,5,5\n", "a.csv");
  EXPECT_THAT(readings.times_s, ElementsAre(0, 1, 2));
  EXPECT_EQ(readings.values.row(0), Eigen::RowVector3d(4, 5, 3));
}

TEST(ReadingsCsv, TimesMayCountFrom1970) {
  const Readings readings = ParseReadingsCsv(std::string(kHeader) + "1763826000.25,1,1,1\n1763826000.5,2,2,2\n", "a.csv");
  EXPECT_THAT(ParseReadingsCsv(ReadingsCsv(readings), "a.csv").times_s, ElementsAre(1763826000.25, 1763826000.5));
}

TEST(ReadingsCsv, RateIsThatOfTheMedianStep) {
  Readings readings;
  EXPECT_EQ(readings.rate_hz(), 0);
  readings.times_s = {0};
  EXPECT_EQ(readings.rate_hz(), 0);
  readings.times_s = {0, 0.01, 0.02, 0.03, 5};
  EXPECT_NEAR(readings.rate_hz(), 100, 1e-9);
}

TEST(ReadingsCsv, ErrorsSayWhere) {
  const std::string header = kHeader;
  EXPECT_THAT(ErrorOf(""), HasSubstr("no header"));
  EXPECT_THAT(ErrorOf("# nothing\n\n"), HasSubstr("no header"));
  EXPECT_THAT(ErrorOf(header), StartsWith("a.csv:1: no sample"));
  EXPECT_THAT(ErrorOf("\nt,foot.x,foot.y,foot.z\n"), StartsWith("a.csv:2:1: the first column must be \"time\""));
  EXPECT_THAT(ErrorOf("time\n0\n"), StartsWith("a.csv:1:1: expected time,"));
  EXPECT_THAT(ErrorOf("time,foot.x,foot.y\n"), StartsWith("a.csv:1:1: expected time,"));
  EXPECT_THAT(ErrorOf("time,foot.x,foot.z,foot.y\n"), StartsWith("a.csv:1:13: expected a column <sensor>.y"));
  EXPECT_THAT(ErrorOf("time,foot.x,hand.y,foot.z\n"), StartsWith("a.csv:1:13: expected a column of 'foot'"));
  EXPECT_THAT(ErrorOf("time,.x,.y,.z\n"), StartsWith("a.csv:1:6: expected a column <sensor>.x"));
  EXPECT_THAT(ErrorOf("time,a.x,a.y,a.z,a.x,a.y,a.z\n"), StartsWith("a.csv:1:18: 'a' stands twice"));
  EXPECT_THAT(ErrorOf(header + "0,1,2\n"), StartsWith("a.csv:2:1: expected 4 cells, found 3"));
  EXPECT_THAT(ErrorOf(header + "0,1,2,3\n0,1,2,3,4\n"), StartsWith("a.csv:3:1: expected 4 cells, found 5"));
  EXPECT_THAT(ErrorOf(header + "0,1,two,3\n"), StartsWith("a.csv:2:5: not a number: two"));
  EXPECT_THAT(ErrorOf(header + "0,1,2,3e999\n"), StartsWith("a.csv:2:7: not a number: 3e999"));
  EXPECT_THAT(ErrorOf(header + "0,inf,2,3\n"), StartsWith("a.csv:2:3: not a number: inf"));
  EXPECT_THAT(ErrorOf(header + "0,1 2,2,3\n"), StartsWith("a.csv:2:3: not a number"));
  EXPECT_THAT(ErrorOf(header + "0,+-1,2,3\n"), StartsWith("a.csv:2:3: not a number"));
  EXPECT_THAT(ErrorOf(header + ",1,2,3\n"), StartsWith("a.csv:2:1: a sample must have a time"));
  EXPECT_THAT(ErrorOf(header + "nan,1,2,3\n"), StartsWith("a.csv:2:1: a sample must have a time"));
  EXPECT_THAT(ErrorOf(header + "1763826000250,1,2,3\n"), StartsWith("a.csv:2:1: the time must be in seconds"));
  EXPECT_THAT(ErrorOf(header + "0,1e31,2,3\n"), StartsWith("a.csv:2:3: too large"));
}

TEST(ReadingsCsv, HostileFilesAreRefusedCheaply) {
  std::string wide = "time";
  for (int c = 0; c < 1'000'000; ++c) wide += ",a.x";
  EXPECT_THAT(ErrorOf(wide), StartsWith("a.csv:1:1: more than 1501 columns"));
  EXPECT_THAT(ErrorOf(std::string(kHeader) + "0" + std::string(1'000'000, ',')), StartsWith("a.csv:2:1: expected 4 cells, found 1000001"));
  const std::string long_cell = ErrorOf(std::string(kHeader) + "0,1," + std::string(1'000'000, 'q') + ",3\n");
  EXPECT_THAT(long_cell, StartsWith("a.csv:2:5: not a number"));
  EXPECT_LT(long_cell.size(), 100u);
  EXPECT_THAT(ErrorOf(std::string(1'000'000, '\0')), StartsWith("a.csv:1:1:"));
}

}  // namespace
}  // namespace morphograph
