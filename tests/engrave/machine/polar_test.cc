#include "engrave/machine/polar.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <charconv>
#include <cmath>
#include <complex>
#include <numbers>

#include "engrave/core/check.h"
#include "engrave/io/csv.h"

namespace intaglio::machine {
namespace {

using std::numbers::pi;
using testing::HasSubstr;
using Plane = std::complex<double>;

constexpr double kDeg = pi / 180;

// Trochimczuk 2008, table 6: a = 50, d = 200, y2 = 70, r1 = 120 mm.
constexpr double kSideMm = 50, kY2Mm = 70;

PolarOptions OfTable6(ArmSide side = ArmSide::kLeft) {
  PolarOptions options;
  options.axis_distance_mm = 200;
  options.arm_length_mm = 120;
  options.side = side;
  return options;
}

Vec3 PlaceOf(double x_mm, double y_mm) { return {x_mm - kSideMm / 2, y_mm + kY2Mm, 0}; }

/// Where the beam is on the turned table, by turning plane vectors.
Plane Forward(const PolarOptions& options, const Vec3& axes) {
  const Plane arm_axis(0, options.axis_distance_mm);
  const Plane beam =
      arm_axis + options.arm_length_mm * std::polar(1.0, axes.x() - pi / 2);
  return beam * std::polar(1.0, -axes.y());
}

double Off(const PolarOptions& options, const Vec3& axes, const Vec3& place_mm) {
  return std::abs(Forward(options, axes) - Plane(place_mm.x(), place_mm.y()));
}

double NumberOf(const std::string& text) {
  double number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

/// Half a unit of the last printed digit.
double HalfDigit(const std::string& text) {
  return 0.51 * std::pow(10.0, -static_cast<double>(text.size() - text.find('.') - 1));
}

// The source's spreadsheet printed pi as 3.141592654: its arm is off by 8e-10 rad.
constexpr double kPrintedPi = 1e-9;

TEST(Polar, FirstFiveRowsOfTable6AreThePrintedDigits) {
  const auto table = io::ReadCsv(INTAGLIO_SOURCE_DIR "/tests/data/polar_table6.csv");
  ASSERT_TRUE(table) << table.error().message;
  ASSERT_EQ(table->rows.size(), 6u);
  const auto polar = MakePolar(OfTable6());
  for (std::size_t row = 0; row < 5; ++row) {
    const auto& f = table->rows[row].fields;
    const Vec3 place_mm = PlaceOf(NumberOf(f[0]), NumberOf(f[1]));
    const Vec3 axes = polar->ToAxes(place_mm, Vec3(6, 0, 0)).value();
    EXPECT_NEAR(axes.x() / kDeg, NumberOf(f[2]), HalfDigit(f[2])) << row;
    EXPECT_NEAR(axes.x(), NumberOf(f[3]), HalfDigit(f[3]) + kPrintedPi) << row;
    EXPECT_NEAR(axes.y() / kDeg, NumberOf(f[4]), HalfDigit(f[4])) << row;
    EXPECT_NEAR(axes.y(), NumberOf(f[5]), HalfDigit(f[5])) << row;
    const Vec3 printed(NumberOf(f[3]), NumberOf(f[5]), 0);
    EXPECT_LT(Off(OfTable6(), printed, place_mm), 1e-5) << "8 digits of a radian";
  }
}

// The source mixes the arm of one configuration with the table of the other.
TEST(Polar, SixthRowOfTable6IsCorrected) {
  const auto table = io::ReadCsv(INTAGLIO_SOURCE_DIR "/tests/data/polar_table6.csv");
  ASSERT_TRUE(table) << table.error().message;
  const auto& f = table->rows[5].fields;
  const Vec3 place_mm = PlaceOf(NumberOf(f[0]), NumberOf(f[1]));
  const Vec3 printed(NumberOf(f[3]), NumberOf(f[5]), 0);
  EXPECT_GT(Off(OfTable6(), printed, place_mm), 1.5) << "mm: the printed row is wrong";
  const Vec3 left = MakePolar(OfTable6())->ToAxes(place_mm, Vec3(6, 0, 0)).value();
  EXPECT_NEAR(left.x() / kDeg, 337.665, 5.1e-4);
  EXPECT_NEAR(left.y() / kDeg, 26.556, 5.1e-4);
  const Vec3 right =
      MakePolar(OfTable6(ArmSide::kRight))->ToAxes(place_mm, Vec3::Zero()).value();
  EXPECT_NEAR(right.x() / kDeg, 22.335, 5.1e-4);
  EXPECT_NEAR(right.y() / kDeg, -27.702, 5.1e-4);
  EXPECT_LT(Off(OfTable6(), left, place_mm), 1e-9);
  EXPECT_LT(Off(OfTable6(), right, place_mm), 1e-9);
}

// The source concludes that crossing the axis of symmetry needs another configuration.
TEST(Polar, OneConfigurationReachesBothHalvesOfThePiece) {
  const auto polar = MakePolar(OfTable6());
  int reached = 0, refused = 0;
  for (double x_mm = 0; x_mm <= kSideMm; x_mm += 0.5) {
    Vec3 before(6, 0, 0);
    for (double y_mm = 0; y_mm <= kSideMm; y_mm += 0.5) {
      const Vec3 place_mm = PlaceOf(x_mm, y_mm);
      const auto axes = polar->ToAxes(place_mm, before);
      if (!axes) {
        ++refused;
        EXPECT_LT(place_mm.head<2>().norm(), 82) << "near the table, where d - r1 = 80";
        continue;
      }
      ++reached;
      EXPECT_LT(Off(OfTable6(), *axes, place_mm), 1e-9);
      EXPECT_LT(std::sin(axes->x()), 0) << "the arm stays on its side";
      if (y_mm > 20) {
        EXPECT_LT((*axes - before).norm(), 0.05) << x_mm << ", " << y_mm;
      }
      before = *axes;
    }
  }
  // The printed machine does not reach all of its piece: the arm is too short for the
  // strip next to the table's axis.
  EXPECT_GT(reached, 7000);
  EXPECT_GT(refused, 1000);
}

// Scenario 1: the arm sweeps an arc while the table rests. The places are made by
// turning, the axes have to come out as they were turned.
TEST(Polar, TheArmSweepsWhileTheTableRests) {
  const PolarOptions options = OfTable6();
  const auto polar = MakePolar(options);
  Vec3 before(5.5, 0.5, 0);
  for (double table = 0.2; table < 0.9; table += 0.05) {
    for (double arm = 5.3; arm < 6.1; arm += 0.01) {
      const Plane at = Forward(options, Vec3(arm, table, 0));
      const Vec3 axes = polar->ToAxes(Vec3(at.real(), at.imag(), 0), before).value();
      EXPECT_NEAR(axes.x(), arm, 1e-9);
      EXPECT_NEAR(axes.y(), table, 1e-9);
      before = axes;
    }
  }
}

// Scenario 2: the table turns on and on under several pieces, the arm indexes each turn.
TEST(Polar, TheTableTurnsOnWhileTheArmIndexes) {
  const PolarOptions options = OfTable6();
  const auto polar = MakePolar(options);
  Vec3 before(5.5, 0, 0);
  for (int step = 0; step < 6300; ++step) {
    const double table = 0.01 * step, arm = 5.4 + 0.05 * (step / 630);
    const Plane at = Forward(options, Vec3(arm, table, 0));
    const Vec3 axes = polar->ToAxes(Vec3(at.real(), at.imag(), 0), before).value();
    EXPECT_NEAR(axes.x(), arm, 1e-9);
    EXPECT_NEAR(axes.y(), table, 1e-9) << "ten turns without a jump back";
    before = axes;
  }
}

std::string RefusalOf(const PolarOptions& options, const Vec3& place_mm) {
  const auto axes = MakePolar(options)->ToAxes(place_mm, Vec3::Zero());
  return axes ? "" : axes.error().message;
}

TEST(Polar, NamesWhyAPlaceIsRefused) {
  const PolarOptions options = OfTable6();
  EXPECT_THAT(RefusalOf(options, Vec3(0, 79, 0)),
              HasSubstr("nearer to the table's axis"));
  EXPECT_THAT(RefusalOf(options, Vec3(0, 80.5, 0)),
              HasSubstr("singular region of the folded arm"));
  EXPECT_THAT(RefusalOf(options, Vec3(0, 319.9, 0)),
              HasSubstr("singular region of the stretched arm"));
  EXPECT_THAT(RefusalOf(options, Vec3(0, 321, 0)),
              HasSubstr("farther from the table's axis"));
  // What the sentence calls served is.
  EXPECT_THAT(RefusalOf(options, Vec3(0, 79, 0)), HasSubstr("serves 81.4"));
  EXPECT_EQ(RefusalOf(options, Vec3(0, 81.5, 0)), "");
  PolarOptions equal = options;
  equal.arm_length_mm = equal.axis_distance_mm;
  EXPECT_THAT(RefusalOf(equal, Vec3::Zero()), HasSubstr("folded arm"))
      << "the table's axis, where every table angle is right";
}

TEST(Polar, OptionsOutsideTheirRangesThrow) {
  PolarOptions options;
  options.arm_length_mm = 0;
  EXPECT_THROW(MakePolar(options), PreconditionError);
  options = {};
  options.singular_margin_rad = 0;
  EXPECT_THROW(MakePolar(options), PreconditionError);
}

}  // namespace
}  // namespace intaglio::machine
