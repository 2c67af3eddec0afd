#include "graph/model_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <xxhash.h>
#include <zstd.h>

#include <cmath>
#include <cstring>

#include "datasets/errors.h"
#include "graph/graph_summary.h"
#include "tests/support/small_model.h"
#include "tests/support/temporary_folder.h"

namespace morphograph {
namespace {

using ::testing::HasSubstr;

std::string Reason(std::string_view bytes) {
  try {
    ParseModel(bytes, "some.mgm");
  } catch (const DatasetError& error) {
    return error.what();
  }
  return "";
}

TEST(ModelIo, ReadingAndWritingAgainGivesTheSameBytesAndHash) {
  const std::string bytes = SerialiseModel(*testing::SmallModel());
  const auto read = ParseModel(bytes, "some.mgm");
  EXPECT_EQ(SerialiseModel(*read), bytes);
  EXPECT_EQ(read->hash(), testing::SmallModel()->hash());
  EXPECT_EQ(read->hash().size(), 32u);
}

TEST(ModelIo, EveryDamagedByteIsNoticed) {
  const std::string bytes = SerialiseModel(*testing::SmallModel());
  const size_t stride = bytes.size() / 200 + 1;
  for (size_t at = 0; at < bytes.size(); at += at < 32 ? 1 : stride) {
    if (at >= 12 && at < 16) continue;  // reserved, covered by the checksum too; tried below
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x40);
    EXPECT_THAT(Reason(damaged), HasSubstr("some.mgm: ")) << "byte " << at;
  }
  std::string reserved = bytes;
  reserved[13] = 1;
  EXPECT_THAT(Reason(reserved), HasSubstr("damaged"));
}

TEST(ModelIo, CutShortAnywhereIsAnError) {
  const std::string bytes = SerialiseModel(*testing::SmallModel());
  for (size_t tenth = 0; tenth < 10; ++tenth) {
    EXPECT_NE(Reason(std::string_view(bytes).substr(0, bytes.size() * tenth / 10)), "") << tenth;
  }
  EXPECT_NE(Reason(std::string_view(bytes).substr(0, 20)), "");
  EXPECT_THAT(Reason("HIERARCHY ROOT Hips"), HasSubstr("not a Morphograph model"));
}

TEST(ModelIo, NewerVersionIsNamed) {
  std::string bytes = SerialiseModel(*testing::SmallModel());
  bytes[8] = 77;
  EXPECT_THAT(Reason(bytes), HasSubstr("format version 77"));
}

TEST(ModelIo, SavesAndLoadsAFile) {
  const testing::TemporaryFolder folder;
  const auto path = folder.path() / "model.mgm";
  SaveModel(*testing::SmallModel(), path);
  EXPECT_EQ(LoadModel(path)->hash(), testing::SmallModel()->hash());
  EXPECT_THROW(LoadModel(folder.path() / "missing.mgm"), DatasetError);
}

GraphContents ContentsOf(const MotionGraph& graph) {
  GraphContents contents;
  contents.name = graph.name();
  contents.action = graph.action();
  contents.frame_rate_hz = graph.frame_rate_hz();
  contents.layout = graph.layout();
  contents.styles = graph.styles();
  for (int p = 0; p < graph.primitive_count(); ++p) contents.primitives.push_back(graph.primitive(p));
  for (int e = 0; e < graph.edge_count(); ++e) contents.edges.push_back({graph.edge_from(e), graph.edge_to(e), graph.transition(e)});
  return contents;
}

TEST(MotionGraph, RefusesPartsThatDoNotFit) {
  const GraphContents sound = ContentsOf(*testing::SmallModel());
  EXPECT_EQ(MotionGraph(sound, "").edge_count(), testing::SmallModel()->edge_count());
  const auto refusal = [&](auto spoil) -> std::string {
    GraphContents contents = sound;
    spoil(&contents);
    try {
      const MotionGraph graph(std::move(contents), "");
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal([](GraphContents* c) {
                c->edges[0].model.process.emplace(GaussianProcessKernel(), Eigen::MatrixXd::Zero(1, 3), Eigen::MatrixXd::Zero(3, 2), 0);
              }), HasSubstr("edge 0: process"));
  EXPECT_THAT(refusal([](GraphContents* c) { c->edges[0].model.residual_component.at(0) = 99; }), HasSubstr("edge 0: a residual"));
  EXPECT_THAT(refusal([](GraphContents* c) { c->edges[1].model.linear(0, 0) = std::nanf(""); }), HasSubstr("edge 1"));
  EXPECT_THAT(refusal([](GraphContents* c) { c->primitives[0].latent_radius = -1; }), HasSubstr("negative"));
  EXPECT_THAT(refusal([](GraphContents* c) {
                MannerModel& manner = c->primitives[0].manner;
                manner.share = Eigen::VectorXd::Zero(c->primitives[0].reduction.components());
                manner.captured.setZero(manner.share.size(), 1);
                manner.components.setOnes(c->primitives[0].mixture.size(), 1);
                manner.met.setZero(c->primitives[0].mixture.size(), 1);
                manner.steps = {1}, manner.seconds = {1};
              }), HasSubstr("meetings"));
  EXPECT_THAT(refusal([](GraphContents* c) { c->primitives[0].contact_map.setZero(7, c->primitives[0].reduction.components()); }), HasSubstr("contact_map"));
  EXPECT_THAT(refusal([](GraphContents* c) {
                std::vector<int> active = c->layout.active_joints();
                active.back() = active.front();
                c->layout = PoseLayout(c->layout.shared_skeleton(), active);
              }), HasSubstr("stands twice"));
}

TEST(ModelIo, KeepsWhatLatentsTellOfTheFeet) {
  GraphContents contents = ContentsOf(*testing::SmallModel());
  MotionPrimitive& primitive = contents.primitives[0];
  const auto read_map = [&] { return ParseModel(SerialiseModel(MotionGraph(contents, "")), "some.mgm")->primitive(0).contact_map; };
  primitive.contact_map.setZero(kContactRows * kPhaseSamples, primitive.reduction.components());
  primitive.contact_map(kContactRows + kPlantedHeight, 0) = 0.25f;
  EXPECT_EQ(read_map(), primitive.contact_map);  // no map of chances, as in files that are older
  primitive.contact_map(2 * kContactRows + kPlantedChance + 3, 0) = -0.5f;
  EXPECT_EQ(read_map(), primitive.contact_map);
  primitive.contact_map.resize(0, 0);  // as in files that are older still
  EXPECT_EQ(read_map().size(), 0);
}

// The file with one key of its description called otherwise, as a file has it that was written before there was such a key. Of the same length, so that all else stays in place.
std::string WithKeyRenamed(const std::string& bytes, const std::string& key, const std::string& other) {
  constexpr size_t kHeader = 32, kSize = 16, kChecked = 24;
  std::uint64_t size = 0;
  std::memcpy(&size, bytes.data() + kSize, sizeof size);
  std::string payload(size, '\0');
  EXPECT_EQ(ZSTD_decompress(payload.data(), payload.size(), bytes.data() + kHeader, bytes.size() - kHeader), size);
  EXPECT_EQ(key.size(), other.size());
  int renamed = 0;
  const std::string from = "\"" + key + "\":", to = "\"" + other + "\":";
  for (size_t at = payload.find(from); at != std::string::npos; at = payload.find(from, at + 1), ++renamed) payload.replace(at, to.size(), to);
  EXPECT_GT(renamed, 0);
  std::string compressed(ZSTD_compressBound(payload.size()), '\0');
  compressed.resize(ZSTD_compress(compressed.data(), compressed.size(), payload.data(), payload.size(), 3));
  const std::string checked = bytes.substr(0, kChecked) + compressed;
  const std::uint64_t checksum = XXH3_64bits(checked.data(), checked.size());
  std::string file = bytes.substr(0, kHeader) + compressed;
  std::memcpy(file.data() + kChecked, &checksum, sizeof checksum);
  return file;
}

TEST(ModelIo, FilesThatDoNotSayWhatWalksMetTakeItFromTheirFactors) {
  const std::string bytes = SerialiseModel(*testing::SmallModel());
  const auto older = ParseModel(WithKeyRenamed(bytes, "met", "tem"), "some.mgm");
  int manners = 0;
  for (int p = 0; p < older->primitive_count(); ++p) {
    const MotionPrimitive& primitive = older->primitive(p);
    const MannerModel& manner = primitive.manner;
    if (manner.empty()) continue;
    ++manners;
    ASSERT_EQ(manner.met.rows(), primitive.mixture.size());
    ASSERT_EQ(manner.met.cols(), manner.walks());
    for (int walk = 0; walk < manner.walks(); ++walk) {
      EXPECT_NEAR(manner.met.col(walk).sum(), 1, 1e-5);
      for (int c = 1; c < primitive.mixture.size(); ++c) {
        // In the proportion of what the mixture gives components, times the walk's factors.
        const auto share = [&](int of) { return std::exp(primitive.mixture.Component(of).log_weight) * manner.components(of, walk); };
        EXPECT_NEAR(manner.met(c, walk) * share(0), manner.met(0, walk) * share(c), 1e-5);
      }
    }
  }
  EXPECT_GT(manners, 0);
}

TEST(ModelIo, VersionZeroDoesNotExist) {
  std::string bytes = SerialiseModel(*testing::SmallModel());
  bytes[8] = 0;
  EXPECT_THAT(Reason(bytes), HasSubstr("version 0"));
}

}  // namespace
}  // namespace morphograph
