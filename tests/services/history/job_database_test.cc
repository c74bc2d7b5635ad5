#include "services/history/job_database.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "services/history/job_history.h"
#include "services/job_service/job_migrations.h"
#include "services/job_service/job_store.h"
#include "tests/test_folder.h"

namespace intaglio::history {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// All files of a folder with their bytes.
std::map<std::string, std::string> ContentsOf(const fs::path& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    std::stringstream bytes;
    if (entry.is_regular_file()) bytes << std::ifstream(entry.path()).rdbuf();
    contents[entry.path().string()] = bytes.str();
  }
  return contents;
}

class JobDatabaseTest : public testing::Test {
 protected:
  void Execute(const std::string& sql) {
    SQLite::Database(file_.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)
        .exec(sql);
  }
  /// As a job service of that version left it.
  void MakeVersion(std::size_t version) {
    for (std::size_t step = 0; step < version; ++step)
      Execute(job_service::kMigrations.at(step));
    Execute(fmt::format("PRAGMA user_version = {}", version));
  }
  JobDatabaseKind Kind() {
    const auto found = InspectJobDatabase(file_);
    EXPECT_TRUE(found.has_value()) << found.error().message;
    return found->kind;
  }
  /// Refused by the check, by the job service's store and by the history, with nothing
  /// changed in its folder.
  std::string Refusal() {
    const auto before = ContentsOf(folder_);
    const auto checked = CheckJobDatabase(file_);
    EXPECT_FALSE(checked.has_value());
    try {
      job_service::JobStore store(file_);
      ADD_FAILURE() << "the store opened it";
    } catch (const job_service::StoreError& error) {
      EXPECT_FALSE(error.passes());
      EXPECT_EQ(error.what(), checked.error().message);
    }
    EXPECT_FALSE(ReadHistory(file_, {}).has_value());
    EXPECT_EQ(ContentsOf(folder_), before) << "no byte, and no file beside it";
    return checked.error().message;
  }

  fs::path folder_ = test::FreshFolder();
  fs::path file_ = folder_ / "a job%20?#.db";
};

TEST_F(JobDatabaseTest, EveryVersionOfOursIsKnown) {
  for (std::size_t version = 1; version <= job_service::kMigrations.size(); ++version) {
    fs::remove(file_);
    MakeVersion(version);
    EXPECT_EQ(Kind(), JobDatabaseKind::kOurs) << "version " << version;
    EXPECT_NO_THROW(job_service::JobStore{file_}) << "version " << version;
    EXPECT_EQ(Kind(), JobDatabaseKind::kOurs) << "made of version " << version;
  }
}

TEST_F(JobDatabaseTest, ItIsMadeWhereThereIsNone) {
  EXPECT_EQ(Kind(), JobDatabaseKind::kNone);
  EXPECT_FALSE(fs::exists(file_)) << "a check makes no file";
  std::ofstream{file_};
  EXPECT_EQ(Kind(), JobDatabaseKind::kNone);
  Execute("PRAGMA journal_mode = WAL");
  EXPECT_EQ(Kind(), JobDatabaseKind::kNone) << "a service that was killed at its start";
  EXPECT_NO_THROW(job_service::JobStore{file_});
  EXPECT_EQ(Kind(), JobDatabaseKind::kOurs);
}

TEST_F(JobDatabaseTest, AnotherSqliteFileIsRefusedUntouched) {
  Execute("CREATE TABLE albums (title TEXT); INSERT INTO albums VALUES ('Kind of Blue')");
  const std::string refusal = Refusal();
  EXPECT_THAT(refusal, HasSubstr(file_.string()));
  EXPECT_THAT(refusal, HasSubstr("albums"));
  EXPECT_THAT(refusal, HasSubstr("--database"));
}

TEST_F(JobDatabaseTest, AnotherWithTheSameTablesButItsOwnMarkIsRefusedUntouched) {
  MakeVersion(job_service::kMigrations.size());
  Execute("PRAGMA application_id = 42");
  EXPECT_THAT(Refusal(), HasSubstr("application id 42"));
}

TEST_F(JobDatabaseTest, ANewerVersionIsRefusedUntouched) {
  MakeVersion(job_service::kMigrations.size());
  Execute("PRAGMA user_version = 1000");
  EXPECT_THAT(Refusal(), HasSubstr("has version 1000"));
  EXPECT_THAT(Refusal(), HasSubstr("newer program"));
}

TEST_F(JobDatabaseTest, AFileThatIsNoDatabaseIsRefusedUntouched) {
  std::ofstream(file_) << std::string(5000, 'x');
  EXPECT_THAT(Refusal(), HasSubstr("no SQLite database"));
  std::ofstream(file_) << "short";
  EXPECT_THAT(Refusal(), HasSubstr("no SQLite database"));
}

TEST_F(JobDatabaseTest, AFolderIsRefused) {
  fs::create_directory(file_);
  EXPECT_THAT(Refusal(), HasSubstr("folder"));
}

// A program was killed: all that it has written is in the log beside the file.
TEST_F(JobDatabaseTest, AForeignDatabaseThatIsInItsLogAloneIsRefusedUntouched) {
  const fs::path copy = folder_ / "killed.db";
  {
    SQLite::Database open(file_.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
    open.exec("PRAGMA journal_mode = WAL; PRAGMA wal_autocheckpoint = 0");
    open.exec("CREATE TABLE albums (title TEXT)");
    fs::copy(file_, copy);
    fs::copy(file_.string() + "-wal", copy.string() + "-wal");
  }
  fs::remove(file_);
  file_ = copy;
  EXPECT_THAT(Refusal(), HasSubstr("albums"));
}

TEST_F(JobDatabaseTest, OursThatIsInItsLogAloneIsOpened) {
  const fs::path copy = folder_ / "killed.db";
  {
    job_service::JobStore open(file_);
    (void)open.BeginRun();
    fs::copy(file_, copy);
    fs::copy(file_.string() + "-wal", copy.string() + "-wal");
  }
  file_ = copy;
  EXPECT_EQ(Kind(), JobDatabaseKind::kOurs);
  EXPECT_NO_THROW(job_service::JobStore{file_});
}

}  // namespace
}  // namespace intaglio::history
