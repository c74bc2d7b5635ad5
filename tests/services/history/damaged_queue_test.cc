// A queue whose file is damaged, wherever: all jobs are there, or the damage is reported
// with the remedy; never fewer jobs.

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "services/history/job_database.h"
#include "services/history/job_history.h"
#include "services/job_service/job_store.h"
#include "tests/test_folder.h"

namespace intaglio::history {
namespace {

namespace fs = std::filesystem;
using ::testing::AnyOf;
using ::testing::HasSubstr;

constexpr std::uint32_t kJobs = 60;
constexpr std::size_t kPage = 4096;

std::string BytesIn(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void PutBytes(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
}

class DamagedQueueTest : public testing::Test {
 protected:
  void SetUp() override {
    {
      job_service::JobStore store(file_);
      (void)store.BeginRun();
      for (std::uint32_t i = 1; i <= kJobs; ++i) {
        job_service::JobRecord job;
        job.number = i;
        job.uid = std::to_string(i) + "-abcdef";
        job.submission_uid = "s" + std::to_string(i);
        job.name = "a piece of glass";
        job.frozen_job = std::string(700, 'f');
        if (i % 2 == 0) job.state = intaglio_JOB_DONE;
        store.Keep(job);
      }
    }
    intact_ = BytesIn(file_);
    ASSERT_GT(intact_.size(), 10 * kPage);
    ASSERT_FALSE(fs::exists(file_.string() + "-wal")) << "all is in the file";
  }

  /// What the job service's store reports; empty: it has all jobs.
  std::string ReportOfStore() {
    try {
      job_service::JobStore store(file_);
      const std::size_t found = store.Load(1000).size();
      return found == kJobs ? "" : "fewer jobs: " + std::to_string(found);
    } catch (const job_service::StoreError& error) {
      EXPECT_FALSE(error.passes()) << error.what();
      return error.what();
    }
  }
  /// What the readers report; empty: all ended jobs are found, each by its number.
  std::string ReportOfHistory() {
    const auto jobs = ReadHistory(file_, {});
    if (!jobs) return jobs.error().message;
    if (jobs->size() != kJobs / 2) return "fewer jobs: " + std::to_string(jobs->size());
    for (std::uint32_t i = 1; i <= kJobs; ++i) {
      const auto job = ReadJob(file_, std::to_string(i));
      if (!job && job.error().code == ErrorCode::kNotFound) return job.error().message;
    }
    return "";
  }
  static void ExpectTrue(const std::string& report, const std::string& where) {
    if (report.empty()) return;
    EXPECT_THAT(report, AnyOf(HasSubstr("is damaged"), HasSubstr("no SQLite database")))
        << where;
    EXPECT_THAT(report, HasSubstr("intaglio restore")) << where;
  }

  fs::path folder_ = test::FreshFolder();
  fs::path file_ = folder_ / "jobs.db";
  std::string intact_;
};

TEST_F(DamagedQueueTest, APageWithoutItsContentIsReported) {
  int reported = 0;
  for (std::size_t page = 0; page * kPage < intact_.size(); ++page) {
    for (const char fill : {'\0', '\xff', 'x'}) {
      std::string bytes = intact_;
      std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(page * kPage), kPage, fill);
      PutBytes(file_, bytes);
      const std::string where = "page " + std::to_string(page + 1);
      // A reader may see less damage than the check of the job service.
      const std::string by_history = ReportOfHistory();
      if (by_history.find("fewer") == std::string::npos) ExpectTrue(by_history, where);
      const std::string report = ReportOfStore();
      ExpectTrue(report, where);
      if (!report.empty()) ++reported;
      EXPECT_EQ(BytesIn(file_), bytes) << "nothing was changed";
    }
  }
  EXPECT_GT(reported, static_cast<int>(intact_.size() / kPage));
}

TEST_F(DamagedQueueTest, ACutFileIsReported) {
  for (std::size_t size = kPage / 2; size + 1 < intact_.size(); size += kPage / 2 + 7) {
    PutBytes(file_, intact_.substr(0, size));
    const std::string report = ReportOfStore();
    EXPECT_NE(report, "") << size;
    ExpectTrue(report, "cut at " + std::to_string(size));
    const std::string by_history = ReportOfHistory();
    EXPECT_NE(by_history, "") << size;
    ExpectTrue(by_history, "cut at " + std::to_string(size));
  }
}

TEST_F(DamagedQueueTest, AnEmptyFileThatWasInUseIsNoNewQueue) {
  PutBytes(file_.string() + ".seen", "boot 12");
  PutBytes(file_, "");
  ExpectTrue(ReportOfStore(), "empty");
  EXPECT_THAT(ReportOfStore(), HasSubstr("was in use before"));
  EXPECT_EQ(fs::file_size(file_), 0u);
}

// SQLite removes a log without its file, and with it all that it has.
TEST_F(DamagedQueueTest, ALogWithoutItsFileIsKept) {
  PutBytes(file_.string() + "-wal", std::string(5000, 'w'));
  for (const bool empty : {true, false}) {
    fs::remove(file_);
    if (empty) PutBytes(file_, "");
    EXPECT_THAT(ReportOfStore(), HasSubstr("its log is there"));
    EXPECT_THAT(ReportOfHistory(), HasSubstr("its log is there"));
    EXPECT_EQ(fs::file_size(file_.string() + "-wal"), 5000u);
  }
}

TEST_F(DamagedQueueTest, ADamagedHeaderOfOursIsNoForeignFile) {
  for (std::size_t at = 0; at < 100; ++at) {
    std::string bytes = intact_;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x55);
    PutBytes(file_, bytes);
    const std::string report = ReportOfStore();
    if (report.find("has version") != std::string::npos) continue;  // its own number
    if (at >= 68 && at < 72) {                                      // the mark itself
      EXPECT_THAT(report, HasSubstr("intaglio restore"));
      continue;
    }
    ExpectTrue(report, "header byte " + std::to_string(at));
    if (at < 16) {
      EXPECT_THAT(report, HasSubstr("is damaged"));
    }
  }
}

}  // namespace
}  // namespace intaglio::history
