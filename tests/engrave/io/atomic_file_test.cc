#include "engrave/io/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <string>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/formats/point_file.h"
#include "tests/engrave/io/small_disk.h"
#include "tests/test_folder.h"

namespace intaglio::io {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(AtomicFile, AppearsWholeWhenCommitted) {
  const fs::path target = test::FreshFolder() / "report.json";
  auto file = AtomicFile::Create(target);
  ASSERT_TRUE(file.has_value());
  ASSERT_TRUE(file->Write("one ").has_value());
  EXPECT_FALSE(fs::exists(target));
  ASSERT_TRUE(file->Write("two").has_value());
  ASSERT_TRUE(file->Commit().has_value());
  EXPECT_EQ(test::ContentOf(target), "one two");
  EXPECT_EQ(test::FileCountIn(target.parent_path()), 1u) << "the temporary file is gone";
}

TEST(AtomicFile, ASecretIsNeverReadableByOthers) {
  const mode_t before = umask(0);  // which would take nothing away
  const fs::path target = test::FreshFolder() / "key";
  ASSERT_TRUE(WriteFileAtomically(target, "readable by all").has_value());
  auto file = AtomicFile::Create(target, kSecretMode);
  ASSERT_TRUE(file.has_value());
  ASSERT_TRUE(file->Write("secret").has_value());
  int secret_count = 0;
  for (const auto& entry : fs::directory_iterator(target.parent_path())) {
    const auto mode = entry.status().permissions() & fs::perms::mask;
    if (entry.path() == target) continue;
    EXPECT_EQ(static_cast<int>(mode), 0600) << entry.path();
    ++secret_count;
  }
  EXPECT_EQ(secret_count, 1) << "the temporary file";
  ASSERT_TRUE(file->Commit().has_value());
  EXPECT_EQ(static_cast<int>(fs::status(target).permissions() & fs::perms::mask), 0600);
  umask(before);
}

TEST(AtomicFile, KeepsEveryByteOfALargeFile) {
  const fs::path target = test::FreshFolder() / "cloud.ply";
  std::string content;  // several buffers long, and not a whole number of them
  for (int i = 0; content.size() < 1'000'003; ++i) content += std::to_string(i);
  auto file = AtomicFile::Create(target);
  ASSERT_TRUE(file.has_value());
  for (std::size_t begin = 0, piece = 1; begin < content.size();
       begin += piece, piece *= 3) {
    ASSERT_TRUE(file->Write(std::string_view(content).substr(begin, piece)).has_value());
  }
  ASSERT_TRUE(file->Commit().has_value());
  EXPECT_TRUE(test::ContentOf(target) == content);
}

TEST(AtomicFile, AbandonedLeavesTheOldFileAndNothingElse) {
  const fs::path target = test::FreshFolder() / "report.json";
  ASSERT_TRUE(WriteFileAtomically(target, "old").has_value());
  {
    auto file = AtomicFile::Create(target);
    ASSERT_TRUE(file->Write("new").has_value());
    const AtomicFile moved = std::move(*file);
    EXPECT_EQ(test::FileCountIn(target.parent_path()), 2u);
  }
  EXPECT_EQ(test::ContentOf(target), "old");
  EXPECT_EQ(test::FileCountIn(target.parent_path()), 1u);
}

TEST(AtomicFile, LastToCommitWins) {
  const fs::path target = test::FreshFolder() / "report.json";
  auto first = AtomicFile::Create(target);
  auto second = AtomicFile::Create(target);
  ASSERT_TRUE(first->Write("first").has_value());
  ASSERT_TRUE(second->Write("second").has_value());
  ASSERT_TRUE(second->Commit().has_value());
  ASSERT_TRUE(first->Commit().has_value());
  EXPECT_EQ(test::ContentOf(target), "first");
}

TEST(AtomicFile, WritesThroughASymbolicLink) {
  const fs::path folder = test::FreshFolder();
  ASSERT_TRUE(WriteFileAtomically(folder / "real", "old").has_value());
  fs::create_symlink("real", folder / "link");
  ASSERT_TRUE(WriteFileAtomically(folder / "link", "new").has_value());
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(test::ContentOf(folder / "real"), "new");
}

TEST(AtomicFile, FollowsTheUmask) {
  const fs::path target = test::FreshFolder() / "report.json";
  const mode_t before = ::umask(027);
  const Status status = WriteFileAtomically(target, "x");
  ::umask(before);
  ASSERT_TRUE(status.has_value());
  EXPECT_EQ(fs::status(target).permissions(), fs::perms(0640));
}

TEST(AtomicFile, ReportsWhenTheFolderIsMissing) {
  const fs::path target = test::FreshFolder() / "absent" / "report.json";
  const auto status = WriteFileAtomically(target, "x");
  ASSERT_FALSE(status.has_value());
  EXPECT_EQ(status.error().code, ErrorCode::kIo);
  EXPECT_THAT(status.error().message,
              AllOf(HasSubstr(target.string()), HasSubstr("create the folder")));
}

TEST(AtomicFile, RefusesAFolderAsTarget) {
  const fs::path folder = test::FreshFolder();
  EXPECT_FALSE(WriteFileAtomically(folder, "x").has_value());
  EXPECT_FALSE(WriteFileAtomically(folder / "", "x").has_value());
  EXPECT_TRUE(fs::is_directory(folder));
}

TEST(AtomicFile, WritesADeviceDirectly) {
  ASSERT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_TRUE(WriteFileAtomically("/dev/null", "x").has_value());
  EXPECT_TRUE(fs::is_character_file("/dev/null")) << "not replaced by a file";
}

TEST(AtomicFile, ReportsWhenADeviceIsFull) {
  ASSERT_TRUE(fs::is_character_file("/dev/full"));
  const auto status = WriteFileAtomically("/dev/full", "x");
  ASSERT_FALSE(status.has_value());
  EXPECT_THAT(status.error().message,
              AllOf(HasSubstr("/dev/full: cannot be written (No space left on device)"),
                    HasSubstr("free some space")));
}

TEST(AtomicFile, MayNotBeWrittenAfterItsEnd) {
  auto file = AtomicFile::Create(test::FreshFolder() / "report.json");
  ASSERT_TRUE(file->Commit().has_value());
  EXPECT_THROW((void)file->Write("x"), PreconditionError);
  EXPECT_THROW((void)file->Commit(), PreconditionError);
}

TEST(AtomicFile, FullDiskKeepsTheOldFileAndReportsIt) {
  const fs::path folder = test::FreshFolder();
  if (!MountSmallDisk(folder, 64 * 1024))
    GTEST_SKIP() << "a small file system needs root";
  const fs::path target = folder / "glass.ply";
  ASSERT_TRUE(WriteFileAtomically(target, "old").has_value());
  formats::PointTable table;
  table.points_mm.assign(100'000, Vec3(1, 2, 3));       // 2.4 MB: several flushes
  for (const std::size_t count : {100'000u, 4'000u}) {  // fails in Write and in Commit
    table.points_mm.resize(count);
    const auto status = formats::WritePly(target, table);
    ASSERT_FALSE(status.has_value());
    EXPECT_EQ(status.error().code, ErrorCode::kIo);
    EXPECT_THAT(status.error().message,
                AllOf(HasSubstr(target.string()), HasSubstr("No space left on device"),
                      HasSubstr("choose another folder")));
    EXPECT_EQ(test::ContentOf(target), "old");
    EXPECT_EQ(test::FileCountIn(folder), 1u)
        << "the temporary file must not hold the disk full";
  }
  table.points_mm.resize(1'000);
  EXPECT_TRUE(formats::WritePly(target, table).has_value());
}

}  // namespace
}  // namespace intaglio::io
