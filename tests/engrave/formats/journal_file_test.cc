#include "engrave/formats/journal_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "engrave/io/crc32.h"
#include "tests/test_folder.h"

namespace intaglio::formats {
namespace {

std::vector<std::byte> BytesOf(const JournalHeader& header,
                               const std::vector<JournalRecord>& records) {
  const auto head = EncodeJournalHeader(header);
  std::vector<std::byte> bytes(head.begin(), head.end());
  for (const JournalRecord& record : records) {
    const auto body = EncodeJournalRecord(record);
    bytes.insert(bytes.end(), body.begin(), body.end());
  }
  return bytes;
}

const std::vector<JournalRecord> kRecords = {
    {JournalKind::kSession, PointOutcome::kNone, 0, 0, 99, 0xdeadbeef, 17},
    {JournalKind::kIntent, PointOutcome::kNone, 0, 1, 100, 0, 0},
    {JournalKind::kIntent, PointOutcome::kNone, 0, 1, 102, 1, 0},
    {JournalKind::kOutcome, PointOutcome::kMade, 0, 1, 100, 0, 1},
    {JournalKind::kOutcome, PointOutcome::kSkipped, 5, 1, 102, 1, 1},
    {JournalKind::kIntent, PointOutcome::kNone, 0, 2, 1ull << 40, 1, 1}};

TEST(JournalFile, ReadsBackWhatWasWritten) {
  const auto journal = ParseJournal(BytesOf({3, 77, 0xcafe, 4}, kRecords));
  ASSERT_TRUE(journal.has_value());
  EXPECT_EQ(journal->header.point_count, 3u);
  EXPECT_EQ(journal->header.epoch, 77u);
  EXPECT_EQ(journal->header.path_crc, 0xcafeu);
  EXPECT_EQ(journal->header.station, 4u);
  EXPECT_EQ(journal->damaged_records, 0u);
  EXPECT_EQ(journal->records, kRecords);
  EXPECT_EQ(journal->torn_bytes, 0u);
}

TEST(JournalFile, CutAnywhereKeepsEveryWholeRecord) {
  const auto bytes = BytesOf({3, 77}, kRecords);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto journal = ParseJournal(std::span(bytes).first(size));
    ASSERT_EQ(journal.has_value(), size >= kJournalHeaderSize) << size;
    if (!journal) continue;
    const std::size_t whole = (size - kJournalHeaderSize) / kJournalRecordSize;
    EXPECT_EQ(journal->records.size(), whole);
    EXPECT_EQ(journal->torn_bytes,
              size - kJournalHeaderSize - whole * kJournalRecordSize);
  }
}

TEST(JournalFile, ADamagedRecordIsPassedOverAndCounted) {
  for (std::size_t i = 0; i < kJournalRecordSize; ++i) {
    auto bytes = BytesOf({3, 77}, kRecords);
    bytes[kJournalHeaderSize + kJournalRecordSize + i] ^= std::byte{0x10};
    const auto journal = ParseJournal(bytes);
    ASSERT_TRUE(journal.has_value());
    auto expected = kRecords;
    expected.erase(expected.begin() + 1);
    EXPECT_EQ(journal->records, expected) << "byte " << i;
    EXPECT_EQ(journal->damaged_records, 1u);
    EXPECT_EQ(journal->torn_bytes, 0u);
  }
}

// Blocks of a file that were not synced reach the disk in any order, or not at all.
TEST(JournalFile, EverySubsetOfBlocksReportsAllThatItHas) {
  constexpr std::size_t kBlocks = 6;
  for (unsigned subset = 0; subset < (1u << kBlocks); ++subset) {
    auto bytes = BytesOf({3, 77}, kRecords);
    std::vector<JournalRecord> expected;
    std::size_t behind_last = 0;
    for (std::size_t i = 0; i < kBlocks; ++i) {
      if ((subset >> i & 1u) != 0) {
        expected.push_back(kRecords[i]);
        behind_last = i + 1;
        continue;
      }
      const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(
                                             kJournalHeaderSize + i * kJournalRecordSize);
      std::fill(begin, begin + kJournalRecordSize, std::byte{0});
    }
    const auto journal = ParseJournal(bytes);
    ASSERT_TRUE(journal.has_value());
    EXPECT_EQ(journal->records, expected);
    EXPECT_EQ(journal->damaged_records, behind_last - expected.size());
    EXPECT_EQ(journal->torn_bytes, (kBlocks - behind_last) * kJournalRecordSize);
  }
}

TEST(JournalFile, HistoryDistinguishesOpenIntentsFromOutcomes) {
  const auto journal = ParseJournal(BytesOf({3, 77}, kRecords));
  ASSERT_TRUE(journal.has_value());
  const auto history = HistoryOf(*journal);
  ASSERT_EQ(history.size(), 3u);
  EXPECT_EQ(history[0].outcome, PointOutcome::kMade);
  EXPECT_EQ(history[0].fired_count, 1u);
  EXPECT_EQ(history[0].power_up, 0xdeadbeefu);
  EXPECT_FALSE(history[0].open_intent);
  EXPECT_TRUE(history[1].open_intent) << "armed again in run 2, nobody said what became";
  EXPECT_EQ(history[1].tick, 1ull << 40);
  EXPECT_EQ(history[2].outcome, PointOutcome::kNone);
}

constexpr std::uint64_t kGrant = (1ull << 33) + 5;

JournalRecord Of(JournalKind kind, std::uint32_t point, std::uint64_t tick,
                 PointOutcome outcome = PointOutcome::kNone) {
  return {kind, outcome, 0, 1, tick, point, 0};
}

TEST(JournalFile, AnUncertainPointIsOpenAgainByAConsentAndFiredThenAsAnyOther) {
  std::vector<JournalRecord> records;
  for (std::uint32_t point = 0; point < 3; ++point) {
    records.push_back(Of(JournalKind::kIntent, point, 100 + point));
    records.push_back(
        Of(JournalKind::kOutcome, point, 100 + point, PointOutcome::kUncertain));
  }
  records.push_back(Of(JournalKind::kConsent, 0, kGrant));
  records.push_back(Of(JournalKind::kReopened, 0, kGrant));
  records.push_back(Of(JournalKind::kReopened, 1, kGrant));
  records.push_back(Of(JournalKind::kIntent, 1, 300));
  records.push_back(Of(JournalKind::kOutcome, 1, 300, PointOutcome::kMade));
  const auto journal = ParseJournal(BytesOf({3, 77}, records));
  ASSERT_TRUE(journal.has_value());
  EXPECT_EQ(journal->records, records);
  const auto history = HistoryOf(*journal);
  EXPECT_EQ(history[0].outcome, PointOutcome::kNone);
  EXPECT_TRUE(history[0].reopened) << "nobody knows whether it holds a crack";
  EXPECT_EQ(history[1].outcome, PointOutcome::kMade);
  EXPECT_EQ(history[1].fired_count, 1u);
  EXPECT_EQ(history[2].outcome, PointOutcome::kUncertain);
  EXPECT_FALSE(history[2].reopened);
}

// Even if other records are missing in the file, no consent opens a point that was made
// or is armed.
TEST(JournalFile, OnlyWhatIsUncertainIsOpenedByAConsent) {
  const std::vector<JournalRecord> records = {
      Of(JournalKind::kIntent, 0, 100),
      Of(JournalKind::kOutcome, 0, 100, PointOutcome::kMade),
      Of(JournalKind::kIntent, 1, 101), Of(JournalKind::kReopened, 0, kGrant),
      Of(JournalKind::kReopened, 1, kGrant)};
  const auto history = HistoryOf(*ParseJournal(BytesOf({2, 77}, records)));
  EXPECT_EQ(history[0].outcome, PointOutcome::kMade);
  EXPECT_FALSE(history[0].reopened);
  EXPECT_TRUE(history[1].open_intent);
  EXPECT_FALSE(history[1].reopened);
}

// The CRC-32 of the doubles as they lie in memory, all at once.
TEST(JournalFile, APathIsKnownByAllItsBits) {
  PointList path_mm = {Vec3(0.1, 1.0 / 3, 1e-17), Vec3(49.9, 2, 30)};
  const std::uint32_t crc = PathCrc(path_mm);
  std::vector<double> numbers;
  for (const Vec3& p : path_mm) numbers.insert(numbers.end(), p.data(), p.data() + 3);
  EXPECT_EQ(crc, io::Crc32(std::as_bytes(std::span(numbers))));
  path_mm[1].z() = std::nextafter(30.0, 31.0);
  EXPECT_NE(PathCrc(path_mm), crc);
  EXPECT_EQ(PathCrc({}), 0u);
}

// A file is read in pieces of 1 MB: its cuts and damages are those of the whole.
TEST(JournalFile, AFileOfSeveralPiecesIsReadAsItsBytes) {
  std::vector<JournalRecord> records;
  while (records.size() < 100'000)
    records.insert(records.end(), kRecords.begin(), kRecords.end());
  std::vector<std::byte> bytes = BytesOf({3, 77, 5}, records);
  for (const std::size_t damaged :
       {std::size_t{32765}, std::size_t{32766}, std::size_t{70000}})
    bytes[kJournalHeaderSize + damaged * kJournalRecordSize] ^= std::byte{0xff};
  bytes.resize(bytes.size() - 7);
  const auto file = test::FreshFolder() / "journal.bin";
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  const auto whole = ParseJournal(bytes), read = ReadJournal(file);
  ASSERT_TRUE(whole && read);
  EXPECT_EQ(read->header, whole->header);
  EXPECT_EQ(read->records, whole->records);
  EXPECT_EQ(read->records.size(), records.size() - 4);
  EXPECT_EQ(read->damaged_records, 3u);
  EXPECT_EQ(read->torn_bytes, kJournalRecordSize - 7);
  std::vector<JournalRecord> taken;
  const auto header =
      ReadJournalRecords(file, [&](const JournalHeader& of, const JournalRecord& record) {
        EXPECT_EQ(of, whole->header);
        taken.push_back(record);
      });
  ASSERT_TRUE(header);
  EXPECT_EQ(*header, whole->header);
  EXPECT_EQ(taken, whole->records);
  std::ofstream(file) << "";
  EXPECT_EQ(ReadJournal(file).error().code, ErrorCode::kUnreadable);
}

TEST(JournalFile, RefusesWhatIsNoJournal) {
  const auto empty = ParseJournal({});
  ASSERT_FALSE(empty.has_value());
  EXPECT_EQ(empty.error().code, ErrorCode::kUnreadable);
  const auto absent = ReadJournal("/nonexistent/journal");
  ASSERT_FALSE(absent.has_value());
  EXPECT_THAT(absent.error().message, testing::HasSubstr("/nonexistent/journal"));
}

TEST(Journal, KeepsEnergyAndMissedChannelsOfAnOutcomeAlone) {
  JournalRecord missed{JournalKind::kOutcome, PointOutcome::kMissed, 0, 1, 50, 2, 7};
  missed.missed_channels = 0b1010;
  missed.measured_mj = 29.5F;
  JournalRecord session{JournalKind::kSession, PointOutcome::kNone, 0, 1, 50, 99, 7, 3};
  const auto journal = ParseJournal(BytesOf({3, 77, 0xcafe}, {session, missed}));
  ASSERT_TRUE(journal.has_value());
  EXPECT_EQ(journal->records, (std::vector{session, missed}));
  const auto history = HistoryOf(*journal);
  EXPECT_EQ(history[2].missed_channels, 0b1010);
  EXPECT_EQ(history[2].measured_mj, 29.5F);
  EXPECT_EQ(history[1].measured_mj, 0);
}

}  // namespace
}  // namespace intaglio::formats
