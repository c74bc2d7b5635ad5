#include "services/history/job_history.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "proto/task.pb.h"
#include "services/job_service/job_migrations.h"
#include "services/job_service/job_store.h"
#include "services/platform/host/times/utc_time.h"
#include "tests/test_folder.h"

namespace intaglio::history {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class JobHistoryTest : public testing::Test {
 protected:
  JobHistoryTest() : path_(test::FreshFolder() / "jobs.db") {}
  void Keep(std::uint32_t number, const std::string& name, intaglio_JobState state,
            const std::string& ended_utc) {
    job_service::JobRecord job;
    job.number = number;
    job.uid = fmt::format("{}-abc", number);
    job.submission_uid = fmt::format("s{}", number);
    job.name = name;
    job.cell = number % 2 == 0 ? "left" : "right";
    job.material = "N-BK7";
    job.state = state;
    store().Keep(job);
    store().KeepVerdict(job.uid, "", "");
    SQLite::Database(path_.string(), SQLite::OPEN_READWRITE)
        .exec(fmt::format("UPDATE jobs SET ended_utc = '{}' WHERE number = {}", ended_utc,
                          number));
  }
  std::vector<std::uint32_t> Numbers(const Filter& filter) {
    const auto jobs = ReadHistory(path_, filter);
    EXPECT_TRUE(jobs.has_value()) << jobs.error().message;
    std::vector<std::uint32_t> numbers;
    for (const JobStatistics& job : jobs.value_or(std::vector<JobStatistics>())) {
      numbers.push_back(job.job());
    }
    return numbers;
  }
  job_service::JobStore& store() {
    if (!store_) store_ = std::make_unique<job_service::JobStore>(path_);
    return *store_;
  }
  fs::path path_;
  std::unique_ptr<job_service::JobStore> store_;
};

TEST_F(JobHistoryTest, AnswersByWhatIsAskedWhileTheServiceWrites) {
  Keep(1, "Cup of Anna", intaglio_JOB_DONE, "2026-11-20T23:59:59.999Z");
  Keep(2, "cup of Ben", intaglio_JOB_FAILED, "2026-11-21T00:00:00.000Z");
  Keep(3, "Knot", intaglio_JOB_CANCELLED, "2026-11-21T23:59:59.999Z");
  Keep(4, "Knot", intaglio_JOB_QUEUED, "");
  Keep(5, "100% of '_'", intaglio_JOB_DONE, "2026-11-19T10:00:00.000Z");
  EXPECT_THAT(Numbers({}), ElementsAre(5, 1, 2, 3)) << "by their end; 4 is still open";
  EXPECT_THAT(Numbers({.since = "2026-11-21"}), ElementsAre(2, 3));
  EXPECT_THAT(Numbers({.until = "2026-11-20"}), ElementsAre(5, 1)) << "until its end";
  EXPECT_THAT(Numbers({.since = "2026-11-20", .until = "2026-11-21T00:00"}),
              ElementsAre(1, 2));
  EXPECT_THAT(Numbers({.piece = "CUP"}), ElementsAre(1, 2));
  EXPECT_THAT(Numbers({.piece = "% of '_"}), ElementsAre(5)) << "no pattern";
  EXPECT_THAT(Numbers({.material = "n-bk7", .cell = "left"}), ElementsAre(2));
  EXPECT_THAT(Numbers({.material = "K8"}), IsEmpty());
  EXPECT_THAT(Numbers({.verdict = "unknown"}), ElementsAre(5, 1));
  EXPECT_THAT(Numbers({.verdict = "none"}), ElementsAre(2, 3));
  EXPECT_THAT(Numbers({.job = 4}), ElementsAre(4)) << "one is told whatever its state";
}

TEST_F(JobHistoryTest, GivesAJobBackAsItWasMade) {
  FrozenJob frozen;
  frozen.mutable_job()->set_name("cup");
  job_service::JobRecord job;
  job.number = 12;
  job.uid = "12-abc";
  job.submission_uid = "s12";
  job.frozen_job = frozen.SerializeAsString();
  store().Keep(job);
  EXPECT_EQ(ReadJob(path_, "12")->name(), "cup");
  EXPECT_EQ(ReadJob(path_, "12-abc")->name(), "cup");
  for (const char* other : {"1", "2", "012", "12-ab", "", "x' OR 1"}) {
    EXPECT_EQ(ReadJob(path_, other).error().code, ErrorCode::kNotFound) << other;
  }
}

TEST_F(JobHistoryTest, ReportsWhatATimeAndAVerdictAre) {
  for (const char* good : {"2026-11-21", "2026-11-21T15:30", "2026-11-21T15:30:00"}) {
    EXPECT_TRUE(CheckFilter({.since = good})) << good;
  }
  for (const char* bad : {"21.11.2026", "2026-11", "yesterday", "2026-11-21 15:30"}) {
    const auto checked = CheckFilter({.until = bad});
    ASSERT_FALSE(checked) << bad;
    EXPECT_THAT(checked.error().message, HasSubstr(bad));
    EXPECT_THAT(checked.error().message, HasSubstr("--until"));
    EXPECT_THAT(checked.error().message, HasSubstr("2026-11-21T15:30"));
  }
  const auto verdict = CheckFilter({.verdict = "bad"});
  ASSERT_FALSE(verdict);
  EXPECT_THAT(verdict.error().message,
              HasSubstr("good, good_with_warnings, not_good, none, unknown"));
}

TEST_F(JobHistoryTest, WhatIsNoHistoryIsAnErrorWithARemedy) {
  EXPECT_EQ(ReadHistory(path_, {}).error().code, ErrorCode::kNotFound);
  fs::create_directories(path_.parent_path());
  std::ofstream(path_) << std::string(4096, 'x');
  EXPECT_EQ(ReadHistory(path_, {}).error().code, ErrorCode::kUnreadable);
  fs::remove(path_);
  {
    SQLite::Database old(path_.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
    old.exec(job_service::kMigrations[0]);
    old.exec("PRAGMA user_version = 1");
  }
  const auto old = ReadHistory(path_, {});
  ASSERT_FALSE(old);
  EXPECT_EQ(old.error().code, ErrorCode::kUnreadable);
  EXPECT_THAT(old.error().message, HasSubstr("intaglio up"));
}

TEST(EstimateScore, IsOfTheJobsThatCanBeCompared) {
  const auto with_ratio = [](double ratio) {
    JobStatistics job;
    job.set_first_estimate_ratio(ratio);
    return job;
  };
  EXPECT_EQ(ScoreOf({with_ratio(0)}).jobs, 0u);
  const EstimateScore score =
      ScoreOf({with_ratio(1.2), with_ratio(0), with_ratio(0.9), with_ratio(1)});
  EXPECT_EQ(score.jobs, 3u);
  EXPECT_EQ(score.median_ratio, 1);
  EXPECT_EQ(score.min_ratio, 0.9);
  EXPECT_EQ(score.max_ratio, 1.2);
  EXPECT_EQ(ScoreOf({with_ratio(0.9), with_ratio(1.1)}).median_ratio, 1);
}

TEST(Progress, AtFirstThePlanAndThenThePaceReportsTheEnd) {
  const std::chrono::system_clock::time_point now{std::chrono::seconds(1'000'000'000)};
  JobStatistics job;
  job.set_engraving_utc("2001-09-09T01:40:00.000Z");
  job.set_estimated_s(100);
  AddProgress(job, 1, 100, 50, now);
  EXPECT_EQ(job.expected_end_utc(), host::UtcText(now + std::chrono::seconds(99)));
  AddProgress(job, 50, 100, 200, now);
  EXPECT_EQ(job.expected_end_utc(), "2001-09-09T01:50:00.000Z");
  EXPECT_EQ(job.progress_ratio(), 0.5);
  AddProgress(job, 50, 100, 0, now);
  EXPECT_EQ(job.expected_end_utc(), host::UtcText(now + std::chrono::seconds(50)))
      << "by the plan, because the pace is not known";
}

TEST_F(JobHistoryTest, APauseIsNoWorkInTheExpectedEnd) {
  Keep(1, "Cup", intaglio_JOB_PAUSED, "");
  store_.reset();
  // Half of it in 100 s of work, begun long ago.
  SQLite::Database(path_.string(), SQLite::OPEN_READWRITE)
      .exec(
          "UPDATE jobs SET engraving_utc = '2026-11-21T08:00:00.000Z' WHERE number = 1; "
          "INSERT OR REPLACE INTO stages (job_uid, stage, worker, done, done_count, "
          "total_count, elapsed_s) SELECT uid, 2, 's', 0, 50, 100, 100 FROM jobs");
  const auto jobs = ReadHistory(path_, {.job = 1});
  ASSERT_TRUE(jobs && jobs->size() == 1);
  const auto end = host::TimeOfUtc(jobs->front().expected_end_utc());
  ASSERT_TRUE(end);
  EXPECT_LT(*end, std::chrono::system_clock::now() + std::chrono::minutes(2));
}

// Without it the history of a cutter would have nothing but interruptions.
TEST_F(JobHistoryTest, MarksAreMadeInTheTimeOfTheirRuns) {
  Keep(1, "Plate", intaglio_JOB_DONE, "2026-11-21T09:00:00.000Z");
  store_.reset();
  SQLite::Database(path_.string(), SQLite::OPEN_READWRITE)
      .exec(
          "UPDATE jobs SET makes = 'marks', rate_hz = 0; "
          "INSERT OR REPLACE INTO stages (job_uid, stage, worker, done, done_count, "
          "total_count, elapsed_s) SELECT uid, 2, 'm', 1, 4, 4, 33.5 FROM jobs");
  const auto jobs = ReadHistory(path_, {.job = 1});
  ASSERT_TRUE(jobs && jobs->size() == 1);
  EXPECT_EQ(jobs->front().machining_s(), 33.5);
  EXPECT_EQ(jobs->front().estimate_ratio(), 0) << "not compared with any estimate";
}

}  // namespace
}  // namespace intaglio::history
