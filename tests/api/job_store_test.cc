#include "api/job_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/temporary_folder.h"

namespace morphograph {
namespace {

Job NewJob(const std::string& id) {
  Job job;
  job.id = id;
  job.model = "model-" + id;
  job.action = "walk";
  job.files = 3;
  job.created = "2026-01-02T03:04:05Z";
  return job;
}

TEST(JobStore, JobsSurviveTheProcess) {
  const testing::TemporaryFolder folder;
  const std::string path = (folder.path() / "jobs.db").string();
  {
    JobStore store("sqlite:" + path);
    for (const char* id : {"a", "b", "c"}) store.Insert(NewJob(id));
    Job job = NewJob("a");
    job.state = JobState::kSucceeded;
    job.detail = "it's \"done\"; DROP TABLE jobs";
    store.Update(job);
    job = NewJob("b");
    job.state = JobState::kRunning;
    job.progress = 0.5;
    store.Update(job);
  }
  JobStore store(path);
  EXPECT_EQ(store.Find("a")->state, JobState::kSucceeded);
  EXPECT_EQ(store.Find("a")->detail, "it's \"done\"; DROP TABLE jobs");
  EXPECT_EQ(store.Find("a")->created, "2026-01-02T03:04:05Z");
  // What ran when the process ended is begun anew, in its old place.
  EXPECT_EQ(store.Find("b")->state, JobState::kQueued);
  EXPECT_EQ(store.Find("b")->progress, 0);
  EXPECT_EQ(store.NextQueued()->id, "b");
  EXPECT_EQ(store.Count(JobState::kQueued), 2);
  EXPECT_FALSE(store.Find("d"));
  EXPECT_FALSE(store.Find("a' OR '1'='1"));
}

TEST(JobStore, KnowsAwaitedModelsAndForgetsOldJobs) {
  JobStore store("sqlite::memory:");
  for (const char* id : {"a", "b", "c"}) store.Insert(NewJob(id));
  EXPECT_TRUE(store.IsModelAwaited("model-a"));
  for (const char* id : {"a", "b"}) {
    Job job = NewJob(id);
    job.state = JobState::kCancelled;
    store.Update(job);
  }
  EXPECT_FALSE(store.IsModelAwaited("model-a"));
  store.Prune(2);
  EXPECT_FALSE(store.Find("a"));
  EXPECT_TRUE(store.Find("b"));
  EXPECT_TRUE(store.Find("c"));
}

TEST(JobStore, RefusesWhatItCannotOpen) {
  EXPECT_THROW(JobStore("postgres://host/db"), std::invalid_argument);
  EXPECT_THROW(JobStore("/nowhere/at/all/jobs.db"), std::runtime_error);
  const testing::TemporaryFolder folder;
  std::ofstream(folder.path() / "jobs.db") << "this is no database, and long enough to be told from an empty file" << std::string(500, 'x');
  EXPECT_THROW(JobStore((folder.path() / "jobs.db").string()), std::runtime_error);
}

}  // namespace
}  // namespace morphograph
