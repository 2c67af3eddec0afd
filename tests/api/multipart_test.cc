#include "api/multipart.h"

#include <gtest/gtest.h>

#include "api/problem.h"

namespace morphograph {
namespace {

const std::string kType = "multipart/form-data; boundary=\"-x-\"";

std::string Part(const std::string& head, const std::string& content) {
  return "---x-\r\n" + head + "\r\n\r\n" + content + "\r\n";
}

int StatusOf(const std::string& type, const std::string& body, const MultipartLimits& limits = {}) {
  try {
    ParseMultipart(type, body, limits);
    return 200;
  } catch (const ProblemError& error) {
    return error.problem().status;
  }
}

TEST(Multipart, SplitsPartsWithNamesAndFiles) {
  const std::string body = "preamble\r\n" +
                           Part("Content-Disposition: form-data; name=\"clips\"; filename=\"a \\\"b\\\";c.bvh\"\r\n"
                                "Content-Type: text/plain",
                                "HIERARCHY\r\n--x\r\nMOTION\r\n") +
                           Part("content-disposition: form-data; filename=plain.bvh; name=more", "") +
                           Part("Content-Disposition: form-data; name=\"settings\"", "{}") + "---x---\r\nepilogue";
  const auto parts = ParseMultipart(kType, body);
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts[0].name, "clips");
  EXPECT_EQ(parts[0].file_name, "a \"b\";c.bvh");
  EXPECT_EQ(parts[0].content, "HIERARCHY\r\n--x\r\nMOTION\r\n");
  EXPECT_EQ(parts[1].file_name, "plain.bvh");
  EXPECT_EQ(parts[1].content, "");
  EXPECT_EQ(parts[2].content, "{}");
}

TEST(Multipart, RefusesWhatIsMalformed) {
  const std::string good = Part("Content-Disposition: form-data; name=a", "1");
  EXPECT_EQ(StatusOf(kType, good + "---x---"), 200);
  EXPECT_EQ(StatusOf("application/json", good + "---x---"), 415);
  EXPECT_EQ(StatusOf("multipart/form-data", good + "---x---"), 400);
  EXPECT_EQ(StatusOf(kType, ""), 400);
  EXPECT_EQ(StatusOf(kType, good), 400);  // no last boundary
  EXPECT_EQ(StatusOf(kType, "---x-"), 400);
  EXPECT_EQ(StatusOf(kType, "---x-\r\n"), 400);
  EXPECT_EQ(StatusOf(kType, Part("Content-Type: text/plain", "1") + "---x---"), 400);
  EXPECT_EQ(StatusOf(kType, Part("Content-Disposition: attachment; name=a", "1") + "---x---"), 400);
  EXPECT_EQ(StatusOf(kType, Part("Content-Disposition: form-data", "1") + "---x---"), 400);
  EXPECT_EQ(StatusOf(kType, Part("Content-Disposition: form-data; name=" + std::string(5000, 'a'), "1") + "---x---"), 400);
  std::string many;
  for (int i = 0; i < 5; ++i) many += good;
  EXPECT_EQ(StatusOf(kType, many + "---x---", {.max_parts = 4}), 400);
}

TEST(Multipart, EveryTruncationIsRefused) {
  const std::string whole = Part("Content-Disposition: form-data; name=a; filename=\"b\"", "text") + "---x---";
  for (std::size_t cut = 0; cut + 1 < whole.size(); ++cut) EXPECT_EQ(StatusOf(kType, whole.substr(0, cut)), 400) << cut;
}

}  // namespace
}  // namespace morphograph
