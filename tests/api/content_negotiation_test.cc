#include "api/content_negotiation.h"

#include <gtest/gtest.h>

namespace morphograph {
namespace {

int Choose(std::string_view accept) {
  return ChooseMediaType(accept, {"text/plain", "application/json", "model/gltf-binary"});
}

TEST(ContentNegotiation, TheFavouriteWinsWhereTheClientDoesNotMind) {
  EXPECT_EQ(Choose(""), 0);
  EXPECT_EQ(Choose("*/*"), 0);
  EXPECT_EQ(Choose("text/html, application/xhtml+xml, */*;q=0.8"), 0);
}

TEST(ContentNegotiation, QualityDecidesAndPreciseRangesOutrankWideOnes) {
  EXPECT_EQ(Choose("application/json"), 1);
  EXPECT_EQ(Choose("text/plain;q=0.2, application/json;q=0.9, */*;q=0.1"), 1);
  EXPECT_EQ(Choose("*/*, text/plain;q=0"), 1);
  EXPECT_EQ(Choose("application/json;q=0, application/*;q=1, model/*;q=0.5"), 2);
  EXPECT_EQ(Choose("MODEL/GLTF-Binary;v=2;Q=0.5"), 2);
  EXPECT_EQ(Choose("text/*"), 0);
}

TEST(ContentNegotiation, NothingSuits) {
  EXPECT_EQ(Choose("text/html"), -1);
  EXPECT_EQ(Choose("*/*;q=0"), -1);
  EXPECT_EQ(Choose("application/json;q=2"), -1);
  EXPECT_EQ(Choose(",;,"), -1);
}

TEST(ContentNegotiation, MediaTypeDropsParameters) {
  EXPECT_EQ(MediaTypeOf(" text/plain ; charset=utf-8"), "text/plain");
  EXPECT_EQ(MediaTypeOf(""), "");
}

TEST(ContentNegotiation, EntityTagsCompareWeakly) {
  EXPECT_TRUE(MatchesEntityTag("\"a\", W/\"b\"", "\"b\""));
  EXPECT_TRUE(MatchesEntityTag("*", "\"b\""));
  EXPECT_FALSE(MatchesEntityTag("\"bb\"", "\"b\""));
  EXPECT_FALSE(MatchesEntityTag("", "\"b\""));
}

}  // namespace
}  // namespace morphograph
