#include "services/history/write_ahead_log.h"

#include <gmock/gmock.h>

#include <fstream>

#include "services/history/job_history.h"
#include "services/job_service/job_store.h"
#include "tests/test_folder.h"

namespace intaglio::history {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// The database of a job service that was killed with six jobs.
class WriteAheadLog : public testing::Test {
 protected:
  void SetUp() override {
    const fs::path folder = test::FreshFolder();
    job_service::JobStore store(folder / "live.db");
    for (std::uint32_t i = 1; i <= 6; ++i) {
      job_service::JobRecord job;
      job.number = i;
      job.uid = job.submission_uid = std::to_string(i);
      store.Keep(job);
    }
    file_ = folder / "jobs.db";
    log_ = folder / "jobs.db-wal";
    fs::copy_file(folder / "live.db", file_);
    fs::copy_file(folder / "live.db-wal", log_);
  }
  void Damage(std::uint64_t at) {
    std::fstream log(log_, std::ios::in | std::ios::out | std::ios::binary);
    log.seekg(static_cast<std::streamoff>(at));
    const char byte = static_cast<char>(log.get() ^ 0x40);
    log.seekp(static_cast<std::streamoff>(at));
    log.put(byte);
  }
  std::string Refusal() {
    try {
      job_service::JobStore store(file_);
      ADD_FAILURE() << "it was opened with " << store.Load(100).size() << " jobs";
    } catch (const job_service::StoreError& error) {
      EXPECT_FALSE(error.passes());
      return error.what();
    }
    return "";
  }

  fs::path file_, log_;
};

TEST_F(WriteAheadLog, AnIntactOneIsReadToItsEnd) {
  EXPECT_TRUE(CheckWriteAheadLog(file_).has_value());
  EXPECT_EQ(job_service::JobStore(file_).Load(100).size(), 6u);
}

TEST_F(WriteAheadLog, DamageInItIsReportedAndNoEmptyQueue) {
  Damage(fs::file_size(log_) / 3);
  const std::string refusal = Refusal();
  EXPECT_THAT(refusal, HasSubstr(log_.string() + " is damaged"));
  EXPECT_THAT(refusal, HasSubstr("put an intact copy"));
  EXPECT_TRUE(fs::exists(log_)) << "nothing is changed";
}

// In a shop that is closed it is as if the jobs had never been.
TEST_F(WriteAheadLog, ItIsReportedToWhoReadsAsWell) {
  EXPECT_TRUE(ReadHistory(file_, {}).has_value());
  Damage(fs::file_size(log_) / 3);
  const auto jobs = ReadHistory(file_, {});
  ASSERT_FALSE(jobs.has_value());
  EXPECT_THAT(jobs.error().message, HasSubstr("is damaged"));
  const auto job = ReadJob(file_, "1");
  ASSERT_FALSE(job.has_value());
  EXPECT_THAT(job.error().message, HasSubstr("is damaged")) << "and not: no job '1'";
  EXPECT_TRUE(fs::exists(log_));
}

TEST_F(WriteAheadLog, ADamagedHeaderIsReported) {
  Damage(17);
  EXPECT_THAT(Refusal(), HasSubstr("is damaged (its header)"));
}

// A loss of power in the middle of a write.
TEST_F(WriteAheadLog, ATornLastChangeIsNoDamage) {
  fs::resize_file(log_, fs::file_size(log_) - 100);
  EXPECT_TRUE(CheckWriteAheadLog(file_).has_value());
  EXPECT_EQ(job_service::JobStore(file_).Load(100).size(), 5u);
}

TEST_F(WriteAheadLog, NoneIsIntact) {
  fs::remove(log_);
  EXPECT_TRUE(CheckWriteAheadLog(file_).has_value());
}

}  // namespace
}  // namespace intaglio::history
