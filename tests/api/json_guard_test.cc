#include "api/json_guard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "api/problem.h"

namespace morphograph {
namespace {

using ::testing::HasSubstr;

std::string Refusal(std::string_view text) {
  try {
    ParseUntrustedJson(text);
  } catch (const ProblemError& error) {
    EXPECT_EQ(error.problem().status, 400);
    return error.problem().errors.at(0).detail;
  }
  ADD_FAILURE() << "was accepted";
  return {};
}

TEST(JsonGuard, RefusesTenThousandLevelsBeforeParsing) {
  const std::string arrays(10'000, '[');
  EXPECT_THAT(Refusal(arrays), HasSubstr("nested deeper"));
  EXPECT_THAT(Refusal(arrays + std::string(10'000, ']')), HasSubstr("nested deeper"));
  std::string objects;
  for (int i = 0; i < 10'000; ++i) objects += R"({"a":)";
  EXPECT_THAT(Refusal(objects), HasSubstr("nested deeper"));
}

TEST(JsonGuard, BracketsInsideStringsDoNotCount) {
  const std::string text = "{\"a\":\"\\\"" + std::string(1000, '[') + "\"}";
  EXPECT_EQ(ParseUntrustedJson(text)["a"].get<std::string>().size(), 1001u);
}

TEST(JsonGuard, SaysWhereTheTextBreaks) {
  EXPECT_THAT(Refusal("{\"a\": 1,\n \"b\" 2}"), HasSubstr("line 2"));
  EXPECT_THAT(Refusal(R"({"model":"walk)"), HasSubstr("line 1"));
}

TEST(JsonGuard, RefusesWhatIsNotJson) {
  for (const std::string text : {"", " \r\n", "{", "nul", "{'a':1}", "{\"a\":1}}", "{\"a\":1,}", "/* */ {}", "1e999",
                                 "\"\xff\"", "{\"a\":NaN}", "{\"a\":01}"})
    EXPECT_NE(Refusal(text), "") << text;
}

TEST(JsonGuard, RefusesTheSameNameTwiceInOneObject) {
  EXPECT_THAT(Refusal(R"({"a":{"b":1},"c":2,"a":3})"), HasSubstr("\"a\" stands twice"));
  EXPECT_NO_THROW(ParseUntrustedJson(R"([{"a":{"a":1}},{"a":2}])"));
}

TEST(Problem, ExcerptNeverSplitsACharacter) {
  EXPECT_EQ(Excerpt("abcé", 4), "abc…");
  EXPECT_EQ(Excerpt("abc", 4), "abc");
}

TEST(Problem, BytesThatAreNotUtf8StillGiveJson) {
  EXPECT_THAT(ProblemJson({400, "name \xff\xfe", {}, {}, {}}), HasSubstr("\"status\":400"));
}

}  // namespace
}  // namespace morphograph
