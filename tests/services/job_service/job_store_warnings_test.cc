// Warnings and consents in the database, also in one from before there were any.

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "proto/task.pb.h"
#include "services/history/job_history.h"
#include "services/job/verdict/warnings.h"
#include "services/job_service/job_migrations.h"
#include "services/job_service/job_store.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::SizeIs;

const Warnings kWarnings = {MakeWarning(WarningCode::kOddRays, "3 of 9 rays"),
                            MakeWarning(WarningCode::kBreakage, "may break")};

JobRecord Job(intaglio_JobState state) {
  JobRecord job;
  job.number = 1;
  job.uid = "1-abc";
  job.submission_uid = "s";
  job.cell = "els-03";
  job.state = state;
  job.attempt = 1;
  job.arm = JobArm({.ever_granted = true, .breakage_accepted_by = "ann@shop"});
  job.warnings = kWarnings;
  return job;
}

TaskView Give(JobStore& store, intaglio_Stage stage, std::uint32_t part = 0,
              std::uint32_t part_attempt = 0) {
  TaskOrder order;
  order.worker = "w";
  order.stage = stage;
  order.task = {"1-abc", 1, part, part_attempt};
  store.KeepTask(order);
  TaskView view;
  view.task = order.task;
  view.stage = stage;
  view.worker = order.worker;
  view.state = intaglio_TASK_DONE;
  return view;
}

std::string PartOf(std::uint64_t point_count) {
  StageOutcome outcome;
  outcome.mutable_discretize()->set_point_count(point_count);
  return outcome.SerializeAsString();
}

TEST(JobStoreWarnings, AreKeptWithTheConsentAndDecideTheVerdict) {
  const fs::path path = test::FreshFolder() / "jobs.db";
  JobStore(path).Keep(Job(intaglio_JOB_ENGRAVING));
  JobStore store(path);
  const auto loaded = store.Load(0);
  ASSERT_THAT(loaded, SizeIs(1));
  EXPECT_EQ(loaded[0].warnings, kWarnings);
  EXPECT_EQ(loaded[0].arm.kept().breakage_accepted_by, "ann@shop");
  EXPECT_EQ(loaded[0].open_consent(), nullptr);

  const TaskView end = Give(store, intaglio_STAGE_ENGRAVE);
  StageOutcome outcome;
  outcome.mutable_engrave()->set_planned_count(5);
  outcome.mutable_engrave()->set_made_count(5);
  store.KeepTaskEnd(end, outcome.SerializeAsString());
  const JobRecord done = Job(intaglio_JOB_DONE);
  store.Keep(done);
  store.KeepVerdict(done.uid, "", "");
  const JobStatistics statistics =
      store.StatisticsOf(done, std::chrono::system_clock::now());
  EXPECT_EQ(statistics.verdict(), "good_with_warnings");
  EXPECT_EQ(WarningsOf(statistics.warnings()), kWarnings);
  EXPECT_EQ(statistics.breakage_accepted_by(), "ann@shop");
  const auto history = history::ReadHistory(path, {.verdict = "good_with_warnings"});
  ASSERT_TRUE(history);
  EXPECT_THAT(*history, SizeIs(1));
  EXPECT_TRUE(history::CheckFilter({.verdict = "good_with_warnings"}));
}

TEST(JobStoreWarnings, TheOutcomesOfAnAttemptAreThoseOfItsNewestParts) {
  JobStore store(test::FreshFolder() / "jobs.db");
  store.KeepTaskEnd(Give(store, intaglio_STAGE_DISCRETIZE, 1), PartOf(10));
  store.KeepTaskEnd(Give(store, intaglio_STAGE_DISCRETIZE, 0), PartOf(20));
  store.KeepTaskEnd(Give(store, intaglio_STAGE_DISCRETIZE, 1, 1), PartOf(11));
  TaskView failed = Give(store, intaglio_STAGE_DISCRETIZE, 2);
  failed.state = intaglio_TASK_FAILED;
  store.KeepTaskEnd(failed, PartOf(99));
  std::vector<std::uint64_t> counts;
  for (const DiscretizeOutcome& part : store.OutcomesOf("1-abc", 1).parts) {
    counts.push_back(part.point_count());
  }
  EXPECT_THAT(counts, ElementsAre(20u, 11u));
  EXPECT_FALSE(store.OutcomesOf("1-abc", 1).sort);
  StageOutcome sorted;
  sorted.mutable_sort()->set_point_count(31);
  store.KeepTaskEnd(Give(store, intaglio_STAGE_SORT), sorted.SerializeAsString());
  ASSERT_TRUE(store.OutcomesOf("1-abc", 1).sort);
  EXPECT_EQ(store.OutcomesOf("1-abc", 1).sort->point_count(), 31u);
  EXPECT_THAT(store.OutcomesOf("1-abc", 2).parts, SizeIs(0));
}

// A shop is updated in the middle of an engraving: nobody was asked then.
TEST(JobStoreWarnings, AJobOfAnOlderDatabaseHasNoneAndGoesOn) {
  const fs::path folder = test::FreshFolder();
  fs::create_directories(folder);
  const fs::path path = folder / "jobs.db";
  constexpr std::size_t kOlder = 8;
  {
    SQLite::Database old(path.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
    for (std::size_t i = 0; i < kOlder; ++i) old.exec(kMigrations.at(i));
    old.exec(fmt::format("PRAGMA user_version = {}", kOlder));
    old.exec(fmt::format(
        "INSERT INTO jobs (number, uid, submission_uid, epoch, name, cell, rate_hz, "
        "result_directory, frozen_job, state, ended, attempt, lost_attempts, message, "
        "estimate_ticks, revision, last_command, ever_granted, changed_utc) VALUES "
        "(1, '1-abc', 's', 1, 'cup', 'els-03', 100, '/r', x'', {}, 0, 1, 0, '', 0, 1, 1, "
        "1, '2026-01-02T03:04:05.678Z')",
        static_cast<int>(intaglio_JOB_ENGRAVING)));
  }
  const auto before = history::ReadHistory(path, {.job = 1});
  ASSERT_TRUE(before) << before.error().message;
  ASSERT_THAT(*before, SizeIs(1));
  EXPECT_EQ(before->at(0).warnings_size(), 0);
  const auto loaded = JobStore(path).Load(0);
  ASSERT_THAT(loaded, SizeIs(1));
  EXPECT_THAT(loaded[0].warnings, SizeIs(0));
  EXPECT_TRUE(loaded[0].may_be_granted());
}

}  // namespace
}  // namespace intaglio::job_service
