// .ctb and .cor files, assembled byte by byte by their published layouts.

#include "engrave/galvo/files/correction_files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

namespace intaglio::galvo {
namespace {

template <typename Number>
void Put(std::string& bytes, std::size_t at, Number value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

std::string StraightCtb() {
  std::string bytes(2 * 65 * 65 * 2, '\0');
  for (int y = 0; y < 65; ++y) {
    for (int x = 0; x < 65; ++x) {
      const auto at = static_cast<std::size_t>(2 * (y * 65 + x));
      Put(bytes, at, static_cast<std::uint16_t>(std::min(1024 * x, 65535)));
      Put(bytes, at + 8450, static_cast<std::uint16_t>(std::min(1024 * y, 65535)));
    }
  }
  return bytes;
}

TEST(CtbFile, OfOneToOneCorrectsNothingAndOneNodeIsWhereItBelongs) {
  std::string bytes = StraightCtb();
  auto grid = ReadCtb(bytes, "a.ctb", 512);
  ASSERT_TRUE(grid.has_value()) << grid.error().message;
  for (const Vec2& value_mm : grid->values_mm) EXPECT_EQ(value_mm, Vec2(0, 0));
  EXPECT_EQ(grid->PlaceOf(32, 32), Vec2(0, 0));
  EXPECT_EQ(grid->PlaceOf(0, 1), Vec2(-64, -62));
  // x of row 3, column 40, 256 bits to the right: 0.5 mm.
  Put(bytes, 2 * (3 * 65 + 40), static_cast<std::uint16_t>(40 * 1024 + 256));
  grid = ReadCtb(bytes, "a.ctb", 512);
  EXPECT_EQ(grid->values_mm[grid->IndexOf(40, 3)], Vec2(0.5, 0));
  EXPECT_EQ(grid->values_mm[grid->IndexOf(3, 40)], Vec2(0, 0));
}

TEST(CtbFile, RefusesAnotherSizeAndNoCalibration) {
  EXPECT_EQ(ReadCtb("x", "a.ctb", 512).error().message,
            "a.ctb: has 1 bytes, a .ctb file has 16900; give the file as the control "
            "board's maker supplies it");
  EXPECT_FALSE(ReadCtb(StraightCtb(), "a.ctb", 0).has_value());
}

std::string SecondCor() {
  std::string bytes(33'840, '\0');
  std::memcpy(bytes.data(), "JCZ_COR_2_1", 11);
  Put(bytes, 28, 655.36);  // a field of 100 mm
  Put(bytes, 36 + 8 * (3 * 65 + 40), std::int32_t{-655});
  Put(bytes, 36 + 8 * (3 * 65 + 40) + 4, std::int32_t{1311});
  return bytes;
}

TEST(CorFile, OfBothVersionsHasItsNodesInMillimetres) {
  std::string first(528 + 65 * 65 * 16, '\0');
  std::memcpy(first.data(), "LMC1COR_1.0", 11);
  Put(first, 24 + 43 * 8, 655.36);
  Put(first, 528 + 16 * (3 * 65 + 40), -655.0);
  Put(first, 528 + 16 * (3 * 65 + 40) + 8, 1311.0);
  std::string wide = first;
  for (std::size_t i = 0; i < 11; ++i) {
    wide[2 * i] = "LMC1COR_1.0"[i];
    wide[2 * i + 1] = '\0';
  }
  for (const std::string& bytes : {SecondCor(), first, wide}) {
    const auto grid = ReadCor(bytes, "a.cor");
    ASSERT_TRUE(grid.has_value()) << grid.error().message;
    EXPECT_EQ(grid->PlaceOf(32, 32), Vec2(0, 0));
    EXPECT_NEAR(grid->PlaceOf(64, 0).x(), 50, 1e-12);
    const Vec2 node_mm = grid->values_mm[grid->IndexOf(40, 3)];
    EXPECT_NEAR(node_mm.x(), -655 / 655.36, 1e-12);
    EXPECT_NEAR(node_mm.y(), 1311 / 655.36, 1e-12);
    EXPECT_EQ(grid->values_mm[grid->IndexOf(3, 40)], Vec2(0, 0));
  }
}

TEST(CorFile, RefusesWhatIsNoneWithWhereItIs) {
  EXPECT_EQ(ReadCor("hello", "a.cor").error().message,
            "a.cor: begins with neither JCZ_COR_2_1 nor LMC1COR_1.0; give a .cor file of "
            "an LMC board");
  EXPECT_EQ(ReadCor("JCZ_COR_2_1", "a.cor").error().message,
            "a.cor: has 11 bytes, a file of its version has 33840; copy it again");
  std::string bytes = SecondCor();
  Put(bytes, 36 + 8 * 66, std::int32_t{70'000});
  EXPECT_EQ(ReadCor(bytes, "a.cor").error().message,
            "a.cor: row 1, column 1: a correction of (70000, 0) units is more than the "
            "field of 65536; copy the file again");
  Put(bytes, 28, std::nan(""));
  EXPECT_NE(ReadCor(bytes, "a.cor").error().message.find("a scale of nan"),
            std::string::npos);
}

}  // namespace
}  // namespace intaglio::galvo
