#include "api/clip_store.h"

#include <gtest/gtest.h>

#include "api/clip_response.h"

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

TEST(ClipFileName, HoldsHarmlessCharactersOnly) {
  EXPECT_EQ(ClipFileName("walk", 42, ".bvh"), "walk-42.bvh");
  EXPECT_EQ(ClipFileName("../a\"\r\nb", 0, ".glb"), "___a___b-0.glb");
}

}  // namespace
}  // namespace morphograph
