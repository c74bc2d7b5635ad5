// The fit of a head against fields that are traced ray by ray, with the noise of a
// camera.

#include "engrave/galvo/head_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "tests/engrave/galvo/traced_head.h"

namespace intaglio::galvo {
namespace {

using ::testing::HasSubstr;
using Field = std::function<Vec2(const Vec2&)>;

std::vector<GridMark> MarksOf(const Field& arrive, double width_mm, int nodes,
                              double noise_mm, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, noise_mm);
  std::vector<GridMark> marks;
  const FieldGrid grid = CentredGrid(width_mm, nodes);
  for (int j = 0; j < nodes; ++j) {
    for (int i = 0; i < nodes; ++i) {
      const Vec2 at_mm = grid.PlaceOf(i, j);
      marks.push_back({at_mm, arrive(at_mm) + Vec2(noise(random), noise(random))});
    }
  }
  return marks;
}

/// Greatest distance of the deviations from the true ones, um, inside 99 % of the field.
double WorstUm(const FieldGrid& deviations, Interpolation interpolation,
               const Field& arrive) {
  const auto table = CorrectionTable::Make(deviations, interpolation).value();
  const double half_mm = -deviations.first_mm;
  double worst_mm = 0;
  for (int i = -50; i <= 50; ++i) {
    for (int j = -50; j <= 50; ++j) {
      const Vec2 at_mm = 0.99 * half_mm / 50 * Vec2(i, j);
      worst_mm = std::max(worst_mm, (at_mm + table.At(at_mm) - arrive(at_mm)).norm());
    }
  }
  return 1000 * worst_mm;
}

FieldGrid MeasuredGrid(const std::vector<GridMark>& marks, double width_mm, int nodes) {
  FieldGrid grid = CentredGrid(width_mm, nodes);
  for (std::size_t i = 0; i < marks.size(); ++i)
    grid.values_mm[i] = marks[i].measured_mm - marks[i].command_mm;
  return grid;
}

TEST(HeadFit, OfNineByNineNoisyMarksIsAsNearAsTheReferenceFound) {
  const WrongField field(100, .03, 20);
  const auto arrive = [&](const Vec2& u) { return field.Arrive(u); };
  // The reference: noise, then four triangles, spline and nine numbers, um, each the mean
  // of 12 runs; other random numbers give other means, by 10 to 20 %.
  for (const auto& [noise_um, four_um, spline_um, model_um] :
       {std::array{5., 67., 18., 4.3}, {20., 81., 76., 17.}}) {
    double four = 0, spline = 0, model = 0;
    int with_surface = 0;
    constexpr int kRuns = 12;
    for (unsigned run = 0; run < kRuns; ++run) {
      const auto marks = MarksOf(arrive, 100, 9, noise_um / 1000, run);
      const auto fit = FitHead(marks, {100, field.focal_mm()});
      ASSERT_TRUE(fit.has_value()) << fit.error().message;
      const FieldGrid measured = MeasuredGrid(marks, 100, 9);
      four += WorstUm(measured, Interpolation::kFourTriangles, arrive) / kRuns;
      spline += WorstUm(measured, Interpolation::kSpline, arrive) / kRuns;
      model +=
          WorstUm(DeviationsOf(*fit, 100, 65), Interpolation::kSpline, arrive) / kRuns;
      with_surface += fit->surface_cells > 0;
      // 153 degrees of freedom: within 3 of its deviations, 6 % each.
      EXPECT_NEAR(1000 * fit->sigma_mm, noise_um, 0.18 * noise_um);
      EXPECT_NEAR(1000 * fit->unseen_rms_mm, noise_um, 0.25 * noise_um);
    }
    EXPECT_NEAR(four, four_um, 0.2 * four_um);
    EXPECT_NEAR(spline, spline_um, 0.2 * spline_um);
    EXPECT_NEAR(model, model_um, 0.25 * model_um);
    // Two standard errors: one of forty by chance.
    EXPECT_LE(with_surface, 1);
  }
}

TEST(HeadFit, HasTheTrueNumbersWithinTheirIntervals) {
  const HeadModel truth = HeadModel::FromNumbers(
      143.2, {2e-3, 4e-4, -3e-4, 1.01, .12, -.03, .2, -.1, 1e-3, 1.02});
  const auto numbers = truth.Numbers();
  int inside = 0;
  constexpr int kRuns = 40;
  for (unsigned run = 0; run < kRuns; ++run) {
    const auto fit = FitHead(
        MarksOf([&](const Vec2& u) { return truth.Arrive(u); }, 100, 11, .01, 100 + run),
        {100, 143.2});
    ASSERT_TRUE(fit.has_value()) << fit.error().message;
    const auto found = fit->model.Numbers();
    for (std::size_t k = 0; k < numbers.size(); ++k)
      inside += std::abs(found[k] - numbers[k]) <= fit->interval95[k];
  }
  // 400 intervals of 95 %, not independent: 380 +- 4 if they were.
  EXPECT_GT(inside, 0.91 * kHeadModelNumbers * kRuns);
  EXPECT_LT(inside, kHeadModelNumbers * kRuns);
}

TEST(HeadFit, FindsWhatTenNumbersDoNotHaveAndKeepsItAsASurface) {
  const WrongField field(100, .03, 20);
  const auto arrive = [&](const Vec2& u) {
    const double bump_mm = 0.15 * std::exp(-(u - Vec2(20, -10)).squaredNorm() / 800);
    return Vec2(field.Arrive(u) + bump_mm * Vec2(1, -.5));
  };
  const auto marks = MarksOf(arrive, 100, 17, .005, 5);
  const auto fit = FitHead(marks, {100, field.focal_mm()});
  ASSERT_TRUE(fit.has_value()) << fit.error().message;
  EXPECT_GT(fit->surface_cells, 0);
  EXPECT_LT(fit->unseen_rms_with_surface_mm, 0.4 * fit->unseen_rms_mm);
  const double with_um =
      WorstUm(DeviationsOf(*fit, 100, 65), Interpolation::kSpline, arrive);
  HeadFit numbers_alone = *fit;
  numbers_alone.surface_cells = 0;
  const double without_um =
      WorstUm(DeviationsOf(numbers_alone, 100, 65), Interpolation::kSpline, arrive);
  EXPECT_LT(with_um, 15);
  EXPECT_GT(without_um, 40);
}

TEST(HeadFit, LeavesOutAMarkThatWasTakenForAnother) {
  const WrongField field(100, .03, 20);
  const auto arrive = [&](const Vec2& u) { return field.Arrive(u); };
  auto marks = MarksOf(arrive, 100, 9, .005, 3);
  std::swap(marks[12].measured_mm, marks[13].measured_mm);
  const auto fit = FitHead(marks, {100, field.focal_mm()});
  ASSERT_TRUE(fit.has_value()) << fit.error().message;
  for (std::size_t i = 0; i < marks.size(); ++i)
    EXPECT_EQ(fit->used[i], i != 12 && i != 13) << i;
  EXPECT_LT(WorstUm(DeviationsOf(*fit, 100, 65), Interpolation::kSpline, arrive), 10);
}

TEST(HeadFit, RefusesWhatDoesNotDetermineAHead) {
  const WrongField field(100, .03, 20);
  const auto arrive = [&](const Vec2& u) { return field.Arrive(u); };
  EXPECT_EQ(FitHead(MarksOf(arrive, 100, 3, 0, 1), {100, 143}).error().message,
            "9 marks are too few to fit a head; measure 16 or more over the whole field");
  std::vector<GridMark> line;
  for (int i = 0; i < 30; ++i) line.push_back({{i - 15, 0}, {i - 15.1, 0}});
  EXPECT_EQ(FitHead(line, {100, 143}).error().message,
            "the marks do not determine the ten numbers of the head; mark a grid over "
            "the whole field, 5 x 5 or more");
  auto marks = MarksOf(arrive, 100, 9, 0, 1);
  marks[4].measured_mm.x() = std::nan("");
  EXPECT_EQ(FitHead(marks, {100, 143}).error().message,
            "mark 5 has a coordinate that is no number");
  marks[4] = {{70, 0}, {70, 0}};
  EXPECT_EQ(
      FitHead(marks, {100, 143}).error().message,
      "mark 5: commanded to (70, 0) mm, measured at (70, 0) mm, is not of a field of "
      "100 mm around 0; check field and units");
}

// Ten numbers of 25 marks: 40 degrees of freedom. The worst of the field is then a few
// times the noise, as the corners are known by one mark each.
TEST(HeadFit, OfFiveByFiveMarksIsRight) {
  for (const double share : {.03, .04}) {
    const WrongField field(100, share, 20);
    const auto arrive = [&](const Vec2& u) { return field.Arrive(u); };
    for (const double noise_um : {0., 5., 20.}) {
      for (unsigned run = 0; run < 20; ++run) {
        const auto fit = FitHead(MarksOf(arrive, 100, 5, noise_um / 1000, run),
                                 {100, field.focal_mm()});
        ASSERT_TRUE(fit.has_value()) << fit.error().message;
        EXPECT_LE(WorstUm(DeviationsOf(*fit, 100, 65), Interpolation::kSpline, arrive),
                  5 * noise_um + 0.01)
            << share << " " << noise_um << " " << run;
      }
    }
  }
}

TEST(HeadFit, HasTheRatioOfTheTwoAxes) {
  for (const double ratio : {0.97, 1.03}) {
    HeadModel truth = HeadModel::Ideal(143.2);
    truth.lens_ratio[1] = 0.24;
    truth.axes_ratio = ratio;
    for (const int nodes : {5, 9}) {
      const auto fit = FitHead(
          MarksOf([&](const Vec2& u) { return truth.Arrive(u); }, 100, nodes, .005, 8),
          {100, 143.2});
      ASSERT_TRUE(fit.has_value()) << fit.error().message;
      EXPECT_NEAR(fit->model.axes_ratio, ratio, 1.5 * fit->interval95[9]);
      EXPECT_LT(fit->interval95[9], 3e-4);
      EXPECT_EQ(fit->surface_cells, 0);
    }
  }
}

TEST(HeadFit, RefusesMarksThatAreNotThoseOfTheirCommands) {
  const WrongField field(100, .03, 20);
  const auto refusal = [&](int nodes, const Field& change) {
    const auto arrive = [&](const Vec2& u) { return change(field.Arrive(u)); };
    const auto fit =
        FitHead(MarksOf(arrive, 100, nodes, .005, 4), {100, field.focal_mm()});
    return fit ? std::string() : fit.error().message;
  };
  for (const int nodes : {5, 9}) {
    EXPECT_THAT(refusal(nodes, [](const Vec2& p) { return Vec2(p.y(), p.x()); }),
                HasSubstr("the two are swapped"));
    EXPECT_THAT(refusal(nodes, [](const Vec2& p) { return Vec2(-p.x(), p.y()); }),
                HasSubstr("measured x runs against the commanded one"));
    EXPECT_THAT(refusal(nodes, [](const Vec2& p) { return Vec2(-p.y(), p.x()); }),
                HasSubstr("turned by 90 degrees"));
    EXPECT_THAT(refusal(nodes, [](const Vec2& p) { return Vec2(p / 25.4); }),
                HasSubstr("times in y as commanded; give both in mm"));
    EXPECT_THAT(refusal(nodes, [](const Vec2& p) { return Vec2(p.x(), 1.4 * p.y()); }),
                HasSubstr("check the scale of both measured axes"));
  }
  // Rows in another order than their commands: each second row backwards.
  auto marks = MarksOf([&](const Vec2& u) { return field.Arrive(u); }, 100, 9, 0, 1);
  for (int j = 1; j < 9; j += 2) {
    for (int i = 0; i < 4; ++i)
      std::swap(marks[static_cast<std::size_t>(9 * j + i)].measured_mm,
                marks[static_cast<std::size_t>(9 * j + 8 - i)].measured_mm);
  }
  EXPECT_FALSE(FitHead(marks, {100, field.focal_mm()}).has_value());
}

}  // namespace
}  // namespace intaglio::galvo
