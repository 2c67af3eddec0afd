#include "api/clip_store.h"

#include <gtest/gtest.h>

#include "api/clip_response.h"
#include "synthesis/control/sensor_guide.h"

namespace morphograph {
namespace {

ClipStore::Entry EntryOf(std::uint64_t seed) {
  ClipStore::Entry entry;
  entry.request.model = "walk";
  entry.request.seed = seed;
  return entry;
}

TEST(ClipStore, TheOneUnusedForLongestGoesFirst) {
  ClipStore store(3);
  for (const char* id : {"a", "b", "c"}) store.Put(id, EntryOf(1));
  EXPECT_TRUE(store.Get("a"));
  store.Put("b", EntryOf(1));
  store.Put("d", EntryOf(4));
  EXPECT_EQ(store.size(), 3u);
  EXPECT_FALSE(store.Get("c"));
  EXPECT_EQ(store.Get("d")->request.seed, 4u);
  EXPECT_TRUE(store.Get("a"));
  EXPECT_TRUE(store.Get("b"));
}

TEST(ClipStore, LongRequestsMakeRoomForFewerOthers) {
  ClipStore store(1000, 1'000'000);
  ClipStore::Entry entry = EntryOf(1);
  entry.request.control.path.emplace().points_m.resize(1000, {1.0 / 3, 1.5});
  for (int i = 0; i < 100; ++i) store.Put("path" + std::to_string(i), entry);
  EXPECT_LE(store.bytes(), 1'000'000u);
  EXPECT_LT(store.size(), 30u);
  EXPECT_TRUE(store.Get("path99"));
  store.Put("a", EntryOf(2));
  EXPECT_TRUE(store.Get("a"));
  EXPECT_EQ(store.Get("path99")->request.control.path->points_m.size(), 1000u);
}

TEST(ClipStore, CountsReadingsThatWereMadeReady) {
  ClipStore store;
  ClipStore::Entry entry = EntryOf(1);
  store.Put("without", entry);
  const std::size_t without = store.bytes();
  auto guide = std::make_shared<SensorGuide>();
  guide->readings.setZero(12, 10'000);
  guide->walk.steps.resize(5);
  for (DrawnStep& drawn : guide->walk.steps) drawn.shape.poses.setZero(100, 25);
  entry.request.control.sensors.emplace().guide = guide;
  store.Put("with", entry);
  EXPECT_GT(store.bytes(), 2 * without + 8 * (12 * 10'000 + 5 * 100 * 25));
}

TEST(ClipId, NamesModelAndRequestNotTheModelsName) {
  ClipRequest a = EntryOf(1).request;
  ClipRequest b = a;
  b.model = "the same by another name";
  EXPECT_EQ(ClipId("hash", a), ClipId("hash", b));
  EXPECT_NE(ClipId("hash", a), ClipId("other", a));
  b.output.unit = OutputUnit::kMetre;
  EXPECT_NE(ClipId("hash", a), ClipId("hash", b));
  EXPECT_NE(ClipId("hash", a), ClipId("hash", EntryOf(2).request));
  EXPECT_EQ(ClipId("hash", a).size(), 32u);
}

TEST(ClipJson, HoldsTheTextWhateverItsBytes) {
  for (const std::string bvh : {"", "\n", "HIERARCHY\nROOT hips\n\n{\n}", "no line end", "name \"quoted\" \\ here\n",
                                "tab\there\r\n", "Hüfte\n", "del \x7f\n"}) {
    const nlohmann::json answer = nlohmann::json::parse(ClipJson(bvh, R"({"seed":1})"));
    EXPECT_EQ(answer["bvh"], bvh);
    EXPECT_EQ(answer["report"]["seed"], 1);
  }
  EXPECT_NO_THROW(nlohmann::json::parse(ClipJson("not UTF-8 \xff", "{}")));
}

TEST(ClipFileName, HoldsHarmlessCharactersOnly) {
  EXPECT_EQ(ClipFileName("walk", 42, ".bvh"), "walk-42.bvh");
  EXPECT_EQ(ClipFileName("../a\"\r\nb", 0, ".glb"), "___a___b-0.glb");
}

}  // namespace
}  // namespace morphograph
