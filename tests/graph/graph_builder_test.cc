#include "graph/graph_builder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <set>

#include "datasets/dataset_loader.h"
#include "datasets/errors.h"
#include "datasets/resample.h"
#include "graph/graph_summary.h"
#include "graph/model_io.h"
#include "primitives/keyframe_detector.h"
#include "tests/support/shared_data.h"
#include "tests/support/small_model.h"
#include "tests/support/two_actions.h"

namespace morphograph {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

const PrimitiveSummary* Find(const GraphSummary& summary, const std::string& name, const std::string& style) {
  for (const PrimitiveSummary& primitive : summary.primitives) {
    if (primitive.name == name && primitive.style == style) return &primitive;
  }
  return nullptr;
}

std::vector<TrainingClip> SmallClips() {
  std::vector<TrainingClip> clips;
  for (auto& [name, clip] : testing::SmallWalks()) clips.push_back({std::move(clip), true});
  return clips;
}

TEST(GraphBuilder, LearnsWalkingStartingAndStoppingInEveryStyle) {
  const GraphSummary summary = Summarise(*testing::SmallModel());
  EXPECT_THAT(summary.styles, ::testing::ElementsAre("brisk", "slow"));
  for (const std::string style : {"brisk", "slow"}) {
    for (const std::string name : {"left_walk", "right_walk", "left_first_start", "right_first_start"}) {
      const PrimitiveSummary* primitive = Find(summary, name, style);
      ASSERT_NE(primitive, nullptr) << name << " " << style;
      EXPECT_GE(primitive->variance_kept, 0.99) << name;
      EXPECT_GE(primitive->components, 1) << name;
    }
  }
  // Six walks of 14 steps a style: faster ones take shorter steps in time.
  EXPECT_LT(Find(summary, "left_walk", "brisk")->mean_duration_s, Find(summary, "left_walk", "slow")->mean_duration_s);
}

// By the criterion alone these steps have one component or two.
TEST(GraphBuilder, MixturesHaveAComponentForThirtyFiveCapturedSteps) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  std::vector<TrainingClip> captured;
  for (LoadedClip& loaded : LoadDataset({testing::SharedData() / "bnr" / "dataset-2" / "walk"}, DatasetManifest(), 2).clips) {
    if (loaded.clip.style == "exhausted") captured.push_back({std::move(loaded.clip)});
  }
  std::vector<TrainingClip> mostly_made = captured;
  for (size_t i = 4; i < mostly_made.size(); ++i) mostly_made[i].made = true;
  TrainingOptions options;
  options.jobs = 2;
  for (const bool made : {false, true}) {
    const auto graph = BuildGraph(made ? mostly_made : captured, options);
    int walking = 0;
    for (int p = 0; p < graph->primitive_count(); ++p) {
      const MotionPrimitive& primitive = graph->primitive(p);
      if (!primitive.name.ends_with("_walk")) continue;
      ++walking;
      if (made) {
        EXPECT_LT(primitive.mixture.size(), 3) << primitive.name;
      } else {
        EXPECT_GE(primitive.mixture.size(), std::min(4, primitive.examples / 35)) << primitive.name << " of " << primitive.examples;
        EXPECT_GE(primitive.examples, 105) << primitive.name;
      }
    }
    EXPECT_EQ(walking, 2);
  }
}

TEST(GraphBuilder, ContactsSayThatTheLandingFootStandsAtTheEndOfItsStep) {
  const GraphSummary summary = Summarise(*testing::SmallModel());
  const PrimitiveSummary* step = Find(summary, "left_walk", "slow");
  ASSERT_NE(step, nullptr);
  const bool stands = std::any_of(step->contacts.begin(), step->contacts.end(), [](const ContactSummary& contact) {
    return contact.part.starts_with("left") && contact.to_phase > 1;
  });
  const bool swings = std::none_of(step->contacts.begin(), step->contacts.end(), [](const ContactSummary& contact) {
    return contact.part.starts_with("left") && contact.from_phase < 0.55 && contact.to_phase > 0.55;
  });
  EXPECT_TRUE(stands);
  EXPECT_TRUE(swings);
}

TEST(GraphBuilder, ChancesOfLeavingSumToOneAndDeadEndsAreNoted) {
  const auto& graph = *testing::SmallModel();
  for (int p = 0; p < graph.primitive_count(); ++p) {
    double sum = 0;
    for (const int edge : graph.out_edges(p)) sum += graph.transition(edge).probability;
    if (graph.is_dead_end(p)) {
      EXPECT_THAT(graph.provenance().notes, Contains(HasSubstr("dead end")));
    } else {
      EXPECT_NEAR(sum, 1, 1e-9);
    }
  }
}

TEST(GraphBuilder, SameModelOnAnyNumberOfThreads) {
  TrainingOptions options;
  options.name = "walk";
  options.jobs = 3;
  EXPECT_EQ(BuildGraph(SmallClips(), options)->hash(), testing::SmallModel()->hash());
}

TEST(GraphBuilder, ProgressRisesToOne) {
  TrainingOptions options;
  double last = 0;
  bool rises = true;
  options.progress = [&](const std::string& stage, double fraction) {
    rises = rises && !stage.empty() && fraction >= last - 1e-12;
    last = fraction;
  };
  BuildGraph(SmallClips(), options);
  EXPECT_TRUE(rises);
  EXPECT_DOUBLE_EQ(last, 1);
}

TEST(GraphBuilder, StopsWhenCancelled) {
  std::atomic<bool> cancelled = true;
  TrainingOptions options;
  options.cancelled = &cancelled;
  EXPECT_THROW(BuildGraph(SmallClips(), options), TrainingCancelled);
}

TEST(GraphBuilder, SaysWhyNothingCanBeLearned) {
  EXPECT_THROW(BuildGraph({}, {}), DatasetError);
  SyntheticGaitOptions one_step;
  one_step.steps = 2;
  try {
    BuildGraph({{GenerateGait(one_step), true}}, {});
    FAIL() << "learned from two steps";
  } catch (const DatasetError& error) {
    EXPECT_THAT(error.what(), HasSubstr("examples"));
  }
}

TEST(GraphBuilder, RefusesSkeletonsWithoutLegs) {
  std::vector<Joint> joints(2);
  joints[0].name = "base";
  joints[1].name = "tip";
  joints[1].parent = 0;
  const auto skeleton = std::make_shared<Skeleton>(joints, DetectRoles({"base", "tip"}), 1.0, UpAxis::kY);
  try {
    BuildGraph({{MotionClip(skeleton, 30, 100), false}}, {});
    FAIL() << "learned from a skeleton without legs";
  } catch (const DatasetError& error) {
    EXPECT_THAT(error.what(), HasSubstr("left_knee"));
    EXPECT_THAT(error.what(), HasSubstr("roles"));
  }
}

TEST(GraphBuilder, StepsAreNamedByTheActionAndBeginWhereTheFinderSays) {
  TrainingOptions options;
  options.action = "stroll";
  EXPECT_THROW(BuildGraph(SmallClips(), options), DatasetError);  // no features are known for it
  std::atomic<int> asked = 0;
  options.find_keyframes = [&](const MotionClip& clip) {
    ++asked;
    return DetectKeyframes(clip);
  };
  const GraphSummary summary = Summarise(*BuildGraph(SmallClips(), options));
  EXPECT_EQ(asked, static_cast<int>(SmallClips().size()));
  EXPECT_NE(Find(summary, "left_stroll", "brisk"), nullptr);
  EXPECT_EQ(Find(summary, "left_walk", "brisk"), nullptr);
  EXPECT_THAT(summary.notes, ::testing::Not(Contains(HasSubstr("_walk"))));
}

TEST(GraphBuilder, FrameRateIsOfTheClipsAndNotOfTheirOrder) {
  std::vector<TrainingClip> clips = SmallClips();
  MotionClip slow = clips[0].clip;
  slow.name = "slow";
  MotionClip crawl(slow.shared_skeleton(), 1, slow.frame_count());
  crawl.name = "crawl";
  crawl.style = slow.style;
  clips.insert(clips.begin(), {Resample(slow, 15), true});
  clips.insert(clips.begin(), {crawl, true});
  const auto graph = BuildGraph(clips, TrainingOptions());
  EXPECT_EQ(graph->frame_rate_hz(), 30);
  EXPECT_THAT(graph->provenance().notes, Contains(HasSubstr("crawl: recorded at 1 frames a second")));
}

TEST(GraphBuilder, AnotherActionStandsBesideTheFirstAndLeavesItAsItWas) {
  const auto both = testing::ModelOfTwoActions();
  const auto walk = testing::SmallModel();
  EXPECT_THAT(both->action_names(), ::testing::ElementsAre("walk", "run"));
  EXPECT_THAT(both->style_names(), ::testing::ElementsAre("brisk", "slow"));
  EXPECT_THAT(both->style_names("run"), ::testing::ElementsAre("brisk"));
  ASSERT_EQ(both->primitive_count(), walk->primitive_count() + 6);
  for (int p = 0; p < walk->primitive_count(); ++p) {
    const MotionPrimitive &alone = walk->primitive(p), &beside = both->primitive(p);
    EXPECT_EQ(beside.name, alone.name);
    EXPECT_EQ(beside.reduction.mean, alone.reduction.mean) << alone.name;
    EXPECT_EQ(beside.reduction.basis, alone.reduction.basis) << alone.name;
    EXPECT_EQ(beside.manner.captured, alone.manner.captured) << alone.name;
  }
  const GraphSummary summary = Summarise(*both);
  EXPECT_EQ(summary.format_version, 3);
  EXPECT_EQ(Summarise(*walk).format_version, 2);
  const PrimitiveSummary* run = Find(summary, "left_run", "brisk");
  ASSERT_NE(run, nullptr);
  EXPECT_EQ(run->action, "run");
  // Log maps of all actions of a style are about the same rotations; where its feet touch is each action's own.
  const auto& styles = both->styles();
  EXPECT_EQ(styles.back().mean_rotations.front().coeffs(), styles.front().mean_rotations.front().coeffs());
  for (int e = 0; e < both->edge_count(); ++e) {
    EXPECT_EQ(both->primitive(both->edge_from(e)).style_index, both->primitive(both->edge_to(e)).style_index);
  }
  // Steps of both are alike, so they lead into each other; by made steps, not by edges.
  ASSERT_EQ(summary.changes.size(), 4u);
  for (const ChangeSummary& change : summary.changes) {
    EXPECT_EQ(change.style, "brisk");
    EXPECT_NE(change.from_action, change.to_action);
    EXPECT_GT(change.near_examples, change.examples / 2) << change.name;
    EXPECT_LT(change.least.speed_m_s2, change.captured.speed_m_s2) << change.name;
  }
  EXPECT_THAT(summary.notes, Contains(HasSubstr("left_walk_to_run (brisk): made for ")));
  EXPECT_TRUE(walk->changes().empty());
  // The file keeps all of it.
  const auto read = ParseModel(SerialiseModel(*both), "file");
  EXPECT_EQ(read->hash(), both->hash());
  ASSERT_EQ(read->changes().size(), 4u);
  EXPECT_EQ(read->changes()[1].name, both->changes()[1].name);
  EXPECT_EQ(read->changes()[1].captured.body_m_s2, both->changes()[1].captured.body_m_s2);
  EXPECT_THAT(read->action_names(), ::testing::ElementsAre("walk", "run"));
}

TEST(GraphBuilder, AnotherActionNeedsKeyFramesByFeature) {
  std::vector<TrainingClip> clips = testing::ClipsOfTwoActions();
  clips.back().other_action = "crawl";
  EXPECT_THROW(BuildGraph(clips, TrainingOptions()), DatasetError);
}

TEST(GraphBuilder, LearnsRunningBesideWalking) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const auto folder = testing::SharedData() / "bnr" / "dataset-2";
  const DatasetManifest manifest = ParseManifest(R"({"include": ["*_elderly_00*"], "actions": {"run": ["*_run_*"]}})", "set.json");
  std::vector<TrainingClip> clips;
  for (const LoadedClip& loaded : LoadDataset({folder / "walk", folder / "run"}, manifest).clips) {
    clips.push_back({.clip = loaded.clip, .other_action = loaded.other_action});
  }
  TrainingOptions options;
  options.jobs = 2;
  const GraphSummary summary = Summarise(*BuildGraph(clips, options));
  for (const std::string name : {"left_walk", "right_walk", "left_run", "right_run"}) {
    const PrimitiveSummary* primitive = Find(summary, name, "elderly");
    ASSERT_NE(primitive, nullptr) << name;
    EXPECT_FALSE(primitive->dead_end) << name;
    EXPECT_EQ(primitive->action, name.substr(name.find('_') + 1));
  }
  EXPECT_LT(Find(summary, "left_run", "elderly")->mean_duration_s, Find(summary, "left_walk", "elderly")->mean_duration_s);
}

TEST(GraphBuilder, LearnsRunning) {
  MORPHOGRAPH_REQUIRE_SHARED_DATA();
  const Dataset dataset = LoadDataset({testing::SharedData() / "bnr" / "dataset-2" / "run"});
  std::vector<TrainingClip> clips;
  std::set<std::string> styles;
  for (const LoadedClip& loaded : dataset.clips) {
    clips.push_back({loaded.clip, false});
    styles.insert(loaded.clip.style);
  }
  TrainingOptions options;
  options.action = "run";
  options.jobs = 2;
  const GraphSummary summary = Summarise(*BuildGraph(clips, options));
  for (const std::string& style : styles) {
    EXPECT_NE(Find(summary, "left_run", style), nullptr) << style;
    EXPECT_NE(Find(summary, "right_run", style), nullptr) << style;
  }
}

}  // namespace
}  // namespace morphograph
