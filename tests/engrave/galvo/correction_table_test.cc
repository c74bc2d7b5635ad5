// Corrections against a field that is traced ray by ray: what each interpolation leaves.

#include "engrave/galvo/correction_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "tests/engrave/galvo/traced_head.h"

namespace intaglio::galvo {
namespace {

constexpr std::array kInterpolations = {Interpolation::kFourTriangles,
                                        Interpolation::kBilinear, Interpolation::kSpline};

FieldGrid GridBy(double width_mm, double pitch_mm,
                 const std::function<Vec2(const Vec2&)>& value) {
  FieldGrid grid =
      CentredGrid(width_mm, static_cast<int>(std::lround(width_mm / pitch_mm)) + 1);
  for (int j = 0; j < grid.nodes; ++j)
    for (int i = 0; i < grid.nodes; ++i)
      grid.values_mm[grid.IndexOf(i, j)] = value(grid.PlaceOf(i, j));
  return grid;
}

/// Greatest distance in um from where it was to arrive, inside 92 % of the field: what
/// is farther out may need commands outside the measured ones.
double WorstUm(const WrongField& field, const std::function<Vec2(const Vec2&)>& command) {
  constexpr int kHalf = 75;
  double worst_mm = 0;
  for (int i = -kHalf; i <= kHalf; ++i) {
    for (int j = -kHalf; j <= kHalf; ++j) {
      const Vec2 target_mm = 0.46 * field.width_mm() / kHalf * Vec2(i, j);
      worst_mm =
          std::max(worst_mm, (field.Arrive(command(target_mm)) - target_mm).norm());
    }
  }
  return 1000 * worst_mm;
}

struct Row {
  double width_mm, share, half_angle_deg, pitch_mm;
  double exact_um[3];         // commands exact at the nodes: by kInterpolations
  double four_um, spline_um;  // deviations measured once, solved
};

// galvo reference, measured there at 301 x 301 places and other splines at the border.
constexpr Row kRows[] = {{100, .03, 20, 25, {266, 228, 8.9}, -1, -1},
                         {100, .03, 20, 10, {51, 44, .37}, 42, .01},
                         {100, .03, 20, 5, {11.8, 10.2, .01}, 10.9, 0},
                         {50, .01, 10, 12.5, {45, 40, .5}, -1, -1},
                         {50, .01, 10, 5, {8.5, 7.7, .02}, 7.9, 0},
                         {20, .03, 20, 5, {53, 46, 1.8}, -1, -1},
                         {20, .03, 20, 2, {10.2, 8.9, .08}, 8.5, 0},
                         {20, .03, 20, 1, {2.4, 2.0, 0}, -1, -1}};

void ExpectNearUm(double actual_um, double expected_um, const char* what,
                  const Row& row) {
  // Two digits are printed; the worst of fewer places is up to 3 % smaller.
  EXPECT_NEAR(actual_um, expected_um, 0.06 + 0.05 * expected_um)
      << what << ", " << row.width_mm << " mm, pitch " << row.pitch_mm;
}

TEST(CorrectionTable, LeavesWhatTheReferenceFoundByPitchAndInterpolation) {
  for (const Row& row : kRows) {
    const WrongField field(row.width_mm, row.share, row.half_angle_deg);
    const FieldGrid exact = GridBy(row.width_mm, row.pitch_mm, [&](const Vec2& at) {
      return Vec2(field.Inverse(at) - at);
    });
    const FieldGrid measured = GridBy(row.width_mm, row.pitch_mm, [&](const Vec2& at) {
      return Vec2(field.Arrive(at) - at);
    });
    for (std::size_t k = 0; k < 3; ++k) {
      const auto table = CorrectionTable::Make(exact, kInterpolations[k]).value();
      const double worst_um =
          WorstUm(field, [&](const Vec2& t) { return Vec2(t + table.At(t)); });
      ExpectNearUm(worst_um, row.exact_um[k], "exact at the nodes", row);
    }
    if (row.four_um < 0) continue;
    for (const bool spline : {false, true}) {
      const auto table =
          CorrectionTable::Make(
              measured, spline ? Interpolation::kSpline : Interpolation::kFourTriangles)
              .value();
      const double worst_um =
          WorstUm(field, [&](const Vec2& t) { return CommandFor(t, table).value(); });
      ExpectNearUm(worst_um, spline ? row.spline_um : row.four_um, "solved", row);
    }
  }
}

TEST(CorrectionTable, SubtractedAtTheTargetLeavesAMultipleOfWhatASolvedOneDoes) {
  for (const auto& [width_mm, share, angle_deg, left_um] :
       {std::array{100., .03, 20., 170.}, {20., .03, 20., 40.}, {50., .01, 10., 14.}}) {
    const WrongField field(width_mm, share, angle_deg);
    const auto table =
        CorrectionTable::Make(
            GridBy(width_mm, width_mm / 40,
                   [&](const Vec2& at) { return Vec2(field.Arrive(at) - at); }),
            Interpolation::kSpline)
            .value();
    const double at_target_um =
        WorstUm(field, [&](const Vec2& t) { return Vec2(t - table.At(t)); });
    EXPECT_NEAR(at_target_um, left_um, 0.1 * left_um) << width_mm;
    EXPECT_LT(WorstUm(field, [&](const Vec2& t) { return CommandFor(t, table).value(); }),
              0.02);
  }
}

TEST(CorrectionTable, PassesThroughItsNodesAndIsContinuousAcrossCellsAndTriangles) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const FieldGrid grid =
      GridBy(20, 5, [&](const Vec2&) { return Vec2(normal(random), normal(random)); });
  std::uniform_real_distribution<double> within(-10, 10), cell(0, 5);
  constexpr double kStep = 1e-9;
  for (const Interpolation interpolation : kInterpolations) {
    const auto table = CorrectionTable::Make(grid, interpolation).value();
    for (int j = 0; j < grid.nodes; ++j) {
      for (int i = 0; i < grid.nodes; ++i) {
        EXPECT_LT(
            (table.At(grid.PlaceOf(i, j)) - grid.values_mm[grid.IndexOf(i, j)]).norm(),
            1e-13);
      }
    }
    for (int k = 0; k < 500; ++k) {
      const double y = within(random), s = cell(random);
      for (const auto& [p, q] :
           {std::pair{Vec2(-kStep, y), Vec2(kStep, y)},
            std::pair{Vec2(y, 5 - kStep), Vec2(y, 5 + kStep)},
            std::pair{Vec2(s - kStep, s + kStep), Vec2(s + kStep, s - kStep)},
            std::pair{Vec2(5 - s - kStep, s), Vec2(5 - s + kStep, s)}}) {
        // Slopes are at most 3 of 5 mm.
        EXPECT_LT((table.At(p) - table.At(q)).norm(), 1e-8);
      }
    }
  }
}

TEST(CorrectionTable, ReproducesWhatEachInterpolationHasExactly) {
  const auto plane = [](const Vec2& p) {
    return Vec2(1 + .3 * p.x() - .2 * p.y(), .1 * p.y());
  };
  const auto cubic = [](const Vec2& p) {
    return Vec2(1e-3 * p.x() * p.x() * p.x() * p.y(), p.y() * p.y() * p.y() - p.x());
  };
  std::mt19937 random(3);
  std::uniform_real_distribution<double> within(-10, 10);
  for (const Interpolation interpolation : kInterpolations) {
    const auto table = CorrectionTable::Make(GridBy(20, 5, plane), interpolation).value();
    for (int k = 0; k < 300; ++k) {
      const Vec2 p(within(random), within(random));
      EXPECT_LT((table.At(p) - plane(p)).norm(), 1e-12);
    }
  }
  const auto spline =
      CorrectionTable::Make(GridBy(20, 5, cubic), Interpolation::kSpline).value();
  for (int k = 0; k < 300; ++k) {
    const Vec2 p(within(random), within(random));
    EXPECT_LT((spline.At(p) - cubic(p)).norm(), 1e-9);  // of 1000 mm
  }
}

TEST(CorrectionTable, HoldsTheValueOfTheNearestPlaceOutsideTheGrid) {
  const auto table = CorrectionTable::Make(
                         GridBy(20, 5, [](const Vec2& p) { return Vec2(p.x(), p.y()); }),
                         Interpolation::kSpline)
                         .value();
  EXPECT_LT((table.At({1e9, -3}) - Vec2(10, -3)).norm(), 1e-12);
  EXPECT_LT((table.At({2, -1e300}) - Vec2(2, -10)).norm(), 1e-12);
  EXPECT_TRUE(table.At({std::nan(""), 0}).allFinite());
}

TEST(CorrectionTable, SolvedAtItsNodesNeedsNoIteration) {
  const WrongField field(100, .03, 20);
  const auto deviations =
      CorrectionTable::Make(
          GridBy(100, 10, [&](const Vec2& at) { return Vec2(field.Arrive(at) - at); }),
          Interpolation::kSpline)
          .value();
  const auto commands =
      CorrectionTable::Make(CommandGrid(deviations, 65).value(), Interpolation::kSpline)
          .value();
  EXPECT_LT(WorstUm(field, [&](const Vec2& t) { return Vec2(t + commands.At(t)); }), 0.1);
}

TEST(CorrectionTable, RefusesGridsThatAreNone) {
  FieldGrid grid = CentredGrid(10, 3);
  EXPECT_EQ(CorrectionTable::Make(grid, Interpolation::kSpline).error().message,
            "a spline through 3 nodes a side; give 4 or more, or interpolate bilinear");
  grid.values_mm[4].x() = std::nan("");
  EXPECT_EQ(CorrectionTable::Make(grid, Interpolation::kBilinear).error().message,
            "node 1 of row 1 of a grid is no number; measure it again");
  grid.values_mm.pop_back();
  EXPECT_EQ(CorrectionTable::Make(grid, Interpolation::kBilinear).error().message,
            "a grid of 3 x 3 nodes has 8 values; give one a node");
  grid.pitch_mm = 0;
  EXPECT_FALSE(CheckGrid(grid).has_value());
  grid.nodes = 1;
  EXPECT_FALSE(CheckGrid(grid).has_value());
  const auto steep = CorrectionTable::Make(
      GridBy(20, 5, [](const Vec2& p) { return Vec2(2 * p); }), Interpolation::kBilinear);
  EXPECT_NE(CommandFor({1, 1}, *steep).error().message.find("as fast as the place"),
            std::string::npos);
}

}  // namespace
}  // namespace intaglio::galvo
