// A shop with a hundred thousand past jobs: what its job service reads and holds, and how
// soon it is there. What is read is counted in bytes, by the system, so that a busy host
// changes nothing.

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>
#include <iostream>

#include "services/history/job_history.h"
#include "services/job_service/job_store.h"
#include "tests/services/job/test_job.h"
#include "tests/services/job_service/fake_shop.h"
#include "tests/services/job_service/past_jobs.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kFew = 1'000, kMany = 100'000;
// The sample job, frozen, has 2.4 kB.
constexpr std::uint32_t kFrozenBytes = 2'500;

/// Bytes that this process has read so far, from a disk or the system's memory of it.
std::uint64_t BytesRead() {
  std::ifstream io("/proc/self/io");
  std::string name;
  std::uint64_t value = 0;
  while (io >> name >> value) {
    if (name == "rchar:") return value;
  }
  return 0;
}

template <typename Body>
std::uint64_t BytesReadBy(Body&& body) {
  const std::uint64_t before = BytesRead();
  body();
  return BytesRead() - before;
}

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// The resident memory of a process, MB.
double ResidentOf(int pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/statm");
  long pages = 0, resident = 0;
  in >> pages >> resident;
  return static_cast<double>(resident * sysconf(_SC_PAGESIZE)) / 1e6;
}

class LongPast : public testing::Test {
 protected:
  LongPast() : folder_(test::FreshFolder()) {
    AddPastJobs(Database(kFew), kFew, kFrozenBytes);
    AddPastJobs(Database(kMany), kMany, kFrozenBytes);
  }
  ~LongPast() override { fs::remove_all(folder_); }
  fs::path Database(std::uint32_t count) const { return Folder(count) / "jobs.db"; }
  fs::path Folder(std::uint32_t count) const { return folder_ / std::to_string(count); }
  /// Not much more is read of a hundred times as many jobs. The trees of the tables are
  /// one level deeper, and a page has 4 kB.
  void ExpectBounded(const char* what,
                     const std::function<void(const fs::path&)>& body) const {
    const std::uint64_t few = BytesReadBy([&] { body(Database(kFew)); });
    const std::uint64_t many = BytesReadBy([&] { body(Database(kMany)); });
    std::cout << "  " << what << ": " << few / 1000 << " kB of " << kFew << " jobs, "
              << many / 1000 << " kB of " << kMany << "\n";
    EXPECT_LT(many, 2 * few + 500'000) << what;
  }
  void StartReadsTheNewestJobsAlone() const;
  void AJobReadsItsOwnRowsAlone() const;
  void HistoryReadsWhatItIsAskedForAlone() const;
  void AgainReadsItsOwnJobAlone() const;
  void AllOfItIsReadInSeconds() const;
  void AJobServiceIsSoonThereAndSmall() const;

  fs::path folder_;
};

void LongPast::StartReadsTheNewestJobsAlone() const {
  ExpectBounded("a start", [](const fs::path& database) {
    JobStore store(database);
    store.BeginRun();
    EXPECT_EQ(store.Load(kRememberedJobs).size(), kRememberedJobs);
  });
}

void LongPast::AJobReadsItsOwnRowsAlone() const {
  ExpectBounded("a job", [](const fs::path& database) {
    JobStore store(database);
    EXPECT_FALSE(store.OutcomeOf("new"));
    JobRecord job;
    job.number = store.NextNumber();
    job.uid = "new";
    job.submission_uid = "new";
    store.Keep(job);
    job.state = intaglio_JOB_DONE;
    store.Keep(job);
    store.KeepVerdict(job.uid, "", "");
    EXPECT_EQ(store.StatisticsOf(job, std::chrono::system_clock::now()).state(), "done");
    EXPECT_TRUE(store.LoadEnded("new"));
    SQLite::Database cleanup(database.string(), SQLite::OPEN_READWRITE);
    cleanup.exec("DELETE FROM stages WHERE job_uid = 'new'");
    cleanup.exec("DELETE FROM jobs WHERE uid = 'new'");
    cleanup.exec("DELETE FROM submissions WHERE submission_uid = 'new'");
  });
}

void LongPast::HistoryReadsWhatItIsAskedForAlone() const {
  ExpectBounded("history --job", [](const fs::path& database) {
    history::Filter filter;
    filter.job = 500;
    EXPECT_EQ(history::ReadHistory(database, filter)->size(), 1u);
  });
  // From 2020-01-01T12:00 on a job ended each minute.
  ExpectBounded("history of an hour", [](const fs::path& database) {
    history::Filter filter;
    filter.since = filter.until = "2020-01-01T12";
    EXPECT_TRUE(history::CheckFilter(filter).has_value());
    EXPECT_EQ(history::ReadHistory(database, filter)->size(), 60u);
  });
}

// Also the newest, and one that there is not.
void LongPast::AgainReadsItsOwnJobAlone() const {
  for (const std::string job : {"1000", "1000-abc"}) {
    ExpectBounded("again", [&job](const fs::path& database) {
      EXPECT_EQ(history::ReadJob(database, job).error().code, ErrorCode::kUnreadable)
          << "found, and no real job";
    });
  }
  for (const std::string job : {"200000", "7-nobody", "", "0", "99999999999999999999"}) {
    ExpectBounded("again of none", [&job](const fs::path& database) {
      EXPECT_EQ(history::ReadJob(database, job).error().code, ErrorCode::kNotFound);
    });
  }
}

void LongPast::AllOfItIsReadInSeconds() const {
  const auto began = Clock::now();
  const auto jobs = history::ReadHistory(Database(kMany), {});
  ASSERT_TRUE(jobs);
  EXPECT_EQ(jobs->size(), kMany);
  std::cout << "  the whole history in " << SecondsSince(began) << " s\n";
  EXPECT_LT(SecondsSince(began), 60);
}

// The figures of a quiet machine: docs/measurements.md. The bound on the time is wide
// because other tests run beside this one.
void LongPast::AJobServiceIsSoonThereAndSmall() const {
  const auto began = Clock::now();
  ServiceProcess service(Folder(kMany), test::PrivateTag());
  FakeShop shop{test::PrivateBusOptions()};
  ASSERT_TRUE(shop.Until([&] { return shop.status_count() >= kRememberedJobs; }));
  const double there_s = SecondsSince(began);
  // The newest are those that are listed.
  EXPECT_EQ(shop.Status("s" + std::to_string(kMany)).state, intaglio_JOB_DONE);
  EXPECT_EQ(shop.Status("s1").uid, "");
  shop.Submit("one", GoodJob());
  ASSERT_TRUE(shop.Until([&] {
    return shop.Status("one").state == intaglio_JOB_QUEUED &&
           !shop.Status("one").uid.empty();
  }));
  EXPECT_THAT(shop.Status("one").uid,
              testing::StartsWith(std::to_string(kMany + 1) + "-"));
  const double resident_mb = ResidentOf(service.pid());
  std::cout << "  all told after " << there_s << " s, " << resident_mb << " MB\n";
  EXPECT_LT(there_s, 8);
  EXPECT_LT(resident_mb, 100);
  EXPECT_EQ(service.Stop(), 0);
}

// One case, because the past takes seconds to make and cases share nothing.
TEST_F(LongPast, CostsAsLittleAsAShortOne) {
  StartReadsTheNewestJobsAlone();
  AJobReadsItsOwnRowsAlone();
  HistoryReadsWhatItIsAskedForAlone();
  AgainReadsItsOwnJobAlone();
  AllOfItIsReadInSeconds();
  AJobServiceIsSoonThereAndSmall();
}

}  // namespace
}  // namespace intaglio::job_service
