#include "services/cell/earlier_work.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace intaglio::cell {
namespace {

using formats::JournalKind;
using formats::PointOutcome;
using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr formats::JournalHeader kHeader{3, 77, 0xcafe};
const formats::JournalRecord kSession{
    JournalKind::kSession, PointOutcome::kNone, 0, 0, 9, 0xfeed, 17};
const formats::JournalRecord kIntent{
    JournalKind::kIntent, PointOutcome::kNone, 0, 4, 10, 1, 17};
const formats::JournalRecord kMade{
    JournalKind::kOutcome, PointOutcome::kMade, 0, 4, 10, 1, 18};

class OpenJournalTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("earlier-" + std::to_string(getpid()));
    fs::create_directories(folder_);
    file_ = folder_ / "journal.bin";
  }
  void TearDown() override { fs::remove_all(folder_); }

  void Write(const std::vector<formats::JournalRecord>& records) {
    auto opened = OpenJournal(file_, kHeader, JobBegun::kNo);
    ASSERT_TRUE(opened) << opened.error().message;
    for (const auto& record : records) ASSERT_TRUE(opened->writer->Append(record));
  }

  fs::path folder_, file_;
};

TEST_F(OpenJournalTest, ANewOneReportsNothing) {
  const auto opened = OpenJournal(file_, kHeader, JobBegun::kNo);
  ASSERT_TRUE(opened);
  EXPECT_TRUE(opened->earlier.points.empty());
  EXPECT_EQ(formats::ReadJournal(file_)->header, kHeader);
}

TEST_F(OpenJournalTest, GoesOnWithWhatIsThere) {
  Write({kSession, kIntent});
  Write({kMade});
  const auto opened = OpenJournal(file_, kHeader, JobBegun::kNo);
  ASSERT_TRUE(opened);
  const EarlierWork& earlier = opened->earlier;
  ASSERT_EQ(earlier.points.size(), 3u);
  EXPECT_EQ(earlier.points[1].outcome, PointOutcome::kMade);
  EXPECT_EQ(earlier.power_up, 0xfeedu);
  EXPECT_EQ(earlier.pulses_before_job, 17u);
  EXPECT_EQ(earlier.highest_run, 4u);
  EXPECT_EQ(earlier.run_count, 1u);
}

TEST_F(OpenJournalTest, ATornRecordIsCutAndTheNextOneReadable) {
  Write({kSession, kIntent});
  fs::resize_file(file_, fs::file_size(file_) + 13);
  Write({kMade});
  const auto journal = formats::ReadJournal(file_);
  ASSERT_TRUE(journal);
  EXPECT_THAT(journal->records, testing::ElementsAre(kSession, kIntent, kMade));
}

TEST_F(OpenJournalTest, AHeaderThatNeverCameToTheDiskIsBegunAnew) {
  std::ofstream(file_) << "INTJ";
  const auto opened = OpenJournal(file_, kHeader, JobBegun::kNo);
  ASSERT_TRUE(opened);
  EXPECT_TRUE(opened->earlier.points.empty());
}

// The journal is on the disk before the path is.
TEST_F(OpenJournalTest, OneThatIsGoneIsNotBegunAnewWhenTheJobWas) {
  for (const std::size_t left : {0u, 1u, 63u}) {
    std::ofstream(file_) << std::string(left, 'x');
    const auto opened = OpenJournal(file_, kHeader, JobBegun::kItsPathIsThere);
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().code, ErrorCode::kUnreadable);
    EXPECT_THAT(opened.error().message, HasSubstr(file_.string()));
    EXPECT_EQ(fs::file_size(file_), left) << "it is left for whoever looks into it";
  }
  fs::remove(file_);
  EXPECT_FALSE(OpenJournal(file_, kHeader, JobBegun::kItsPathIsThere));
}

TEST_F(OpenJournalTest, ASessionWithoutIntentsIsTakenUp) {
  Write({kSession});
  const auto opened = OpenJournal(file_, kHeader, JobBegun::kItsPathIsThere);
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->earlier.points.size(), 3u);
  EXPECT_EQ(opened->earlier.power_up, 0xfeedu);
  EXPECT_EQ(opened->earlier.pulses_before_job, 17u);
}

TEST_F(OpenJournalTest, PulsesAlongAnotherPathAreRefused) {
  Write({kSession, kIntent});
  const auto opened = OpenJournal(file_, {3, 77, 0xbeef}, JobBegun::kNo);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kRefused);
  EXPECT_THAT(opened.error().message, HasSubstr("cancel the job"));
  EXPECT_EQ(formats::ReadJournal(file_)->records.size(), 2u) << "and nothing is lost";
}

TEST_F(OpenJournalTest, AnotherPathBeforeAnyPulseIsANewBeginning) {
  Write({kSession});
  const auto opened = OpenJournal(file_, {4, 77, 0xbeef}, JobBegun::kNo);
  ASSERT_TRUE(opened);
  EXPECT_EQ(formats::ReadJournal(file_)->header.point_count, 4u);
}

// It counts once, also when nothing was uncertain.
TEST_F(OpenJournalTest, TheGreatestGrantWithConsentIsKnownInTheNextLife) {
  const auto of_grant = [](JournalKind kind, std::uint64_t grant) {
    return formats::JournalRecord{kind, PointOutcome::kNone, 0, 4, grant, 0, 17};
  };
  Write({kSession, of_grant(JournalKind::kConsent, 7)});
  auto opened = OpenJournal(file_, kHeader, JobBegun::kNo);
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->earlier.consent_grant, 7u);
  EXPECT_FALSE(opened->earlier.points.empty()) << "what came behind it may be lost";
  opened->writer.reset();
  // The record of the consent may be missing on the disk.
  Write({kIntent, of_grant(JournalKind::kReopened, 9)});
  opened = OpenJournal(file_, kHeader, JobBegun::kNo);
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->earlier.consent_grant, 9u);
}

// Taken before the first run, by a life that ended there.
TEST_F(OpenJournalTest, ConsentAloneIsKnownAndNoRunHasBegun) {
  Write({{JournalKind::kConsent, PointOutcome::kNone, 0, 0, 7, 0, 17}});
  const auto opened = OpenJournal(file_, kHeader, JobBegun::kItsPathIsThere);
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->earlier.consent_grant, 7u);
  EXPECT_TRUE(opened->earlier.points.empty());
}

TEST_F(OpenJournalTest, WhatIsUncertainIsUnansweredUntilARunBegins) {
  formats::JournalRecord uncertain = kMade;
  uncertain.outcome = PointOutcome::kUncertain;
  Write({kSession, kIntent, uncertain});
  EXPECT_TRUE(OpenJournal(file_, kHeader, JobBegun::kNo)->earlier.uncertain_unanswered);
  formats::JournalRecord next = kIntent;
  next.point = 2;
  Write({next});
  EXPECT_FALSE(OpenJournal(file_, kHeader, JobBegun::kNo)->earlier.uncertain_unanswered);
}

TEST_F(OpenJournalTest, ADamagedHeaderIsRefused) {
  Write({kSession, kIntent});
  {
    std::fstream out(file_, std::ios::in | std::ios::out | std::ios::binary);
    out.seekp(20);
    out.put('x');
  }
  const auto opened = OpenJournal(file_, kHeader, JobBegun::kNo);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kUnreadable);
  EXPECT_THAT(opened.error().message, HasSubstr(file_.string()));
}

}  // namespace
}  // namespace intaglio::cell
