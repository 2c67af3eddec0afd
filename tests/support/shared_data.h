#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace morphograph::testing {

/// Folder of the real recordings, or an empty path. Looked for in $MORPHOGRAPH_DATA, then beside the checkout.
inline std::filesystem::path SharedData() {
  if (const char* given = std::getenv("MORPHOGRAPH_DATA"); given && *given) return given;
  const std::filesystem::path beside = std::filesystem::path(MORPHOGRAPH_SOURCE_DIR) / ".." / "shared" / "data";
  return std::filesystem::exists(beside) ? beside.lexically_normal() : std::filesystem::path();
}

}  // namespace morphograph::testing

/// Skips a test, saying why, where the recordings are absent.
#define MORPHOGRAPH_REQUIRE_SHARED_DATA()                                                                 \
  do {                                                                                                    \
    if (morphograph::testing::SharedData().empty())                                                       \
      GTEST_SKIP() << "the recordings are not here: set MORPHOGRAPH_DATA to a folder with cmu/ and bnr/"; \
  } while (false)
