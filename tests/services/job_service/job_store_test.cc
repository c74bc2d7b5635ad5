#include "services/job_service/job_store.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "proto/task.pb.h"
#include "services/job_service/job_migrations.h"
#include "services/platform/host/times/utc_time.h"
#include "tests/services/job_service/job_store_rig.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

namespace fs = std::filesystem;

class JobStoreTest : public JobStoreRig {
 protected:
  JobStoreTest() : path_(test::FreshFolder() / "jobs.db") {}
  /// Empty, as that version made it.
  SQLite::Database OldDatabase(int version) {
    fs::create_directories(path_.parent_path());
    SQLite::Database old(path_.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
    for (int i = 0; i < version; ++i) {
      old.exec(kMigrations.at(static_cast<std::size_t>(i)));
    }
    old.exec(fmt::format("PRAGMA user_version = {}", version));
    return old;
  }
  static StoreError Refusal(const fs::path& path) {
    try {
      JobStore store(path);
    } catch (const StoreError& error) {
      return error;
    }
    ADD_FAILURE() << path << " is opened";
    return StoreError("", false);
  }

  fs::path path_;
};

TEST_F(JobStoreTest, CommandsOfAnOlderDatabaseStay) {
  OldDatabase(6).exec(
      "INSERT INTO commands VALUES ('1-abc', 4, 1, 'ann', '2026-11-01T00:00:00.000Z')");
  EXPECT_TRUE(JobStore(path_).AnswerTo("1-abc", 4).has_value());
}

TEST_F(JobStoreTest, TasksKeepTheirFirstEnd) {
  JobStore store(path_);
  TaskOrder order;
  order.worker = "w";
  order.stage = intaglio_STAGE_ENGRAVE;
  order.task = {"1-abc", 1, 0, 0};
  store.KeepTask(order);
  TaskView end;
  end.task = order.task;
  end.stage = intaglio_STAGE_ENGRAVE;
  end.state = intaglio_TASK_FAILED;
  end.worker = "had it before w took it up";
  EXPECT_FALSE(store.KeepTaskEnd(end, "of another life"));
  end.worker = "w";
  end.state = intaglio_TASK_DONE;
  EXPECT_TRUE(store.KeepTaskEnd(end, "outcome"));
  end.state = intaglio_TASK_FAILED;
  EXPECT_FALSE(store.KeepTaskEnd(end, ""));
  SQLite::Database database(path_.string());
  EXPECT_EQ(database.execAndGet("SELECT state FROM tasks").getInt(), intaglio_TASK_DONE);
  EXPECT_EQ(database.execAndGet("SELECT outcome FROM tasks").getString(), "outcome");
}

TEST_F(JobStoreTest, TasksOfAnOlderDatabaseAreTakenOver) {
  {
    // As version 1 made it.
    SQLite::Database old = OldDatabase(1);
    old.exec(
        "INSERT INTO tasks (job_uid, attempt, stage, worker, given_utc) VALUES "
        "('1-abc', 2, 0, 'd', 'then')");
  }
  JobStore store(path_);
  store.Keep(Record(1, intaglio_JOB_DISCRETIZING));
  const auto parts = store.Load(0).at(0).parts;
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].worker, "d");
}

TEST_F(JobStoreTest, JobsOfAnOlderDatabaseHaveAHistory) {
  FrozenJob frozen;
  frozen.mutable_job()->set_glass("K8");
  {
    SQLite::Database old = OldDatabase(2);
    SQLite::Statement insert(
        old,
        "INSERT INTO jobs VALUES (1, '1-abc', 's1', 1, 'cup', 'els-03', 100, '/r', ?, ?, "
        "1, 2, 0, '', 0, 1, 0, 1, '2026-01-02T03:04:05.678Z')");
    const std::string bytes = frozen.SerializeAsString();
    insert.bind(1, bytes.data(), static_cast<int>(bytes.size()));
    insert.bind(2, static_cast<int>(intaglio_JOB_DONE));
    insert.exec();
    SQLite::Statement task(
        old,
        "INSERT INTO tasks VALUES ('1-abc', 2, 2, 0, 0, 'y', '2026-01-02T03:00:00.000Z', "
        "NULL, NULL, 3, '', ?)");
    const std::string outcome = Outcome(7, 7);
    task.bind(1, outcome.data(), static_cast<int>(outcome.size()));
    task.exec();
  }
  JobStore store(path_);
  const JobStatistics statistics =
      store.StatisticsOf(store.Load(1).at(0), std::chrono::system_clock::now());
  EXPECT_EQ(statistics.material(), "K8");
  EXPECT_EQ(statistics.verdict(), "good");
  EXPECT_EQ(statistics.planned(), 7u);
  EXPECT_EQ(statistics.ended_utc(), "2026-01-02T03:04:05.678Z");
  EXPECT_NEAR(statistics.duration_s(), 245.678, 0.002);
}

// Version 7 knew why a job is paused from its message alone.
TEST_F(JobStoreTest, PausedJobsOfAnOlderDatabaseGetTheirReason) {
  struct Old {
    intaglio_JobState state;
    const char* message;
    intaglio_PauseReason reason;
  };
  constexpr Old kOld[] = {
      {intaglio_JOB_PAUSED, "paused by ann@shop; resume it to continue",
       intaglio_PAUSE_OPERATOR},
      {intaglio_JOB_PAUSED, "the door is open: close it, then resume",
       intaglio_PAUSE_FAULT},
      {intaglio_JOB_ENGRAVING, "", intaglio_PAUSE_NONE},
      {intaglio_JOB_WAITING_FOR_ARM, "paused by ann@shop", intaglio_PAUSE_NONE}};
  {
    SQLite::Database old = OldDatabase(7);
    int number = 0;
    for (const Old& job : kOld) {
      SQLite::Statement insert(
          old,
          "INSERT INTO jobs (number, uid, submission_uid, epoch, name, cell, rate_hz, "
          "result_directory, frozen_job, state, ended, attempt, lost_attempts, message, "
          "estimate_ticks, revision, last_command, ever_granted, changed_utc) VALUES "
          "(?1, ?2, ?2, 1, 'cup', 'c', 100, '/r', '', ?3, 0, 1, 0, ?4, 0, 1, 0, 1, '')");
      insert.bind(1, ++number);
      insert.bind(2, fmt::format("{}-abc", number));
      insert.bind(3, static_cast<int>(job.state));
      insert.bind(4, job.message);
      insert.exec();
    }
  }
  const auto jobs = JobStore(path_).Load(0);
  ASSERT_EQ(jobs.size(), std::size(kOld));
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    EXPECT_EQ(jobs[i].state, kOld[i].state);
    EXPECT_EQ(jobs[i].pause_reason, kOld[i].reason) << kOld[i].message;
    EXPECT_EQ(jobs[i].message, kOld[i].message);
  }
}

TEST_F(JobStoreTest, ADatabaseOfANewerProgramIsRefused) {
  { JobStore store(path_); }
  {
    SQLite::Database(path_.string(), SQLite::OPEN_READWRITE)
        .exec("PRAGMA user_version = 99");
  }
  EXPECT_FALSE(Refusal(path_).passes());
}

// What may be there later is waited for, what is something else is not.
TEST_F(JobStoreTest, WhatIsNoDatabaseIsRefused) {
  const StoreError no_folder = Refusal("/proc/nowhere/jobs.db");
  EXPECT_TRUE(no_folder.passes());
  EXPECT_THAT(no_folder.what(), testing::HasSubstr("/proc/nowhere/jobs.db"));
  EXPECT_THAT(no_folder.what(), testing::HasSubstr("free space"));

  fs::create_directories(path_);
  const StoreError folder = Refusal(path_);
  EXPECT_FALSE(folder.passes());
  EXPECT_THAT(folder.what(), testing::HasSubstr("it is a folder"));

  fs::remove(path_);
  std::ofstream(path_) << std::string(4096, 'x');
  const StoreError text = Refusal(path_);
  EXPECT_FALSE(text.passes());
  EXPECT_THAT(text.what(), testing::HasSubstr("--database"));

  fs::remove(path_);
  {
    SQLite::Database(path_.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)
        .exec("CREATE TABLE jobs (of TEXT)");
  }
  EXPECT_FALSE(Refusal(path_).passes()) << "another program's";
}

}  // namespace
}  // namespace intaglio::job_service
