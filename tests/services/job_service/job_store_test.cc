#include "services/job_service/job_store.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "proto/task.pb.h"
#include "services/job_service/job_migrations.h"
#include "services/platform/host/times/utc_time.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

namespace fs = std::filesystem;

class JobStoreTest : public testing::Test {
 protected:
  JobStoreTest() : path_(test::FreshFolder() / "jobs.db") {}
  static JobRecord Record(std::uint32_t number, intaglio_JobState state) {
    JobRecord job;
    job.number = number;
    job.uid = std::to_string(number) + "-abc";
    job.submission_uid = "s" + std::to_string(number);
    job.epoch = 0xabcdef0123456789;
    job.name = "a \"quoted\" name; DROP TABLE jobs";
    job.cell = "els-03";
    job.material = "N-BK7";
    job.priority = -3;
    job.rate_hz = 100;
    job.result_directory = "/results/" + job.uid;
    job.frozen_job = std::string("\0\1\2\xff", 4);
    job.state = state;
    job.attempt = 2;
    job.lost_attempts = 1;
    job.message = "two\nlines";
    job.estimate_ticks = 12345678901234;
    job.first_estimate_ticks = 12345678901235;
    job.stage(intaglio_STAGE_SORT) = {"sorter-1", true, 7, 8, 1.5};
    job.revision = 9;
    job.arm = JobArm({.ever_granted = true,
                      .disarm_count = 5,
                      .disarm_reason = "paused by ann",
                      .first_point = 17,
                      .fire_uncertain = true,
                      .last_command = 18446744073709551615u,
                      .last_command_id = "ann@shop-1/7"});
    job.pause_reason = intaglio_PAUSE_INTERLOCK;
    return job;
  }

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
  static TaskView EngraveEnd(intaglio_TaskState state) {
    TaskView end;
    end.task = {"1-abc", 2, 0, 0};
    end.stage = intaglio_STAGE_ENGRAVE;
    end.worker = "y";
    end.state = state;
    return end;
  }
  static std::string Outcome(std::uint64_t planned, std::uint64_t made) {
    StageOutcome outcome;
    outcome.mutable_engrave()->set_planned_count(planned);
    outcome.mutable_engrave()->set_made_count(made);
    outcome.mutable_engrave()->set_missed_count(planned - made);
    outcome.mutable_engrave()->set_used_ticks(2 * planned);
    outcome.mutable_engrave()->set_run_count(1);
    outcome.mutable_engrave()->set_min_speed_percent(100);
    return outcome.SerializeAsString();
  }
  static void GiveEngraving(JobStore& store) {
    TaskOrder order;
    order.worker = "y";
    order.stage = intaglio_STAGE_ENGRAVE;
    order.task = {"1-abc", 2, 0, 0};
    store.KeepTask(order);
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

TEST_F(JobStoreTest, KeepsTheFirstAnswerToACommandOfEachSender) {
  CommandView command;
  command.sender = "ann";
  command.number = 3;
  command.job_uid = "1-abc";
  JobStore(path_).KeepAnswer(command, {intaglio_ANSWER_NOT_YET, "it waits"});
  JobStore store(path_);
  store.KeepAnswer(command, {intaglio_ANSWER_TAKEN, ""});
  command.sender = "bob";
  store.KeepAnswer(command, {intaglio_ANSWER_TAKEN, ""});
  ASSERT_TRUE(store.AnswerTo("ann", 3).has_value());
  EXPECT_EQ(store.AnswerTo("ann", 3)->code, intaglio_ANSWER_NOT_YET);
  EXPECT_EQ(store.AnswerTo("ann", 3)->message, "it waits");
  EXPECT_TRUE(store.AnswerTo("bob", 3)->taken());
  EXPECT_FALSE(store.AnswerTo("ann", 4).has_value());
}

TEST_F(JobStoreTest, CommandsOfAnOlderDatabaseStay) {
  OldDatabase(6).exec(
      "INSERT INTO commands VALUES ('1-abc', 4, 1, 'ann', '2026-11-01T00:00:00.000Z')");
  EXPECT_TRUE(JobStore(path_).AnswerTo("1-abc", 4).has_value());
}

TEST_F(JobStoreTest, KeepsEveryFieldThatHasToLast) {
  const JobRecord kept = Record(1, intaglio_JOB_SORTING);
  JobStore(path_).Keep(kept);
  const auto loaded = JobStore(path_).Load(0);
  ASSERT_EQ(loaded.size(), 1u);
  const JobRecord& job = loaded[0];
  EXPECT_EQ(job.number, kept.number);
  EXPECT_EQ(job.uid, kept.uid);
  EXPECT_EQ(job.submission_uid, kept.submission_uid);
  EXPECT_EQ(job.epoch, kept.epoch);
  EXPECT_EQ(job.name, kept.name);
  EXPECT_EQ(job.cell, kept.cell);
  EXPECT_EQ(job.material, kept.material);
  EXPECT_EQ(job.priority, kept.priority);
  EXPECT_EQ(job.rate_hz, kept.rate_hz);
  EXPECT_EQ(job.result_directory, kept.result_directory);
  EXPECT_EQ(job.frozen_job, kept.frozen_job);
  EXPECT_EQ(job.state, kept.state);
  EXPECT_EQ(job.attempt, kept.attempt);
  EXPECT_EQ(job.lost_attempts, kept.lost_attempts);
  EXPECT_EQ(job.message, kept.message);
  EXPECT_EQ(job.estimate_ticks, kept.estimate_ticks);
  EXPECT_EQ(job.first_estimate_ticks, kept.first_estimate_ticks);
  const KeptArm& arm = job.arm.kept();
  EXPECT_EQ(arm.last_command, kept.arm.kept().last_command);
  EXPECT_TRUE(arm.ever_granted);
  EXPECT_EQ(arm.first_point, kept.arm.kept().first_point);
  EXPECT_TRUE(arm.fire_uncertain);
  EXPECT_EQ(arm.disarm_count, kept.arm.kept().disarm_count);
  EXPECT_EQ(arm.disarm_reason, kept.arm.kept().disarm_reason);
  EXPECT_EQ(arm.last_command_id, kept.arm.kept().last_command_id);
  EXPECT_EQ(job.pause_reason, kept.pause_reason);
  EXPECT_FALSE(arm.armed);
  EXPECT_GT(job.revision, kept.revision)
      << "what was published since the last Keep is older";
  const StageRecord& stage = job.stage(intaglio_STAGE_SORT);
  EXPECT_EQ(stage.worker, "sorter-1");
  EXPECT_TRUE(stage.done);
  EXPECT_EQ(stage.done_count, 7u);
  EXPECT_EQ(stage.total_count, 8u);
  EXPECT_EQ(stage.elapsed_s, 1.5);
}

TEST_F(JobStoreTest, ALaterKeepReplacesTheEarlier) {
  JobStore store(path_);
  JobRecord job = Record(1, intaglio_JOB_SORTING);
  store.Keep(job);
  job.state = intaglio_JOB_ENGRAVING;
  job.message = "";
  store.Keep(job);
  ASSERT_EQ(store.Load(0).size(), 1u);
  EXPECT_EQ(store.Load(0)[0].state, intaglio_JOB_ENGRAVING);
  EXPECT_EQ(store.Load(0)[0].message, "");
}

TEST_F(JobStoreTest, LoadsOpenJobsAndTheNewestEndedOnes) {
  JobStore store(path_);
  for (std::uint32_t n = 1; n <= 6; ++n) {
    store.Keep(Record(n, n == 2 ? intaglio_JOB_QUEUED : intaglio_JOB_DONE));
  }
  std::vector<std::uint32_t> numbers;
  for (const JobRecord& job : store.Load(2)) numbers.push_back(job.number);
  EXPECT_THAT(numbers, testing::ElementsAre(2, 5, 6));
  EXPECT_EQ(store.NextNumber(), 7u);
}

TEST_F(JobStoreTest, EndedJobsAreLoadedWithoutTheirFrozenJobs) {
  JobStore store(path_);
  store.Keep(Record(1, intaglio_JOB_QUEUED));
  store.Keep(Record(2, intaglio_JOB_DONE));
  const auto jobs = store.Load(10);
  ASSERT_EQ(jobs.size(), 2u);
  EXPECT_EQ(jobs[0].frozen_job.size(), 4u);
  EXPECT_EQ(jobs[1].frozen_job.size(), 0u);
  EXPECT_EQ(jobs[1].stage(intaglio_STAGE_SORT).worker, "sorter-1");
}

TEST_F(JobStoreTest, FindsAnEndedJobThatIsNotInMemory) {
  JobStore store(path_);
  store.Keep(Record(1, intaglio_JOB_PAUSED));
  store.Keep(Record(2, intaglio_JOB_CANCELLED));
  EXPECT_FALSE(store.LoadEnded("1-abc")) << "open";
  EXPECT_FALSE(store.LoadEnded("3-abc"));
  const auto job = store.LoadEnded("2-abc");
  ASSERT_TRUE(job);
  EXPECT_EQ(job->number, 2u);
  EXPECT_EQ(job->state, intaglio_JOB_CANCELLED);
  EXPECT_EQ(job->result_directory, "/results/2-abc");
}

TEST_F(JobStoreTest, EpochsGrowFromRunToRun) {
  std::uint64_t last = 0;
  for (int i = 0; i < 5; ++i) {
    const std::uint64_t epoch = JobStore(path_).BeginRun();
    EXPECT_GT(epoch, last);
    last = epoch;
  }
}

TEST_F(JobStoreTest, RemembersSubmissions) {
  JobStore store(path_);
  EXPECT_FALSE(store.OutcomeOf("s1"));
  store.Keep(Record(1, intaglio_JOB_QUEUED));
  EXPECT_EQ(store.OutcomeOf("s1"), "");
  store.KeepRefusal("s2", "glass: is missing");
  EXPECT_EQ(JobStore(path_).OutcomeOf("s2"), "glass: is missing");
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

TEST_F(JobStoreTest, LoadsThePartsThatAreHandedOut) {
  JobStore store(path_);
  store.Keep(Record(1, intaglio_JOB_DISCRETIZING));
  const auto give = [&store](std::uint32_t attempt, std::uint32_t part,
                             std::uint32_t part_attempt, const std::string& worker) {
    TaskOrder order;
    order.worker = worker;
    order.task = {"1-abc", attempt, part, part_attempt};
    store.KeepTask(order);
    return order;
  };
  give(1, 3, 0, "of an older attempt");
  TaskOrder lost = give(2, 0, 0, "lost");
  lost.revoked = true;
  store.KeepTask(lost);
  TaskView done;
  done.task = give(2, 1, 0, "done").task;
  done.worker = "done";
  done.state = intaglio_TASK_DONE;
  store.KeepTaskEnd(done, "");
  give(2, 0, 1, "again");
  give(2, 2, 0, "at work");
  const auto parts = JobStore(path_).Load(0).at(0).parts;
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts[0].worker, "again");
  EXPECT_EQ(parts[0].attempt, 1u);
  EXPECT_EQ(parts[1].worker, "");
  EXPECT_EQ(parts[2].worker, "at work");
  EXPECT_EQ(parts[2].attempt, 0u);
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

TEST_F(JobStoreTest, ReportsWhatBecameOfAJob) {
  JobStore store(path_);
  JobRecord job = Record(1, intaglio_JOB_QUEUED);
  job.attempt = 0;
  job.arm = JobArm();
  const auto now = std::chrono::system_clock::now();
  store.Keep(job);
  JobStatistics statistics = store.StatisticsOf(job, now);
  EXPECT_EQ(statistics.state(), "queued");
  EXPECT_NE(statistics.submitted_utc(), "");
  EXPECT_EQ(statistics.started_utc(), "");
  job.attempt = 2;
  job.arm.NoteGranted();
  job.state = intaglio_JOB_ENGRAVING;
  job.estimate_ticks = 400;
  job.first_estimate_ticks = 460;
  store.Keep(job);
  GiveEngraving(store);
  job.stage(intaglio_STAGE_ENGRAVE) = {"y", false, 25, 100, 1.0};
  const auto later = now + std::chrono::seconds(10);
  statistics = store.StatisticsOf(job, later);
  const std::string begun = statistics.engraving_utc();
  EXPECT_NE(begun, "");
  EXPECT_EQ(statistics.progress_ratio(), 0.25);
  EXPECT_EQ(statistics.made(), 25u);
  EXPECT_EQ(statistics.estimated_s(), 4);
  EXPECT_EQ(statistics.first_estimated_s(), 4.6);
  EXPECT_EQ(statistics.first_estimate_ratio(), 0) << "there is no outcome";
  // A quarter took one second: three are left.
  EXPECT_EQ(statistics.expected_end_utc(),
            host::UtcText(later + std::chrono::seconds(3)));
  EXPECT_EQ(statistics.verdict(), "");
  store.KeepTaskEnd(EngraveEnd(intaglio_TASK_DONE), Outcome(100, 100));
  job.state = intaglio_JOB_DONE;
  store.Keep(job);
  store.KeepVerdict(job.uid, "/r/report.json", "/r/all.mcap");
  statistics = store.StatisticsOf(job, later);
  EXPECT_EQ(statistics.verdict(), "good");
  EXPECT_EQ(statistics.made(), 100u);
  EXPECT_EQ(statistics.machining_s(), 2);
  EXPECT_EQ(statistics.undisturbed_s(), 2);
  EXPECT_EQ(statistics.estimate_ratio(), 2);
  EXPECT_EQ(statistics.first_estimate_ratio(), 2.3);
  EXPECT_EQ(statistics.engraving_utc(), begun) << "the first time stays";
  EXPECT_EQ(statistics.expected_end_utc(), "");
  EXPECT_EQ(statistics.report(), "/r/report.json");
  EXPECT_EQ(statistics.recording(), "/r/all.mcap");
}

// A cancelled job's synchronizer reports afterwards what it left in the glass.
TEST_F(JobStoreTest, TheLastReportOfTheMachineChangesTheVerdict) {
  JobStore store(path_);
  JobRecord job = Record(1, intaglio_JOB_ENGRAVING);
  store.Keep(job);
  GiveEngraving(store);
  job.state = intaglio_JOB_CANCELLED;
  store.Keep(job);
  store.KeepVerdict(job.uid, "", "");
  const auto now = std::chrono::system_clock::now();
  const JobStatistics before = store.StatisticsOf(job, now);
  EXPECT_EQ(before.verdict(), "none");
  store.KeepTaskEnd(EngraveEnd(intaglio_TASK_FAILED), Outcome(100, 40));
  store.KeepVerdict(job.uid, "", "");
  const JobStatistics after = store.StatisticsOf(job, now);
  EXPECT_EQ(after.verdict(), "not_good");
  EXPECT_EQ(after.made(), 40u);
  const JobResult result = store.ResultOf(job.uid);
  EXPECT_EQ(result.verdict, "not_good");
  EXPECT_EQ(result.counts.planned, 100u);
  EXPECT_EQ(result.counts.made, 40u);
  EXPECT_EQ(store.ResultOf("nobody").verdict, "");
  EXPECT_EQ(after.ended_utc(), before.ended_utc());
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
