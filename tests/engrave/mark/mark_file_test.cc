#include "engrave/mark/mark_file.h"

#include <gtest/gtest.h>

#include <cstring>

#include "engrave/io/crc32.h"

namespace intaglio::mark {
namespace {

constexpr std::size_t kMagicBytes = 8, kHeadBytes = 12;

MarkSet TwoMarks() {
  return {
      {{"black", 1000, 0.5, 20000, 1, 0, 0}},
      {{0, true, 0, {{{0, 0}, 0.25}, {{1, 0}, 0.25}}}, {0, false, 30, {{{5, 5}, 0}}}}};
}

/// With the checksum that its bytes have.
void Seal(std::vector<std::byte>& bytes) {
  const std::uint32_t crc = io::Crc32(std::span(bytes).subspan(kHeadBytes));
  std::memcpy(bytes.data() + kMagicBytes, &crc, sizeof crc);
}

TEST(MarkFile, MarksComeBackAsTheyWere) {
  const auto bytes = EncodeMarks(TwoMarks());
  const auto set = DecodeMarks(bytes);
  ASSERT_TRUE(set.has_value()) << set.error().message;
  EXPECT_EQ(EncodeMarks(*set), bytes);
  EXPECT_EQ(set->pens[0].name, "black");
  EXPECT_TRUE(set->marks[0].closed);
  EXPECT_EQ(set->marks[1].web_mm, 30);
}

MarkSet OneRow() {
  return {{{"black", 1000, 0.5, 20000, 1, 0, 0}},
          {{0, false, 0, {{{0, 0}}, {{1, 0}, 0, true}, {{2, 0}}, {{3, 0}}}}}};
}

TEST(MarkFile, ARowComesBackWithItsDarkWays) {
  const auto bytes = EncodeMarks(OneRow());
  const auto set = DecodeMarks(bytes);
  ASSERT_TRUE(set.has_value()) << set.error().message;
  EXPECT_EQ(EncodeMarks(*set), bytes);
  EXPECT_EQ(LitLengthOf(set->marks[0]), 2);
  // The four places of 24 bytes with a flag each stand at the end.
  const std::size_t dark_at = bytes.size() - 3 * 28 + 24;
  ASSERT_EQ(bytes[dark_at], std::byte{1});
  for (const int wrong : {0, 2}) {
    auto changed = bytes;
    changed[dark_at] = static_cast<std::byte>(wrong);
    Seal(changed);
    EXPECT_FALSE(DecodeMarks(changed).has_value()) << wrong;
  }
}

TEST(MarkFile, EachChangedOrMissingByteIsRefused) {
  const auto whole = EncodeMarks(TwoMarks());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    auto bytes = whole;
    bytes[i] ^= std::byte{4};
    EXPECT_FALSE(DecodeMarks(bytes).has_value()) << i;
    EXPECT_FALSE(DecodeMarks(std::span(whole).first(i)).has_value()) << i;
  }
}

// Another value than 0 and 1 was taken as 1, so that the file and the marks read of it
// had different checksums: a journal of it was that of another job. Found by a fuzzer.
TEST(MarkFile, AFlagIsZeroOrOne) {
  auto bytes = EncodeMarks(TwoMarks());
  // Behind the pen: length of its name, the name, six numbers of 8 bytes but one of 4.
  const std::size_t closed_at = kHeadBytes + 12 + 4 + 5 + 5 * 8 + 4 + 4;
  ASSERT_EQ(bytes[closed_at], std::byte{1});
  bytes[closed_at] = std::byte{3};
  Seal(bytes);
  const auto set = DecodeMarks(bytes);
  ASSERT_FALSE(set.has_value());
  EXPECT_EQ(
      set.error().message,
      "has a length or a flag that is not possible: it cannot be used; make the job "
      "again");
}

}  // namespace
}  // namespace intaglio::mark
