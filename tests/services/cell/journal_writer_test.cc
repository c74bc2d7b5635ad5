#include "services/cell/journal_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>

#include "tests/test_folder.h"

namespace intaglio::cell {
namespace {

namespace fs = std::filesystem;
using formats::JournalKind;
using formats::PointOutcome;

void AwaitDurable(JournalWriter& journal, std::uint64_t number) {
  for (int i = 0; i < 500 && journal.durable() < number; ++i) {
    pollfd event{journal.event_fd(), POLLIN, 0};
    poll(&event, 1, 10);
    journal.ClearEvent();
  }
  ASSERT_GE(journal.durable(), number);
}

TEST(JournalWriter, WhatIsDurableIsInTheFile) {
  const fs::path file = test::FreshFolder() / "journal.bin";
  auto journal = JournalWriter::Create(file, {1000, 7});
  ASSERT_TRUE(journal.has_value());
  for (std::uint32_t i = 0; i < 1000; ++i) {
    ASSERT_TRUE(
        (*journal)->Append({JournalKind::kIntent, PointOutcome::kNone, 0, 1, i, i, 0}));
    if (i % 100 == 99) (*journal)->Flush();
  }
  AwaitDurable(**journal, 1000);
  const auto read = formats::ReadJournal(file);
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->header.epoch, 7u);
  ASSERT_EQ(read->records.size(), 1000u);
  EXPECT_EQ(read->records[999].point, 999u);
}

TEST(JournalWriter, ClosingWritesTheRest) {
  const fs::path file = test::FreshFolder() / "journal.bin";
  {
    auto journal = JournalWriter::Create(file, {2, 1});
    ASSERT_TRUE(journal.has_value());
    ASSERT_TRUE(
        (*journal)->Append({JournalKind::kIntent, PointOutcome::kNone, 0, 1, 5, 1, 0}));
  }
  const auto read = formats::ReadJournal(file);
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->records.size(), 1u);
}

TEST(JournalWriter, NeverWritesOverAJournal) {
  const fs::path file = test::FreshFolder() / "journal.bin";
  ASSERT_TRUE(JournalWriter::Create(file, {1, 1}).has_value());
  const auto again = JournalWriter::Create(file, {1, 1});
  ASSERT_FALSE(again.has_value());
  EXPECT_THAT(again.error().message, testing::HasSubstr("journal.bin"));
}

TEST(JournalWriter, FullDiskIsAFaultAndNothingIsDurable) {
  if (access("/dev/full", W_OK) != 0)
    GTEST_SKIP() << "/dev/full may not be written: run where /dev is that of Linux";
  const fs::path file = test::FreshFolder() / "journal.bin";
  fs::create_symlink("/dev/full", file);
  // O_EXCL refuses the link, which is how a journal in the way is refused, too.
  const auto journal = JournalWriter::Create(file, {1, 1});
  ASSERT_FALSE(journal.has_value());
  EXPECT_EQ(journal.error().code, ErrorCode::kIo);
}

// A limit of the file's size is a disk without room: it takes a part of a block, too.
TEST(JournalWriter, GoesOnWhenTheDiskHasRoomAgain) {
  const fs::path file = test::FreshFolder() / "journal.bin";
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  signal(SIGXFSZ, SIG_IGN);
  const auto append = [](JournalWriter& journal, std::uint32_t point) {
    return journal.Append(
        {JournalKind::kIntent, PointOutcome::kNone, 0, 1, point, point, 0});
  };
  {
    auto journal = JournalWriter::Create(file, {1000, 7});
    ASSERT_TRUE(journal.has_value());
    ASSERT_TRUE(append(**journal, 0));
    (*journal)->Flush();
    AwaitDurable(**journal, 1);
    rlimit tight = before;
    tight.rlim_cur = formats::kJournalHeaderSize + 5 * formats::kJournalRecordSize / 2;
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &tight), 0);
    for (std::uint32_t i = 1; i < 10; ++i) ASSERT_TRUE(append(**journal, i));
    (*journal)->Flush();
    for (int i = 0; i < 500 && !(*journal)->failed(); ++i) usleep(1000);
    EXPECT_TRUE((*journal)->failed());
    EXPECT_EQ((*journal)->durable(), 1u);
    EXPECT_THAT((*journal)->error(), testing::HasSubstr("journal.bin"));
    EXPECT_THAT((*journal)->error(), testing::HasSubstr("free space"));
    // What comes meanwhile is kept.
    ASSERT_TRUE(append(**journal, 10));
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
    AwaitDurable(**journal, 11);
    for (int i = 0; i < 500 && (*journal)->failed(); ++i) usleep(1000);
    EXPECT_FALSE((*journal)->failed());
  }
  const auto read = formats::ReadJournal(file);
  ASSERT_TRUE(read.has_value());
  ASSERT_EQ(read->records.size(), 11u);
  for (std::uint32_t i = 0; i < 11; ++i) EXPECT_EQ(read->records[i].point, i);
}

}  // namespace
}  // namespace intaglio::cell
