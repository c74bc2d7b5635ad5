#include "services/client/shop/job_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

class JobLog : public ::testing::Test {
 protected:
  JobLog() {
    Write("sorter.log",
          "2026-11-26T23:28:37.346 sorter info: sorter-vm starts\n"
          "2026-11-26T23:28:38.685 sorter info: job 1-6b08c0a52033 attempt 1: done\n"
          "2026-11-26T23:28:41.000 sorter warning: job 12-6b08c0a52034 attempt 1: slow\n"
          "  a second line of it\n"
          "2026-11-26T23:28:42.000 sorter info: job 2-6b08c0a52035 attempt 1: done\n");
    Write(
        "job-service.log",
        "torn line of before\n"
        "2026-11-26T23:28:37.670 job-service info: job 1-6b08c0a52033 \"knot\" of anna\n"
        "2026-11-26T23:28:40.000 job-service error: the disk is full\n");
    Write("notes.txt", "2026-11-26T23:28:37.346 x info: job 1-6b08c0a52033\n");
  }

  void Write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
  }
  std::vector<std::string> Read(const LogSelection& selection) {
    const auto read = ReadLog(folder_, selection);
    EXPECT_TRUE(read) << read.error().message;
    return read ? *read : std::vector<std::string>();
  }

  const std::filesystem::path folder_ = test::FreshFolder();
};

TEST_F(JobLog, IsInOrderOfTimeOverAllServices) {
  for (const char* job : {"1", "1-6b08c0a52033"}) {
    EXPECT_THAT(Read({.job = job}),
                ElementsAre(HasSubstr("\"knot\" of anna"), HasSubstr("attempt 1: done")))
        << job;
  }
}

TEST_F(JobLog, HasThoseOfFurtherCells) {
  std::filesystem::create_directories(folder_ / "cells/els-03-2");
  Write("cells/els-03-2/synchronizer.log",
        "2026-11-26T23:28:39.000 synchronizer info: job 1-6b08c0a52033 fires\n");
  EXPECT_THAT(Read({.job = "1"}),
              ElementsAre(HasSubstr("of anna"), HasSubstr("done"), HasSubstr("fires")));
}

TEST_F(JobLog, OfAnotherNumberWithTheSameDigitsIsNotShown) {
  EXPECT_THAT(Read({.job = "12"}), ElementsAre(HasSubstr("slow\n  a second line of it")));
  EXPECT_THAT(Read({.job = "6b08c0a52033"}), IsEmpty());
  EXPECT_THAT(Read({.job = "1-6b"}), IsEmpty());
}

TEST_F(JobLog, OfNoJobIsAllOfIt) {
  EXPECT_THAT(Read({}), SizeIs(6));
  EXPECT_THAT(Read({.job = "", .warnings_only = true}),
              ElementsAre(HasSubstr("disk is full"), HasSubstr("slow")));
}

TEST_F(JobLog, TheNewestAreKept) {
  EXPECT_THAT(
      Read({.job = "", .max_count = 2}),
      ElementsAre(StartsWith("2026-11-26T23:28:41"), StartsWith("2026-11-26T23:28:42")));
}

TEST_F(JobLog, AFolderWithoutLogsIsRefusedWithWhatToDo) {
  const auto refused = ReadLog(folder_ / "none", {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(refused.error().message, HasSubstr("journalctl"));
}

TEST(LogEntryOf, GivesTheParts) {
  const LogEntry parts = LogEntryOf(
      "2026-11-26T23:28:37.346 job-service warning: job 3-ab: paused: the door\nis open");
  EXPECT_EQ(parts.time(), "2026-11-26T23:28:37.346");
  EXPECT_EQ(parts.service(), "job-service");
  EXPECT_EQ(parts.level(), "warning");
  EXPECT_EQ(parts.text(), "job 3-ab: paused: the door\nis open");
  for (const char* odd : {"", "no entry", "2026-11-26T23:28:37.346 cut",
                          "2026-11-26T23:28:37.346 job-service cut"}) {
    EXPECT_EQ(LogEntryOf(odd).text(), odd);
    EXPECT_EQ(LogEntryOf(odd).service(), "");
  }
}

}  // namespace
}  // namespace intaglio::client
