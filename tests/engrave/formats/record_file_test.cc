// What all kinds of record files share, on a kind of this test's own.

#include "engrave/formats/record_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/test_folder.h"

namespace intaglio::formats {
namespace {

constexpr RecordKind kOwn{"INTTEST1", "test record", 2, 3, 32, 16};

std::vector<std::byte> ThreeRecords() {
  std::vector<std::byte> bytes = NewRecordHeader(kOwn);
  Seal(bytes);
  for (std::uint64_t i = 0; i < 3; ++i) {
    const auto record = AppendRecord(kOwn, bytes);
    PutNumber(record.data(), 100 + i);
    Seal(record);
  }
  return bytes;
}

struct Numbers {
  std::vector<std::uint64_t> all;
  std::uint64_t bytes_behind = 0;
};

Result<Numbers> Parse(std::span<const std::byte> bytes) {
  if (Status status = CheckRecordHeader(kOwn, bytes); !status)
    return tl::unexpected(status.error());
  Numbers numbers;
  numbers.bytes_behind = ReadRecords(kOwn, bytes, [&](const std::byte* at) {
    numbers.all.push_back(NumberAt<std::uint64_t>(at));
    return true;
  });
  return numbers;
}

TEST(RecordFile, EndsAtTheFirstByteThatIsDamagedOrMissing) {
  const auto whole = ThreeRecords();
  for (std::size_t at = 0; at < whole.size(); ++at) {
    const bool in_header = at < kOwn.header_size;
    const std::size_t readable = in_header ? 0 : (at - kOwn.header_size) / 16;
    auto bytes = whole;
    bytes[at] ^= std::byte(1);
    for (const auto& numbers : {Parse(bytes), Parse(std::span(whole).first(at))}) {
      ASSERT_EQ(numbers.has_value(), !in_header) << at;
      if (in_header) continue;
      EXPECT_EQ(numbers->all.size(), readable) << at;
    }
    if (in_header) {
      EXPECT_EQ(Parse(bytes).error().code, ErrorCode::kUnreadable) << at;
    }
  }
  EXPECT_EQ(Parse(whole)->all, (std::vector<std::uint64_t>{100, 101, 102}));
  EXPECT_EQ(Parse(std::span(whole).first(whole.size() - 1))->bytes_behind, 15U);
}

TEST(RecordFile, ReadsTheVersionsOfItsKindAlone) {
  for (std::uint32_t version = 0; version < 6; ++version) {
    auto bytes = NewRecordHeader(kOwn);
    PutNumber(bytes.data() + 8, version);
    Seal(bytes);
    const auto numbers = Parse(bytes);
    ASSERT_EQ(numbers.has_value(), version == 2 || version == 3) << version;
    if (!numbers) {
      EXPECT_EQ(numbers.error().code, ErrorCode::kUnsupported);
    }
  }
}

TEST(RecordFile, ItsErrorsNameTheFile) {
  const auto file = test::FreshFolder() / "own.rec";
  std::ofstream(file) << "something else that is longer than the header of this kind";
  for (const auto& error : {ReadRecordFile(file, 1000, Parse).error(),
                            ReadRecordHeader(kOwn, file, Parse).error(),
                            ReadRecordFile(file, 10, Parse).error()})
    EXPECT_NE(error.message.find(file.string()), std::string::npos) << error.message;
  EXPECT_EQ(ReadRecordFile(file, 10, Parse).error().code, ErrorCode::kTooLarge);
  std::filesystem::remove(file);
  EXPECT_EQ(ReadRecordHeader(kOwn, file, Parse).error().code, ErrorCode::kNotFound);
}

TEST(RecordFile, TheHeaderOfALargeFileIsReadAlone) {
  const auto file = test::FreshFolder() / "large.rec";
  const auto bytes = ThreeRecords();
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  std::filesystem::resize_file(file, std::uintmax_t{1} << 40);  // a hole
  const auto numbers = ReadRecordHeader(kOwn, file, Parse);
  ASSERT_TRUE(numbers) << numbers.error().message;
  EXPECT_TRUE(numbers->all.empty());
}

}  // namespace
}  // namespace intaglio::formats
