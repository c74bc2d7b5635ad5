#include "services/backup/archive.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/services/backup/file_bytes.h"
#include "tests/test_folder.h"

namespace intaglio::backup {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// Bytes that do not repeat, others for each size.
std::string Content(std::size_t size) {
  std::string bytes(size, '\0');
  auto state = static_cast<std::uint32_t>(size);
  for (char& byte : bytes) {
    state = state * 1664525u + 1013904223u;
    byte = static_cast<char>(state >> 24);
  }
  return bytes;
}

class ArchiveTest : public testing::Test {
 protected:
  void SetUp() override {
    for (const auto& [name, bytes] : files_) {
      fs::create_directories((folder_ / name).parent_path());
      PutBytes(folder_ / name, bytes);
    }
    auto writer = ArchiveWriter::Create(file_);
    ASSERT_TRUE(writer.has_value()) << writer.error().message;
    for (const auto& [name, bytes] : files_)
      ASSERT_TRUE(writer->Add(name, folder_ / name).has_value());
    EXPECT_FALSE(fs::exists(file_)) << "not before it is whole";
    ASSERT_TRUE(writer->Finish("/shop/jobs", "2026-11-26T12:00:00.000Z").has_value());
  }
  std::string Refusal() const {
    const auto archive = Archive::Open(file_);
    if (archive) return "";
    EXPECT_THAT(archive.error().message, HasSubstr(file_.string()));
    EXPECT_THAT(archive.error().message, HasSubstr("nothing was changed"));
    return archive.error().message;
  }

  const std::vector<std::pair<std::string, std::string>> files_ = {
      {"queue/jobs.db", Content(9000)},
      {"jobs/1-ab/journal.bin", Content(2 * kPartBytes + 77)},
      {"jobs/1-ab/job.json", "{}"},
      {"jobs/1-ab/empty", ""}};
  fs::path folder_ = test::FreshFolder();
  fs::path file_ = folder_ / "shop.backup";
};

TEST_F(ArchiveTest, GivesBackWhatWasPutIn) {
  const auto archive = Archive::Open(file_);
  ASSERT_TRUE(archive.has_value()) << archive.error().message;
  EXPECT_EQ(archive->results(), "/shop/jobs");
  EXPECT_EQ(archive->made_utc(), "2026-11-26T12:00:00.000Z");
  ASSERT_EQ(archive->files().size(), files_.size());
  for (std::size_t i = 0; i < files_.size(); ++i) {
    EXPECT_EQ(archive->files()[i].name, files_[i].first);
    const fs::path target = folder_ / "out" / files_[i].first;
    ASSERT_TRUE(archive->Extract(i, target).has_value());
    EXPECT_TRUE(BytesIn(target) == files_[i].second) << files_[i].first;
  }
}

TEST_F(ArchiveTest, AFileThatIsThereIsNotReplaced) {
  const std::string before = BytesIn(file_);
  const auto writer = ArchiveWriter::Create(file_);
  ASSERT_FALSE(writer.has_value());
  EXPECT_THAT(writer.error().message, HasSubstr("is there already"));
  EXPECT_TRUE(BytesIn(file_) == before);
}

TEST_F(ArchiveTest, AnUnfinishedOneLeavesNothing) {
  {
    auto writer = ArchiveWriter::Create(folder_ / "second.backup");
    ASSERT_TRUE(writer->Add("jobs/a/b", folder_ / "jobs/1-ab/job.json").has_value());
  }
  EXPECT_FALSE(fs::exists(folder_ / "second.backup"));
  EXPECT_FALSE(fs::exists(folder_ / "second.backup.unfinished"));
}

TEST_F(ArchiveTest, ACutOneIsRefused) {
  const std::string intact = BytesIn(file_);
  for (std::size_t size = 1; size < intact.size(); size += intact.size() / 61) {
    PutBytes(file_, intact.substr(0, size));
    EXPECT_NE(Refusal(), "") << "cut at " << size;
  }
}

// Every byte counts but those between the rows, which nothing reads.
TEST_F(ArchiveTest, AChangedByteOfAFileIsRefused) {
  const std::string intact = BytesIn(file_);
  for (const auto& [name, bytes] : files_) {
    if (bytes.size() < 1000) continue;
    for (const std::size_t at : {std::size_t{0}, bytes.size() / 2, bytes.size() - 8}) {
      const std::size_t place = intact.find(bytes.substr(at, 8));
      ASSERT_NE(place, std::string::npos) << name << " at " << at;
      std::string changed = intact;
      changed[place] = static_cast<char>(changed[place] ^ 1);
      PutBytes(file_, changed);
      EXPECT_THAT(Refusal(), HasSubstr("is damaged (" + name + ")"));
    }
  }
}

TEST_F(ArchiveTest, AnyChangedByteIsRefusedOrChangesNothing) {
  const std::string intact = BytesIn(file_);
  for (std::size_t at = 0; at < intact.size(); at += 9973) {
    std::string changed = intact;
    changed[at] = static_cast<char>(changed[at] ^ 0xff);
    PutBytes(file_, changed);
    const auto archive = Archive::Open(file_);
    if (!archive) continue;
    ASSERT_EQ(archive->files().size(), files_.size()) << at;
    for (std::size_t i = 0; i < files_.size(); ++i) {
      ASSERT_TRUE(archive->Extract(i, folder_ / "one").has_value());
      EXPECT_TRUE(BytesIn(folder_ / "one") == files_[i].second) << at;
    }
  }
}

TEST_F(ArchiveTest, ARowThatIsMissingOrAddedIsRefused) {
  const std::string intact = BytesIn(file_);
  for (const char* change :
       {"DELETE FROM files WHERE id = 3", "DELETE FROM parts WHERE file = 3",
        "DELETE FROM backup", "UPDATE files SET name = 'jobs/1-ab/other' WHERE id = 3",
        "UPDATE backup SET results = '/other'", "DROP TABLE parts",
        "INSERT INTO files VALUES (9, 'jobs/x/y', 0, 0)"}) {
    PutBytes(file_, intact);
    SQLite::Database(file_.string(), SQLite::OPEN_READWRITE).exec(change);
    EXPECT_THAT(Refusal(), HasSubstr("is damaged")) << change;
  }
}

TEST_F(ArchiveTest, AnotherFileIsNoBackup) {
  PutBytes(file_, "");
  EXPECT_THAT(Refusal(), HasSubstr("no backup of a shop"));
  PutBytes(file_, Content(5000));
  EXPECT_NE(Refusal(), "");
  fs::remove(file_);
  SQLite::Database(file_.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)
      .exec("CREATE TABLE a (b)");
  EXPECT_THAT(Refusal(), HasSubstr("no backup of a shop"));
}

TEST_F(ArchiveTest, ANewerOneIsRefused) {
  SQLite::Database(file_.string(), SQLite::OPEN_READWRITE)
      .exec("PRAGMA user_version = 2");
  EXPECT_THAT(Refusal(), HasSubstr("has version 2"));
}

TEST(ArchiveNames, LeadNowhereElse) {
  for (const char* good :
       {"queue/jobs.db", "jobs/1-ab/a", "machines/a.textproto.history/b"})
    EXPECT_TRUE(IsArchiveName(good)) << good;
  for (const char* bad : {"", "jobs", "jobs/", "/etc/passwd", "jobs/../../x", "../jobs/x",
                          "jobs/./x", "jobs//x", "other/x", "jobs/a/.."})
    EXPECT_FALSE(IsArchiveName(bad)) << bad;
}

}  // namespace
}  // namespace intaglio::backup
