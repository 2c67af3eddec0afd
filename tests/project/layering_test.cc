// Who may include whom. The rules are checked on the tree, and each of them on a made-up file that breaks it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <optional>
#include <set>

#include "tests/project/source_tree.h"

namespace morphograph::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A folder may include itself and those before it.
constexpr std::array<std::string_view, 5> kLayers = {"datasets", "primitives", "graph", "synthesis", "api"};

std::string_view FirstFolder(std::string_view path) { return path.substr(0, path.find('/')); }

std::optional<std::size_t> Layer(std::string_view path) {
  const auto* found = std::find(kLayers.begin(), kLayers.end(), FirstFolder(path));
  if (found == kLayers.end() || path.find('/') == std::string_view::npos) return std::nullopt;
  return static_cast<std::size_t>(found - kLayers.begin());
}

bool IsHttp(std::string_view include) { return include == "httplib.h" || include.starts_with("boost/beast"); }
bool IsSolver(std::string_view include) { return include.starts_with("ceres/"); }
bool IsPrivate(std::string_view path) { return path.find("/internal/") != std::string_view::npos; }

// What comes with a precompiled header, by the name that a file uses of it and how the including line starts.
struct Library {
  std::string_view name, include;
};
constexpr std::array<Library, 2> kPrecompiled = {{{"Eigen::", "Eigen/"}, {"nlohmann::", "nlohmann/"}}};

bool Reaches(const std::map<std::string, const SourceFile*>& by_path, const SourceFile& file, std::string_view library,
             std::set<std::string>& seen) {
  for (const std::string& include : Includes(file.text)) {
    if (include.starts_with(library)) return true;
    const auto found = by_path.find(include);
    if (found != by_path.end() && seen.insert(include).second && Reaches(by_path, *found->second, library, seen)) return true;
  }
  return false;
}

// A sentence for each library that a file uses without including it, itself or through others. The compiler would not
// notice where a precompiled header brings it.
std::vector<std::string> Unincluded(const std::vector<SourceFile>& files) {
  std::map<std::string, const SourceFile*> by_path;
  for (const SourceFile& file : files) by_path[file.path] = &file;
  std::vector<std::string> problems;
  for (const SourceFile& file : files) {
    if (file.path.starts_with("tests/project/")) continue;  // the names in this file are strings
    for (const Library& library : kPrecompiled) {
      std::set<std::string> seen;
      if (file.text.find(library.name) == std::string::npos || Reaches(by_path, file, library.include, seen)) continue;
      problems.push_back(file.path + " uses " + std::string(library.name) + " without " + std::string(library.include));
    }
  }
  return problems;
}

// One sentence for each rule that `file` breaks.
std::vector<std::string> Problems(const SourceFile& file) {
  std::vector<std::string> problems;
  const std::optional<std::size_t> own = Layer(file.path);
  const bool header = file.path.ends_with(".h");
  for (const std::string& include : Includes(file.text)) {
    const auto report = [&](const std::string& why) {
      problems.push_back(file.path + " includes " + include + ": " + why);
    };
    if (include.starts_with("../") || include.starts_with("./")) report("includes are named from the root");
    if (!own) continue;
    const std::optional<std::size_t> other = Layer(include);
    if (other && *other > *own) report("a folder may only include those below it");
    if (FirstFolder(include) == "tests") report("the program does not use the tests");
    if (other && IsPrivate(include) && FirstFolder(include) != FirstFolder(file.path)) {
      report("it is private to " + std::string(FirstFolder(include)) + "/");
    }
    if (IsHttp(include) && FirstFolder(file.path) != "api") report("HTTP stays in api/");
    if (header && !IsPrivate(file.path)) {
      if (IsPrivate(include)) report("a public header must not need a private one");
      if (IsSolver(include) && file.path.find("/residuals/") == std::string::npos) {
        report("the solver stays out of public headers");
      }
    }
  }
  return problems;
}

TEST(Layering, HoldsInTheTree) {
  const std::vector<SourceFile> files = SourceFiles();
  std::size_t layered = 0;
  for (const SourceFile& file : files) {
    layered += Layer(file.path).has_value();
    EXPECT_THAT(Problems(file), IsEmpty());
  }
  EXPECT_GT(layered, 50u) << "the tree was not found";
}

// A source that includes its own header first shows that the header stands alone; headers_alone covers the others.
TEST(Layering, EverySourceIncludesItsOwnHeaderFirst) {
  for (const SourceFile& file : SourceFiles()) {
    if (!file.path.ends_with(".cc") || !Layer(file.path)) continue;
    const std::string header = file.path.substr(0, file.path.size() - 2) + "h";
    const std::vector<std::string> includes = Includes(file.text);
    if (!std::filesystem::exists(std::filesystem::path(MORPHOGRAPH_SOURCE_DIR) / header)) continue;
    ASSERT_FALSE(includes.empty()) << file.path;
    EXPECT_EQ(includes.front(), header) << file.path;
  }
}

TEST(Layering, NothingRestsOnThePrecompiledHeader) {
  EXPECT_THAT(Unincluded(SourceFiles()), IsEmpty());
  EXPECT_THAT(Unincluded({{"graph/a.h", "Eigen::VectorXd v;"}}), ElementsAre("graph/a.h uses Eigen:: without Eigen/"));
  EXPECT_THAT(Unincluded({{"graph/a.h", "#include \"graph/b.h\"\nEigen::VectorXd v;"},
                          {"graph/b.h", "#include \"graph/a.h\"\n#include <Eigen/Core>\n"}}),
              IsEmpty());
}

TEST(Layering, EveryHeaderHasAGuard) {
  for (const SourceFile& file : SourceFiles()) {
    if (file.path.ends_with(".h")) {
      EXPECT_THAT(file.text, HasSubstr("#pragma once")) << file.path;
    }
  }
}

TEST(Layering, FindsAnUpwardInclude) {
  EXPECT_THAT(Problems({"datasets/a.cc", "#include \"datasets/b.h\"\n#include \"graph/motion_graph.h\"\n"}),
              ElementsAre(HasSubstr("datasets/a.cc includes graph/motion_graph.h: a folder may only")));
  EXPECT_THAT(Problems({"api/a.cc", "#include \"graph/motion_graph.h\"\n"}), IsEmpty());
}

TEST(Layering, FindsAPrivateInclude) {
  const std::string text = "#include \"datasets/internal/spline.h\"\n";
  EXPECT_THAT(Problems({"graph/a.cc", text}), ElementsAre(HasSubstr("private to datasets/")));
  EXPECT_THAT(Problems({"datasets/a.h", text}), ElementsAre(HasSubstr("must not need a private one")));
  EXPECT_THAT(Problems({"datasets/a.cc", text}), IsEmpty());
  EXPECT_THAT(Problems({"tests/datasets/spline_test.cc", text}), IsEmpty());
}

TEST(Layering, FindsMisplacedLibraries) {
  EXPECT_THAT(Problems({"synthesis/a.cc", "#include <httplib.h>\n"}), ElementsAre(HasSubstr("HTTP stays in api/")));
  EXPECT_THAT(Problems({"synthesis/a.h", "#include <ceres/ceres.h>\n"}), ElementsAre(HasSubstr("solver stays out")));
  EXPECT_THAT(Problems({"synthesis/a.cc", "#include <ceres/ceres.h>\n"}), IsEmpty());
  EXPECT_THAT(Problems({"api/a.cc", "#include <httplib.h>\n"}), IsEmpty());
}

TEST(Layering, FindsTestsAndRelativePathsInTheProgram) {
  EXPECT_THAT(Problems({"graph/a.cc", "#include \"tests/support/random_matrix.h\"\n"}),
              ElementsAre(HasSubstr("does not use the tests")));
  EXPECT_THAT(Problems({"graph/a.cc", "#include \"../datasets/b.h\"\n"}), ElementsAre(HasSubstr("from the root")));
}

}  // namespace
}  // namespace morphograph::testing
