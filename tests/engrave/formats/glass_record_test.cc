#include "engrave/formats/glass_record.h"

#include <gtest/gtest.h>

#include <cstring>

#include "engrave/io/crc32.h"

namespace intaglio::formats {
namespace {

std::vector<std::byte> Sample(int count) {
  auto bytes = EncodeGlassHeader({Vec3(50, 60, 70), 1.5195, 0.2, 0xABCD1234});
  for (int i = 0; i < count; ++i) {
    AppendGlassCrack({100u + static_cast<unsigned>(i), Vec3(i, 0.1 * i, -i / 3.0), 30.0,
                      static_cast<std::uint8_t>(i % 4), i % 5 != 0, 0,
                      static_cast<std::uint8_t>(1 + 7 * i % 64)},
                     bytes);
  }
  return bytes;
}

TEST(GlassRecord, RoundTripIsExact) {
  const auto record = ParseGlassRecord(Sample(20));
  ASSERT_TRUE(record.has_value());
  EXPECT_EQ(record->header.block_size_mm, Vec3(50, 60, 70));
  EXPECT_EQ(record->header.refractive_index, 1.5195);
  EXPECT_EQ(record->header.power_up, 0xABCD1234);
  ASSERT_EQ(record->cracks.size(), 20u);
  EXPECT_EQ(record->cracks[7].position_mm, Vec3(7, 0.1 * 7, -7 / 3.0));
  EXPECT_EQ(record->cracks[7].tick, 107u);
  EXPECT_EQ(record->cracks[7].channel, 3);
  EXPECT_FALSE(record->cracks[5].in_glass);
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(record->cracks[static_cast<std::size_t>(i)].channel, i % 4);
    EXPECT_EQ(record->cracks[static_cast<std::size_t>(i)].station, 1 + 7 * i % 64);
  }
}

TEST(GlassRecord, ACollisionIsNoCrack) {
  auto bytes = Sample(2);
  AppendGlassCollision({77, Vec3(25, 24.5, 37.5), 19.5, 1, 64}, bytes);
  AppendGlassCrack({105, Vec3(1, 2, 3), 30, 0, true}, bytes);
  const auto record = ParseGlassRecord(bytes);
  ASSERT_TRUE(record.has_value());
  EXPECT_EQ(record->cracks.size(), 3u);
  EXPECT_EQ(record->torn_bytes, 0u);
  ASSERT_EQ(record->collisions.size(), 1u);
  const GlassCollision& collision = record->collisions.front();
  EXPECT_EQ(collision.tick, 77u);
  EXPECT_EQ(collision.focus_mm, Vec3(25, 24.5, 37.5));
  EXPECT_EQ(collision.overlap_mm, 19.5);
  EXPECT_EQ(collision.body, 1);
  EXPECT_EQ(collision.solid, 64);
}

// Those of engravers of before, which had no bodies.
TEST(GlassRecord, OfVersion1IsRead) {
  auto bytes = Sample(2);
  bytes[8] = std::byte{1};
  const std::uint32_t crc = io::Crc32(std::span(bytes).first(60));
  std::memcpy(bytes.data() + 60, &crc, sizeof crc);
  const auto record = ParseGlassRecord(bytes);
  ASSERT_TRUE(record.has_value()) << record.error().message;
  EXPECT_EQ(record->cracks.size(), 2u);
  bytes[8] = std::byte{3};
  const std::uint32_t later = io::Crc32(std::span(bytes).first(60));
  std::memcpy(bytes.data() + 60, &later, sizeof later);
  EXPECT_FALSE(ParseGlassRecord(bytes).has_value());
}

TEST(GlassRecord, CutAnywhereKeepsEveryWholeRecord) {
  const auto bytes = Sample(3);
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    const auto record = ParseGlassRecord(std::span(bytes).first(size));
    ASSERT_EQ(record.has_value(), size >= kGlassHeaderSize);
    if (record) {
      EXPECT_EQ(record->cracks.size(), (size - kGlassHeaderSize) / kGlassRecordSize);
    }
  }
}

TEST(GlassRecord, DamageEndsTheReading) {
  auto bytes = Sample(3);
  bytes[kGlassHeaderSize + kGlassRecordSize + 9] ^= std::byte{1};
  const auto record = ParseGlassRecord(bytes);
  ASSERT_TRUE(record.has_value());
  EXPECT_EQ(record->cracks.size(), 1u);
}

}  // namespace
}  // namespace intaglio::formats
