#include "api/viewer_assets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <string>

namespace morphograph {
namespace {

std::string PageText() {
  for (const ViewerAsset& asset : ViewerAssets()) {
    if (asset.path == "/") return std::string(asset.body);
  }
  return "";
}

TEST(ViewerAssets, PathsAreUniqueAndNothingIsEmpty) {
  std::set<std::string_view> paths;
  for (const ViewerAsset& asset : ViewerAssets()) {
    EXPECT_TRUE(asset.path.starts_with('/'));
    EXPECT_TRUE(paths.insert(asset.path).second) << asset.path;
    EXPECT_FALSE(asset.body.empty()) << asset.path;
    EXPECT_FALSE(asset.content_type.empty()) << asset.path;
  }
  EXPECT_TRUE(paths.contains("/"));
}

TEST(ViewerAssets, EmbeddedTextIsWhole) {
  const std::string page = PageText();
  EXPECT_TRUE(page.starts_with("<!doctype html>"));
  EXPECT_TRUE(page.ends_with("</html>\n"));
}

// Whatever the page loads is served by this program or is one of its routes.
TEST(ViewerAssets, PageRefersToNoOtherHostAndToNothingMissing) {
  const std::string page = PageText();
  EXPECT_THAT(page, ::testing::Not(::testing::HasSubstr("://")));
  std::set<std::string> served = {"openapi.json"};
  for (const ViewerAsset& asset : ViewerAssets()) served.insert(std::string(asset.path.substr(1)));
  const std::regex reference(R"re((?:src|href)="([^"]*)")re");
  int references = 0;
  for (std::sregex_iterator it(page.begin(), page.end(), reference), end; it != end; ++it) {
    EXPECT_TRUE(served.contains((*it)[1])) << (*it)[1];
    ++references;
  }
  EXPECT_GE(references, 1);
}

// The policy forbids both; a page that held them would be broken in browsers only.
TEST(ViewerAssets, PageHoldsNoInlineScriptOrStyle) {
  const std::string page = PageText();
  EXPECT_FALSE(std::regex_search(page, std::regex(R"re(\sstyle=|<style|\son[a-z]+="|<script>)re")));
}

}  // namespace
}  // namespace morphograph
