// Files of control boards against nodes of published files and their own bytes.

#include "engrave/galvo/files/ct5.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/galvo/files/ct5_tables.h"

namespace intaglio::galvo {
namespace {

// Lenses 721 and 2982: polynomials of the ReadMe beside the files, calibration, and nodes
// of the files themselves: row y = 128, each 32nd column, and the corner.
struct PublishedLens {
  int bit_per_mm;
  std::array<double, 4> heights_mm;
  std::vector<int> row;
  int corner_x, corner_y;
  double largest_x_deg, largest_y_deg;  // mechanical, as printed
};
const PublishedLens kLenses[] = {{5184,
                                  {255.059, -1.365, 1.493, -18.087},
                                  {32821, 156702, 279616, 402055, 524288, 646521},
                                  1039,
                                  42724,
                                  12.163,
                                  11.425},
                                 {8656,
                                  {163.064, -1.259, -21.465, -26.664},
                                  {51609, 175217, 293764, 409619, 524288},
                                  613,
                                  42393,
                                  12.173,
                                  11.202}};
constexpr double kCalibrationDeg = 11.7;

Ct5 FileOf(const PublishedLens& lens) {
  return Ct5OfHead({LensPlace::kBehindMirrors, lens.heights_mm, 0, 0}, lens.bit_per_mm,
                   kCalibrationDeg)
      .value();
}

TEST(Ct5, OfTheReadMesPolynomialHasThePublishedNodesWithinTwoBits) {
  for (const PublishedLens& lens : kLenses) {
    const Ct5 file = FileOf(lens);
    for (std::size_t k = 0; k < lens.row.size(); ++k) {
      EXPECT_NEAR(file.tables[0][Ct5::IndexOf(32 * static_cast<int>(k), 128)],
                  lens.row[k], 2);
    }
    EXPECT_NEAR(file.tables[0][0], lens.corner_x, 2);
    EXPECT_NEAR(file.tables[1][0], lens.corner_y, 2);
  }
}

TEST(Ct5, OfTheReadMesPolynomialHasThePrintedLargestAngles) {
  for (const PublishedLens& lens : kLenses) {
    const Ct5 file = FileOf(lens);
    const double deg_per_bit = kCalibrationDeg / (0.96 * kCt5Zero);
    for (const auto& [table, largest_deg] :
         {std::pair{file.tables[0], lens.largest_x_deg},
          std::pair{file.tables[1], lens.largest_y_deg}}) {
      const int lowest = *std::min_element(table.begin(), table.end());
      EXPECT_NEAR(deg_per_bit * (kCt5Zero - lowest), largest_deg, 6e-4);
    }
  }
}

TEST(Ct5, HasInTablesTwoAndThreeTheInverseOfTheFirstTwo) {
  const PublishedLens& lens = kLenses[0];
  const Ct5 file = FileOf(lens);
  const Head head{LensPlace::kBehindMirrors, lens.heights_mm, 0, 0};
  const double rad_per_bit =
      kCalibrationDeg / (0.96 * kCt5Zero) * 2 * std::numbers::pi / 180;
  for (int y = 16; y <= 240; y += 16) {
    for (int x = 16; x <= 240; x += 16) {
      const Vec2 output(4096 * (x - 128), 4096 * (y - 128));
      const Vec2 target = lens.bit_per_mm * FieldOf(rad_per_bit * output, head);
      const std::size_t at = Ct5::IndexOf(x, y);
      // The published inverses agree to 2 bits; between nodes ours is bilinear.
      EXPECT_NEAR(file.tables[2][at] - kCt5Zero, target.x() - output.x(), 3);
      EXPECT_NEAR(file.tables[3][at] - kCt5Zero, target.y() - output.y(), 3);
    }
  }
}

TEST(Ct5, IsWrittenAgainBitForBit) {
  const std::string bytes = WriteCt5(FileOf(kLenses[1]));
  ASSERT_EQ(bytes.size(), 1'056'852U);
  EXPECT_EQ(bytes.substr(0, 12), std::string("\0\0\0\0\xd0\x21\0\0\xbd\x0c\0\0", 12));
  const auto file = ReadCt5(bytes, "lens.ct5");
  ASSERT_TRUE(file.has_value()) << file.error().message;
  EXPECT_FALSE(file->kept_check.has_value());
  EXPECT_EQ(WriteCt5(*file), bytes);

  std::string older = bytes;
  older.back() = static_cast<char>(older.back() + 1);
  const auto kept = ReadCt5(older, "older.ct5");
  ASSERT_TRUE(kept.has_value()) << kept.error().message;
  EXPECT_TRUE(kept->kept_check.has_value());
  EXPECT_EQ(WriteCt5(*kept), older);
}

TEST(Ct5, AsACorrectionPutsTheBeamWithinTwoBits) {
  const PublishedLens& lens = kLenses[0];
  const auto table =
      CorrectionTable::Make(GridOf(FileOf(lens)), Interpolation::kBilinear).value();
  const Head head{LensPlace::kBehindMirrors, lens.heights_mm, 0, 0};
  const double rad_per_mm =
      kCalibrationDeg / (0.96 * kCt5Zero) * 2 * std::numbers::pi / 180 * lens.bit_per_mm;
  for (double x_mm = -90; x_mm <= 90; x_mm += 7.7) {
    for (double y_mm = -90; y_mm <= 90; y_mm += 7.7) {
      const Vec2 target(x_mm, y_mm);
      const Vec2 place = FieldOf(rad_per_mm * (target + table.At(target)), head);
      EXPECT_LT((place - target).norm() * lens.bit_per_mm, 2) << target;
    }
  }
}

TEST(Ct5, OfACorrectionHasItsOutputsAndTheHeaderOfTheFileBefore) {
  Ct5 before = FileOf(kLenses[0]);
  before.header[kCt5FileNumber] = 721;
  const auto commands =
      CorrectionTable::Make(GridOf(before), Interpolation::kBilinear).value();
  const auto same = Ct5Of(commands, 5184, &before);
  ASSERT_TRUE(same.has_value()) << same.error().message;
  EXPECT_EQ(same->header, before.header);
  EXPECT_EQ(same->tables, before.tables);
  EXPECT_FALSE(Ct5Of(commands, 0, nullptr).has_value());
}

TEST(Ct5, RefusesWhatIsNone) {
  EXPECT_EQ(ReadCt5("abc", "a.ct5").error().message,
            "a.ct5: has 3 bytes, a .ct5 file has 1056852; give the file as the control "
            "board's maker supplies it");
  Ct5 file = FileOf(kLenses[0]);
  file.tables[1][257 * 3 + 5] = -7;
  EXPECT_EQ(ReadCt5(WriteCt5(file), "a.ct5").error().message,
            "a.ct5: table 1, row 3, column 5: output -7 is outside 0..1048576; the file "
            "is damaged, copy it again");
  file.header[kCt5Calibration] = 0;
  EXPECT_EQ(ReadCt5(WriteCt5(file), "a.ct5").error().message,
            "a.ct5: the calibration is 0 bit/mm; give a file with one above 0");
}

}  // namespace
}  // namespace intaglio::galvo
