#include "services/backup/shop_backup.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <map>
#include <optional>

#include "proto/task.pb.h"
#include "services/history/job_history.h"
#include "services/history/restored_queue.h"
#include "services/job_service/job_store.h"
#include "tests/services/backup/file_bytes.h"
#include "tests/test_folder.h"

namespace intaglio::backup {
namespace {

namespace fs = std::filesystem;
using job_service::JobRecord;
using job_service::JobStore;
using ::testing::HasSubstr;

/// Reads all files but SQLite's index of its log, which readers write as well.
std::map<std::string, std::string> ContentsOf(const fs::path& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().string();
    if (entry.is_regular_file() && !name.ends_with("-shm"))
      contents[name] = BytesIn(entry.path());
  }
  return contents;
}

ShopPlaces PlacesIn(const fs::path& folder) {
  return {folder / "jobs.db", folder / "jobs", folder / "materials.db", folder};
}

class ShopBackupTest : public testing::Test {
 protected:
  void SetUp() override {
    PutBytes(shop_ / "jobs/1-a/journal.bin", "the journal");
    PutBytes(shop_ / "machine.textproto", "name: 'els-03'");
    PutBytes(shop_ / "machine.textproto.history/1.textproto", "older");
    PutBytes(shop_ / "glass.rec", "a recording is no part of it");
    SQLite::Database materials((shop_ / "materials.db").string(),
                               SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
    materials.exec("CREATE TABLE glasses (name TEXT); INSERT INTO glasses VALUES ('K9')");
    store_.emplace(shop_ / "jobs.db");
    (void)store_->BeginRun();
    for (std::uint32_t i = 1; i <= 4; ++i) {
      JobRecord job;
      job.number = i;
      job.uid = std::to_string(i) + "-a";
      job.submission_uid = "s" + std::to_string(i);
      job.result_directory = (shop_ / "jobs" / job.uid).string();
      FrozenJob frozen;
      frozen.set_result_directory(job.result_directory);
      job.frozen_job = frozen.SerializeAsString();
      job.state = i == 1 ? intaglio_JOB_DONE : intaglio_JOB_WAITING_FOR_ARM;
      job_service::KeptArm arm;
      arm.armed = i > 1;
      arm.ever_granted = i < 3;
      job.arm = job_service::JobArm(arm);
      store_->Keep(job);
    }
  }
  void BackUpNow() {
    const auto made = BackUp(PlacesIn(shop_), {}, file_);
    ASSERT_TRUE(made.has_value()) << made.error().message;
  }
  Result<std::vector<fs::path>> RestoreTo(const fs::path& folder, bool replace = false,
                                          const Parts& without = {}) {
    auto archive = Archive::Open(file_);
    if (!archive) return tl::unexpected(archive.error());
    return Restore(*archive, {PlacesIn(folder), without, replace});
  }

  fs::path folder_ = test::FreshFolder();
  fs::path shop_ = folder_ / "shop", other_ = folder_ / "other";
  fs::path file_ = folder_ / "shop.backup";
  std::optional<JobStore> store_;  // an open shop, whose queue is in its log
};

TEST_F(ShopBackupTest, OfAnOpenShopHasAllItsJobs) {
  ASSERT_GT(fs::file_size(shop_ / "jobs.db-wal"), 0u);
  const auto before = ContentsOf(shop_);
  BackUpNow();
  EXPECT_TRUE(ContentsOf(shop_) == before) << "it changes nothing";
  const auto archive = Archive::Open(file_);
  std::vector<std::string> names;
  for (const ArchivedFile& file : archive->files()) names.push_back(file.name);
  EXPECT_THAT(names,
              testing::ElementsAre("queue/jobs.db", "jobs/1-a/journal.bin",
                                   "materials/materials.db", "machines/machine.textproto",
                                   "machines/machine.textproto.history/1.textproto"));
  ASSERT_TRUE(RestoreTo(other_).has_value());
  JobStore restored(other_ / "jobs.db");
  EXPECT_EQ(restored.Load(10).size(), 4u);
  EXPECT_EQ(BytesIn(other_ / "jobs/1-a/journal.bin"), "the journal");
  EXPECT_EQ(BytesIn(other_ / "machine.textproto.history/1.textproto"), "older");
  EXPECT_EQ(SQLite::Database((other_ / "materials.db").string())
                .execAndGet("SELECT name FROM glasses")
                .getString(),
            "K9");
}

// What was made after the backup is unknown: nothing may be made twice, nor by itself.
TEST_F(ShopBackupTest, NothingOfARestoredQueueFiresByItself) {
  BackUpNow();
  ASSERT_TRUE(RestoreTo(other_).has_value());
  JobStore restored(other_ / "jobs.db");
  const auto jobs = restored.Load(10);
  ASSERT_EQ(jobs.size(), 4u);
  for (const JobRecord& job : jobs) {
    EXPECT_FALSE(job.number > 1 && job.arm.armed()) << job.number;
    EXPECT_EQ(job.result_directory, (other_ / "jobs" / job.uid).string());
  }
  EXPECT_EQ(jobs[0].state, intaglio_JOB_DONE);
  EXPECT_EQ(jobs[1].state, intaglio_JOB_FAILED) << "it had begun";
  EXPECT_THAT(jobs[1].message, HasSubstr("what was made after it is unknown"));
  EXPECT_EQ(jobs[2].state, intaglio_JOB_WAITING_FOR_ARM);
  FrozenJob frozen;
  ASSERT_TRUE(frozen.ParseFromString(jobs[2].frozen_job));
  EXPECT_EQ(frozen.result_directory(), jobs[2].result_directory);
}

TEST_F(ShopBackupTest, WithTheJournalsOfTodayABegunJobGoesOnWithAPerson) {
  BackUpNow();
  store_.reset();
  ASSERT_TRUE(RestoreTo(shop_, true, {"jobs", "materials", "machines"}).has_value());
  const auto jobs = JobStore(shop_ / "jobs.db").Load(10);
  EXPECT_EQ(jobs.at(1).state, intaglio_JOB_WAITING_FOR_ARM);
  EXPECT_FALSE(jobs.at(1).arm.armed());
}

TEST_F(ShopBackupTest, AnExistingShopIsNotReplacedWithoutTheOption) {
  BackUpNow();
  store_.reset();
  PutBytes(shop_ / "jobs/2-a/journal.bin", "newer");
  const auto before = ContentsOf(shop_);
  const auto refused = RestoreTo(shop_);
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message, HasSubstr("is there already"));
  EXPECT_THAT(refused.error().message, HasSubstr((shop_ / "jobs.db").string()));
  EXPECT_THAT(refused.error().message, HasSubstr("--replace"));
  EXPECT_TRUE(ContentsOf(shop_) == before);
  const auto kept = RestoreTo(shop_, true);
  ASSERT_TRUE(kept.has_value()) << kept.error().message;
  EXPECT_FALSE(fs::exists(shop_ / "jobs/2-a"));
  bool found = false;
  for (const fs::path& path : *kept)
    found = found || BytesIn(path / "2-a/journal.bin") == "newer";
  EXPECT_TRUE(found) << "nothing is lost";
}

// As the process of a job service has it: this process's own locks do not count.
TEST_F(ShopBackupTest, AnOpenQueueIsNotReplaced) {
  BackUpNow();
  store_.reset();
  int ready[2], end[2];
  ASSERT_EQ(pipe(ready), 0);
  ASSERT_EQ(pipe(end), 0);
  const pid_t child = fork();
  if (child == 0) {
    JobStore open(shop_ / "jobs.db");
    (void)open.BeginRun();
    char byte = 'r';
    (void)!write(ready[1], &byte, 1);
    (void)!read(end[0], &byte, 1);
    _exit(0);
  }
  char byte = 0;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  EXPECT_EQ(history::ProcessWith(shop_ / "jobs.db"), child);
  const auto before = ContentsOf(shop_);
  const auto refused = RestoreTo(shop_, true);
  EXPECT_TRUE(ContentsOf(shop_) == before);
  ASSERT_EQ(write(end[1], &byte, 1), 1);
  waitpid(child, nullptr, 0);
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message, HasSubstr("close that shop"));
  EXPECT_EQ(history::ProcessWith(shop_ / "jobs.db"), 0);
}

TEST_F(ShopBackupTest, ADamagedOneChangesNothing) {
  BackUpNow();
  store_.reset();
  std::string bytes = BytesIn(file_);
  const std::size_t at = bytes.find("the journal");
  ASSERT_NE(at, std::string::npos);
  bytes[at] = 'T';
  PutBytes(file_, bytes);
  const auto before = ContentsOf(folder_);
  const auto refused = RestoreTo(shop_, true);
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message, HasSubstr("is damaged (jobs/1-a/journal.bin)"));
  EXPECT_TRUE(ContentsOf(folder_) == before);
}

TEST_F(ShopBackupTest, ADiskThatRefusesChangesNothing) {
  BackUpNow();
  store_.reset();
  PutBytes(shop_ / "jobs.db.restoring/in the way", "x");
  PutBytes(folder_ / "no folder", "x");
  ShopPlaces places = PlacesIn(shop_);
  places.machines = folder_ / "no folder" / "machines";
  const auto before = ContentsOf(shop_ / "jobs");
  const auto archive = Archive::Open(file_);
  EXPECT_FALSE(Restore(*archive, {places, {}, true}).has_value());
  EXPECT_TRUE(ContentsOf(shop_ / "jobs") == before);
  EXPECT_FALSE(fs::exists(shop_ / "jobs.restoring"));
  EXPECT_EQ(JobStore(shop_ / "jobs.db").Load(10).size(), 4u);
}

TEST_F(ShopBackupTest, ADamagedQueueIsNotBackedUp) {
  store_.reset();
  std::string bytes = BytesIn(shop_ / "jobs.db");
  bytes.replace(4096 * 3, 4096, std::string(4096, 'x'));
  PutBytes(shop_ / "jobs.db", bytes);
  const auto made = BackUp(PlacesIn(shop_), {}, file_);
  ASSERT_FALSE(made.has_value());
  EXPECT_THAT(made.error().message, HasSubstr("is damaged"));
  EXPECT_FALSE(fs::exists(file_));
  EXPECT_TRUE(BackUp(PlacesIn(shop_), {"queue"}, file_).has_value()) << "the rest";
}

TEST_F(ShopBackupTest, WithoutAQueueThereIsNoShop) {
  const auto made = BackUp(PlacesIn(folder_ / "nowhere"), {}, file_);
  ASSERT_FALSE(made.has_value());
  EXPECT_THAT(made.error().message, HasSubstr("no queue of a shop"));
}

}  // namespace
}  // namespace intaglio::backup
