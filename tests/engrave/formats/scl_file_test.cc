#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <limits>
#include <random>

#include "engrave/formats/point_file.h"
#include "tests/test_folder.h"

// The bytes are taken apart by offsets written out here and by a CRC-32 bit by bit, not
// by the writer's own tables.

namespace intaglio::formats {
namespace {

using ::testing::HasSubstr;

/// CRC-32 of IEEE 802.3, a bit at a time.
std::uint32_t CrcBitByBit(std::string_view bytes) {
  std::uint32_t crc = 0xFFFF'FFFF;
  for (const char c : bytes) {
    crc ^= static_cast<std::uint8_t>(c);
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xEDB8'8320 : 0);
    }
  }
  return ~crc;
}

template <typename T>
T At(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

template <typename T>
void Change(std::string& bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

/// Makes the header's check sum right again.
void Seal(std::string& bytes) {
  const auto size = At<std::uint32_t>(bytes, 12);
  Change(bytes, size - 4, CrcBitByBit(std::string_view(bytes).substr(0, size - 4)));
}

PointTable TwoPoints() {
  return {{{1, 2, 3}, {-0.5, 1e-300, 4}},
          {{"source", std::vector<std::uint32_t>{7, 8}},
           {"channel_mask", std::vector<std::uint8_t>{1, 3}}},
          {"two"}};
}

std::string Written(const PointTable& table) {
  const auto file = test::FreshFolder() / "cloud.scl";
  EXPECT_TRUE(WriteScl(file, table).has_value());
  return test::ContentOf(file);
}

TEST(SclFile, HasItsPartsWhereTheFormatPutsThem) {
  const std::string bytes = Written(TwoPoints());
  EXPECT_EQ(bytes.substr(0, 8), "\x89SCL\r\n\x1a\n");
  EXPECT_EQ(At<std::uint32_t>(bytes, 8), 1u);
  const auto h = At<std::uint32_t>(bytes, 12);
  EXPECT_EQ(h, 44u + (3 + 6) + (3 + 12) + (4 + 3) + 4);
  EXPECT_EQ(At<std::uint64_t>(bytes, 16), 2u);
  EXPECT_EQ(At<double>(bytes, 24), 1.0);
  EXPECT_EQ(At<std::uint32_t>(bytes, 32), 1u | 4u) << "source, channel_mask";
  EXPECT_EQ(At<std::uint32_t>(bytes, 36), 2u);
  EXPECT_EQ(At<std::uint32_t>(bytes, 40), 1u);
  EXPECT_EQ(At<std::uint32_t>(bytes, h - 4), CrcBitByBit(bytes.substr(0, h - 4)));
  EXPECT_EQ(At<double>(bytes, h + 24), -0.5);
  EXPECT_EQ(At<std::uint32_t>(bytes, h + 48), 7u);
  EXPECT_EQ(At<std::uint8_t>(bytes, h + 57), 3u);
  ASSERT_EQ(bytes.size(), h + 58u + 4u);
  EXPECT_EQ(At<std::uint32_t>(bytes, h + 58), CrcBitByBit(bytes.substr(h, 58)));
}

TEST(SclFile, RoundTripKeepsEveryBitOfEveryColumn) {
  std::mt19937_64 random(7);
  PointTable table;
  while (table.points_mm.size() < 20'000) {
    const Vec3 p(std::bit_cast<double>(random()), std::bit_cast<double>(random()),
                 std::bit_cast<double>(random()));
    if (p.allFinite()) table.points_mm.push_back(p);
  }
  const std::size_t n = table.points_mm.size();
  table.columns = {{"tick", std::vector<double>(n, 0.1)},
                   {"f", std::vector<float>(n, 0.1f)},
                   {"i", std::vector<std::int32_t>(n, -5)},
                   {"u", std::vector<std::uint32_t>(n, 4'000'000'000)},
                   {"b", std::vector<std::uint8_t>(n, 255)}};
  table.comments = {"", "Größe in mm", "three"};
  const auto read = ParseScl(Written(table));
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ(read->columns, table.columns);
  EXPECT_EQ(read->comments, table.comments);
  ASSERT_EQ(read->points_mm.size(), n);
  EXPECT_EQ(std::memcmp(read->points_mm.data(), table.points_mm.data(), 24 * n), 0);
}

TEST(SclFile, HoldsNothingToo) {
  const auto read = ParseScl(Written({}));
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_TRUE(read->points_mm.empty());
}

TEST(SclFile, CutAnywhereIsRefused) {
  const std::string bytes = Written(TwoPoints());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto read = ParseScl(std::string_view(bytes).substr(0, size));
    ASSERT_FALSE(read.has_value()) << size;
    EXPECT_EQ(read.error().code, ErrorCode::kUnreadable);
  }
  EXPECT_THAT(ParseScl(bytes + "x").error().message, HasSubstr("1 extra byte follows"));
}

TEST(SclFile, EveryFlippedBitIsSeen) {
  const std::string bytes = Written(TwoPoints());
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::string damaged = bytes;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    const auto read = ParseScl(damaged);
    ASSERT_FALSE(read.has_value()) << "bit " << bit;
    EXPECT_EQ(read.error().code, ErrorCode::kUnreadable) << read.error().message;
  }
}

TEST(SclFile, NamesANewerVersionAndATextTransfer) {
  std::string newer = Written(TwoPoints());
  Change(newer, 8, std::uint32_t{2});
  Seal(newer);
  EXPECT_EQ(ParseScl(newer).error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(ParseScl(newer).error().message, HasSubstr("has version 2"));
  std::string text = Written(TwoPoints());
  text.erase(4, 1);  // CR LF to LF
  EXPECT_THAT(ParseScl(text).error().message, HasSubstr("transfer in text mode"));
  EXPECT_THAT(ParseScl("1 2 3\n").error().message, HasSubstr("not an SCL"));
}

TEST(SclFile, AppliesTheUnit) {
  std::string inches = Written(TwoPoints());
  Change(inches, 24, 25.4);
  Seal(inches);
  const auto read = ParseScl(inches);
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ(read->points_mm[0], Vec3(25.4, 2 * 25.4, 3 * 25.4));
  for (const double bad : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    Change(inches, 24, bad);
    Seal(inches);
    EXPECT_EQ(ParseScl(inches).error().code, ErrorCode::kInvalidValue);
  }
}

TEST(SclFile, BelievesNoCountThatTheFileCannotHold) {
  std::string bytes = Written(TwoPoints());
  for (const std::uint64_t count : {std::uint64_t{3}, std::uint64_t{1} << 61}) {
    Change(bytes, 16, count);
    Seal(bytes);
    PointFileLimits limits;
    limits.max_points = std::numeric_limits<std::uint64_t>::max();
    EXPECT_THAT(ParseScl(bytes, limits).error().message, HasSubstr("is truncated"));
  }
  EXPECT_EQ(ParseScl(bytes).error().code, ErrorCode::kTooLarge);
  Change(bytes, 16, std::uint64_t{2});
  Change(bytes, 36, std::uint32_t{0xFFFF'FFFF});
  Seal(bytes);
  EXPECT_THAT(ParseScl(bytes).error().message, HasSubstr("list of columns"));
}

TEST(SclFile, RefusesPointsThatAreNoPlace) {
  std::string bytes = Written({{{1, 2, 3}}, {}, {}});
  const auto h = At<std::uint32_t>(bytes, 12);
  Change(bytes, h + 8, std::numeric_limits<double>::infinity());
  Change(bytes, h + 24, CrcBitByBit(bytes.substr(h, 24)));
  EXPECT_EQ(ParseScl(bytes).error().code, ErrorCode::kInvalidValue);
  EXPECT_THAT(ParseScl(bytes).error().message, HasSubstr("point 1 is at (1, inf, 3)"));
}

}  // namespace
}  // namespace intaglio::formats
