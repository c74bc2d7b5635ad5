#include "engrave/galvo/field_window.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <random>

#include "engrave/galvo/head.h"
#include "engrave/galvo/head_fit.h"

namespace intaglio::galvo {
namespace {

constexpr double kWidthMm = 100, kBorderRad = 20 * std::numbers::pi / 180;
constexpr double kFocalMm = kWidthMm / 2 / kBorderRad;
constexpr int kNodes = 129;
// A line of the window from the next; between them it is the narrower one.
constexpr double kLineMm = kWidthMm / 512;

/// By 3 % at the border: shrunk below 0, widened above.
Head HeadWith(double ratio) {
  return {LensPlace::kBehindMirrors,
          {kFocalMm, 0, kFocalMm * ratio / (kBorderRad * kBorderRad), 0},
          0,
          0};
}

CorrectionTable CommandsFor(double ratio) {
  HeadFit fit;
  fit.model = HeadModel::Ideal(kFocalMm);
  fit.model.lens_ratio[1] = ratio / (kBorderRad * kBorderRad);
  const auto deviations =
      CorrectionTable::Make(DeviationsOf(fit, kWidthMm, kNodes), Interpolation::kSpline)
          .value();
  return CorrectionTable::Make(CommandGrid(deviations, kNodes).value(),
                               Interpolation::kBilinear)
      .value();
}

TEST(FieldWindow, WithoutACorrectionIsTheField) {
  const FieldWindow window(kWidthMm);
  EXPECT_TRUE(window.is_whole_field());
  EXPECT_EQ(window.square_mm(), kWidthMm);
  for (const Vec2& corner : {Vec2(50, 50), Vec2(-50, 50), Vec2(50, -50), Vec2(-50, -50)})
    EXPECT_TRUE(window.Has(corner));
  EXPECT_FALSE(window.Has({50.001, 0}));
  EXPECT_FALSE(window.Has({0, -50.001}));
  EXPECT_FALSE(window.Has({0, std::numeric_limits<double>::quiet_NaN()}));
}

// The oracle is the inverse of the head's optics: the angles that put the beam there.
TEST(FieldWindow, HasThePlacesWhoseAnglesTheHeadCommands) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-50, 50);
  for (const double ratio : {-0.03, 0.03}) {
    const Head head = HeadWith(ratio);
    const FieldWindow window(kWidthMm, CommandsFor(ratio));
    int inside = 0, outside = 0;
    for (int i = 0; i < 20'000; ++i) {
      const Vec2 at_mm(place(random), place(random));
      const double command_mm =
          (kFocalMm * AnglesFor(at_mm, head).value()).cwiseAbs().maxCoeff();
      if (std::abs(command_mm - 50) < 1.1 * kLineMm) continue;
      EXPECT_EQ(window.Has(at_mm), command_mm < 50) << at_mm.transpose();
      ++(command_mm < 50 ? inside : outside);
    }
    EXPECT_GT(inside, 15'000);
    EXPECT_EQ(outside > 500, ratio < 0) << outside;
  }
}

TEST(FieldWindow, OfAShrunkFieldIsASquareWhoseCornersAreReached) {
  const FieldWindow window(kWidthMm, CommandsFor(-0.03));
  EXPECT_FALSE(window.is_whole_field());
  const double half_mm = window.square_mm() / 2;
  const Head head = HeadWith(-0.03);
  const auto command_mm = [&](double at_mm) {
    return (kFocalMm * AnglesFor({at_mm, at_mm}, head).value()).cwiseAbs().maxCoeff();
  };
  EXPECT_LE(command_mm(half_mm), 50 + 1e-3);  // of the table, bilinear
  EXPECT_GE(command_mm(half_mm + 1.1 * kLineMm), 50);
  EXPECT_TRUE(FieldWindow(kWidthMm, CommandsFor(0.03)).is_whole_field());
}

TEST(FieldWindow, DisplacementsBringAllPlacesIntoItAndNoOthersDo) {
  const FieldWindow window(kWidthMm, CommandsFor(-0.03));
  const std::vector<Vec2> places_mm = {{300, 45}, {310, 0}, {304, -30}};
  const Span by = window.Displacements(places_mm, 0.2);
  ASSERT_FALSE(by.empty());
  const auto all_in = [&](double by_mm) {
    return std::ranges::all_of(places_mm, [&](const Vec2& place_mm) {
      const double x_mm = place_mm.x() + by_mm;
      return window.Has({x_mm - 0.2, place_mm.y()}) &&
             window.Has({x_mm + 0.2, place_mm.y()});
    });
  };
  EXPECT_TRUE(all_in(by.from_mm + 1e-6) && all_in(by.to_mm - 1e-6));
  // The margin counts aside, too: a line of the window and the slope of its border.
  EXPECT_FALSE(all_in(by.from_mm - 0.2) || all_in(by.to_mm + 0.2));
  EXPECT_TRUE(window.Displacements(std::vector<Vec2>{{0, 49.9}}, 0.2).empty());
  EXPECT_TRUE(window.Displacements(std::vector<Vec2>{{0, 0}, {101, 0}}, 0).empty());
}

}  // namespace
}  // namespace intaglio::galvo
