#include "engrave/io/crc32.h"

#include <gtest/gtest.h>

#include <random>
#include <string_view>
#include <vector>

namespace intaglio::io {
namespace {

/// Bit by bit, by the definition.
std::uint32_t ByTheBit(std::span<const std::byte> bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const std::byte byte : bytes) {
    crc ^= static_cast<std::uint32_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xedb88320u : 0);
  }
  return ~crc;
}

TEST(Crc32, HasTheCheckValueOfItsStandard) {
  const std::string_view check = "123456789";
  EXPECT_EQ(Crc32(std::as_bytes(std::span(check))), 0xcbf43926u);
  EXPECT_EQ(Crc32({}), 0u);
  EXPECT_EQ(Crc32({}, 7), 7u);
}

TEST(Crc32, GoesOnWhereItWas) {
  std::mt19937 random(5);
  std::vector<std::byte> bytes(1000);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  const std::span<const std::byte> all = bytes;
  const std::uint32_t whole = ByTheBit(all);
  EXPECT_EQ(Crc32(all), whole);
  for (const std::size_t size : {0u, 1u, 17u, 999u, 1000u}) {
    EXPECT_EQ(Crc32(all.subspan(size), Crc32(all.first(size))), whole) << size;
  }
}

}  // namespace
}  // namespace intaglio::io
