// The record of a scan head's material against bytes that were written elsewhere, and
// cut.

#include "engrave/formats/mark_record.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "engrave/io/atomic_file.h"
#include "engrave/io/whole_file.h"
#include "tests/test_folder.h"

namespace intaglio::formats {
namespace {

const std::filesystem::path kTwoTicks =
    INTAGLIO_SOURCE_DIR "/tests/fuzz/corpus/mark_record_fuzz/two.rec";

TEST(MarkRecord, ReadsAFileOfAnotherWriter) {
  // Written by Python's struct and zlib.
  const auto record = ReadMarkRecord(kTwoTicks);
  ASSERT_TRUE(record) << record.error().message;
  EXPECT_EQ(record->header.field_mm, 100);
  EXPECT_EQ(record->header.power_up, 77u);
  ASSERT_EQ(record->ticks.size(), 2u);
  const BurntTick& tick = record->ticks[1];
  EXPECT_EQ(tick.tick, 12u);
  EXPECT_EQ(tick.place_mm, Vec2(1.5, -2.5));
  EXPECT_FLOAT_EQ(static_cast<float>(tick.way_mm.x()), 0.015F);
  EXPECT_EQ(tick.energy_mj, 0.25);
  EXPECT_EQ(tick.run, 1u);
  EXPECT_EQ(tick.mark, 3u);
  ASSERT_EQ(record->prints.size(), 1u);
  EXPECT_EQ(record->prints[0].tick, 9u);
  EXPECT_EQ(record->prints[0].place_mm, -71.25);
  EXPECT_EQ(record->torn_bytes, 0u);
}

TEST(MarkRecord, ReadsTheVersionWithoutPrintMarks) {
  const auto record = ReadMarkRecord(kTwoTicks.parent_path() / "version_1.rec");
  ASSERT_TRUE(record) << record.error().message;
  EXPECT_EQ(record->ticks.size(), 2u);
  EXPECT_TRUE(record->prints.empty());
}

TEST(MarkRecord, IsReadableUpToWhereItWasCut) {
  std::vector<std::byte> bytes = EncodeMarkHeader({20, 5});
  for (std::uint64_t i = 0; i < 3; ++i)
    AppendBurntTick({i, {1, 2}, {0, 0}, 1, 1, 1}, bytes);
  for (std::size_t size = kMarkHeaderSize; size <= bytes.size(); ++size) {
    const auto record = ParseMarkRecord(std::span(bytes).first(size));
    ASSERT_TRUE(record);
    EXPECT_EQ(record->ticks.size(), (size - kMarkHeaderSize) / kMarkRecordSize);
    EXPECT_EQ(record->torn_bytes, (size - kMarkHeaderSize) % kMarkRecordSize);
  }
  bytes[kMarkHeaderSize + kMarkRecordSize + 10] ^= std::byte(1);
  EXPECT_EQ(ParseMarkRecord(bytes)->ticks.size(), 1u);
  bytes[3] ^= std::byte(1);
  EXPECT_FALSE(ParseMarkRecord(bytes));
  EXPECT_FALSE(ReadMarkRecord("/nonexistent/marks.rec"));
}

TEST(MarkRecord, AFileIsWrittenAsTheOtherWriterWroteIt) {
  const auto record = ReadMarkRecord(kTwoTicks);
  ASSERT_TRUE(record);
  const std::filesystem::path copy = test::FreshFolder() / "copy.rec";
  ASSERT_TRUE(WriteMarkRecord(copy, *record));
  EXPECT_EQ(*io::ReadWholeFile(copy, 1000), *io::ReadWholeFile(kTwoTicks, 1000));
}

TEST(MarkRecord, TheHeaderIsReadAlone) {
  const auto header = ReadMarkHeader(kTwoTicks);
  ASSERT_TRUE(header) << header.error().message;
  EXPECT_EQ(header->field_mm, 100);
  EXPECT_EQ(header->power_up, 77u);
  EXPECT_FALSE(ReadMarkHeader("/nonexistent/marks.rec"));
  const std::filesystem::path cut = test::FreshFolder() / "cut.rec";
  ASSERT_TRUE(io::WriteFileAtomically(cut, std::string_view("INTMARK1")));
  const auto none = ReadMarkHeader(cut);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kUnreadable);
  EXPECT_NE(none.error().message.find("cut.rec"), std::string::npos);
}

}  // namespace
}  // namespace intaglio::formats
