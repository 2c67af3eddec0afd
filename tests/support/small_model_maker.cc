// small_model_maker FOLDER: learns the models of small_model.h and writes them, for all tests of a ctest run.
#include <cstdio>

#include "tests/support/small_model.h"

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: small_model_maker FOLDER\n"), 2;
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  morphograph::SaveModel(*morphograph::testing::LearnSmallModel(), folder / morphograph::testing::kSmallModelFile);
  morphograph::SaveModel(*morphograph::testing::LearnSmallModelWithRecordings(), folder / morphograph::testing::kSmallModelWithRecordingsFile);
}
