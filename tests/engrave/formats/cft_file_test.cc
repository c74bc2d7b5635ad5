#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <random>

#include "engrave/formats/point_file.h"
#include "engrave/formats/point_file_kinds.h"
#include "tests/test_folder.h"

namespace intaglio::formats {
namespace {

TEST(CftFile, IsCoordinatesALineWithoutExponents) {
  PointTable table{{{0.1, 20, -3.25}, {1e-7, 1e20, 0}}, {}, {"not written"}};
  const auto file = test::FreshFolder() / "two.cft";
  ASSERT_TRUE(WriteCft(file, table).has_value());
  EXPECT_EQ(test::ContentOf(file),
            "0.1 20 -3.25\r\n0.0000001 100000000000000000000 0\r\n");
}

TEST(CftFile, RoundTripKeepsEveryBit) {
  std::mt19937_64 random(6);
  PointTable table;
  table.points_mm = {{-0.0, std::numeric_limits<double>::denorm_min(),
                      -std::numeric_limits<double>::max()},
                     {-std::numeric_limits<double>::denorm_min(), 0, 0.1 + 0.2}};
  while (table.points_mm.size() < 2'000) {
    const Vec3 p(std::bit_cast<double>(random()), std::bit_cast<double>(random()),
                 std::bit_cast<double>(random()));
    if (p.allFinite()) table.points_mm.push_back(p);
  }
  const auto file = test::FreshFolder() / "cloud.cft";
  ASSERT_TRUE(WriteCft(file, table).has_value());
  const auto read = ReadPoints(file);
  ASSERT_TRUE(read.has_value()) << read.error().message;
  ASSERT_EQ(read->points_mm.size(), table.points_mm.size());
  for (std::size_t i = 0; i < table.points_mm.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(std::bit_cast<std::uint64_t>(read->points_mm[i][axis]),
                std::bit_cast<std::uint64_t>(table.points_mm[i][axis]));
    }
  }
}

}  // namespace
}  // namespace intaglio::formats
