// Circles on a moving web, burnt by a head of the tests' own, with everything followed
// and with one thing after another left out, as the reference did over 49 places of a
// field of 20 mm with 3 % of distortion.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/galvo/head_output.h"
#include "engrave/galvo/web_follower.h"
#include "tests/engrave/galvo/virtual_head.h"

namespace intaglio::galvo {
namespace {

constexpr double kFieldMm = 20, kLag = 2e-4, kTick = 1e-5;

struct Case {
  double diameter_mm, beam_mm_s, web_mm_s;
};
constexpr Case kCases[] = {{1, 500, 100}, {1.5, 1500, 200}, {1, 1500, 200}};

struct Given {
  bool corrected = true, followed = true, raw_encoder = false;
  double lag_s = kLag;
  bool run_in = true, lead = true;
  bool laser_waits = false;  // for the lag, without lead
};

struct Worst {
  double gap_um = 0, shape_um = 0, place_um = 0, diameter_um = 0;
};

const WrongField& WebField() {
  static const WrongField field(kFieldMm, .03, 20);
  return field;
}

const CorrectionTable& Correction() {
  static const CorrectionTable table = [] {
    FieldGrid grid = CentredGrid(kFieldMm, 11);  // pitch 2
    for (int j = 0; j < 11; ++j) {
      for (int i = 0; i < 11; ++i) {
        const Vec2 at_mm = grid.PlaceOf(i, j);
        grid.values_mm[grid.IndexOf(i, j)] = WebField().Inverse(at_mm) - at_mm;
      }
    }
    return CorrectionTable::Make(grid, Interpolation::kFourTriangles).value();
  }();
  return table;
}

std::vector<MarkTick> TicksOf(const Case& c, const Given& given, const Vec2& at_mm) {
  MarkStroke circle;
  circle.closed = true;
  constexpr int kPlaces = 720;
  for (int k = 0; k < kPlaces; ++k) {
    const double a = 2 * std::numbers::pi * k / kPlaces;
    circle.points_mm.push_back(at_mm +
                               c.diameter_mm / 2 * Vec2(std::cos(a), std::sin(a)));
  }
  MarkTickOptions options;
  options.mark_mm_s = c.beam_mm_s;
  options.jump_mm_s = 5000;
  options.run_in_s = given.run_in ? 6e-4 : 0;
  options.lag_s = given.lag_s;
  options.lead_servo = given.lead;
  options.jump_delay_s = 3e-3;  // all is at rest when a mark without a run-in begins
  if (given.laser_waits) options.laser_on_delay_s = options.laser_off_delay_s = kLag;
  return MakeMarkTicks(std::vector{circle}, circle.points_mm.front(), options).value();
}

FittedCircle Burn(const Case& c, const Given& given, const Vec2& at_mm, Worst& worst) {
  const std::vector<MarkTick> ticks = TicksOf(c, given, at_mm);
  WebFollowerOptions options;
  options.preview_s = given.lead || given.laser_waits ? given.lag_s : 0;
  WebFollower follower(options, 0, c.web_mm_s);
  OutputMaker outputs(kFieldMm, given.corrected ? &Correction() : nullptr);
  VirtualHead head(&WebField(), kFieldMm, given.lag_s);
  // The tracker has watched the web before the mark begins.
  constexpr int kWatched = 2000;
  const auto count = [&](double web_mm) {
    return EncoderCount(web_mm, options.count_mm);
  };
  for (int k = -kWatched; k < 0; ++k)
    (void)follower.Update(
        count(c.web_mm_s * kTick * k) - count(-c.web_mm_s * kTick * kWatched), 0);
  const double watched_mm =
      options.count_mm * static_cast<double>(-count(-c.web_mm_s * kTick * kWatched));
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    const double web_mm = c.web_mm_s * kTick * static_cast<double>(k);
    const auto counted = count(web_mm) - count(-c.web_mm_s * kTick * kWatched);
    Vec2 by_mm = follower.Update(counted, 0) - Vec2(watched_mm - 0.37 * .023, 0);
    if (given.raw_encoder)
      by_mm.x() = (static_cast<double>(count(web_mm)) + 0.13) * options.count_mm;
    if (!given.followed) by_mm.setZero();
    const HeadOutput out = outputs.Make(ticks[k], by_mm);
    head.Output(out.x, out.y, out.laser, web_mm, c.web_mm_s);
  }
  EXPECT_EQ(outputs.lit_outside_count(), 0U);
  const std::vector<Vec2> burnt = head.TakeBurnt();
  const FittedCircle circle = FitCircle(burnt);
  worst.gap_um = std::max(worst.gap_um, 1e3 * (burnt.back() - burnt.front()).norm());
  worst.shape_um = std::max(worst.shape_um, 1e3 * circle.shape_mm);
  worst.place_um = std::max(worst.place_um, 1e3 * (circle.centre_mm - at_mm).norm());
  const double by_um = 1e3 * (2 * circle.radius_mm - c.diameter_mm);
  if (std::abs(by_um) > std::abs(worst.diameter_um)) worst.diameter_um = by_um;
  return circle;
}

Worst Over49Places(const Case& c, const Given& given) {
  const double moved_mm =
      c.web_mm_s * (std::numbers::pi * c.diameter_mm / c.beam_mm_s + 5e-3);
  const double border_mm = kFieldMm / 2 - c.diameter_mm / 2 - 0.8;
  Worst worst;
  for (int i = 0; i < 7; ++i) {
    for (int j = 0; j < 7; ++j) {
      const Vec2 at_mm(-border_mm + i * (2 * border_mm - moved_mm) / 6,
                       -border_mm + j * 2 * border_mm / 6);
      Burn(c, given, at_mm, worst);
    }
  }
  return worst;
}

TEST(MovingWeb, CirclesCloseAndLieInTheirPlacesWithTheirDiameter) {
  for (const Case& c : kCases) {
    const Worst worst = Over49Places(c, {});
    EXPECT_LE(worst.gap_um, 10) << c.diameter_mm;
    EXPECT_LE(worst.place_um, 15) << c.diameter_mm;
    EXPECT_LE(std::abs(worst.diameter_um), 5) << c.diameter_mm;
    RecordProperty("worst_" + std::to_string(&c - kCases),
                   std::to_string(worst.gap_um) + " " + std::to_string(worst.shape_um) +
                       " " + std::to_string(worst.place_um) + " " +
                       std::to_string(worst.diameter_um));
  }
}

/// No lag: what is left is the geometry alone.
Given Ideal(bool corrected, bool followed) {
  return {corrected, followed, false, 0, false, false, false};
}

TEST(MovingWeb, UnfollowedOpensCirclesByWhatTheWebMovesInTheirTime) {
  // Reference: 628, 628, 419 um; the first case moves 100 mm/s for 6.28 ms.
  constexpr double kGapsUm[] = {628, 628, 419};
  for (std::size_t i = 0; i < 3; ++i) {
    const Worst worst = Over49Places(kCases[i], Ideal(false, false));
    EXPECT_NEAR(worst.gap_um, kGapsUm[i], 0.04 * kGapsUm[i] + 15);
  }
}

TEST(MovingWeb, WithoutTheTableCirclesAreOffTheirPlacesAndALittleOpen) {
  // Reference: gaps of 40, 39 and 29 um, place 430, shape 42; 4 to 8, 7 and 4 with it.
  constexpr double kGapsUm[] = {40, 39, 29};
  for (std::size_t i = 0; i < 3; ++i) {
    const Worst without = Over49Places(kCases[i], Ideal(false, true));
    EXPECT_NEAR(without.gap_um, kGapsUm[i], 0.25 * kGapsUm[i] + 6);
    EXPECT_GT(without.place_um, 300);
    EXPECT_GT(without.shape_um, 20);
    const Worst with = Over49Places(kCases[i], Ideal(true, true));
    EXPECT_LT(with.gap_um, 20);  // a micro-vector is up to 15 um
    EXPECT_LT(with.place_um, 15);
    EXPECT_LT(with.shape_um, 8);
  }
}

TEST(MovingWeb, WithTheLaserOnAtOnceALaggingServoLeavesGaps) {
  // Reference: 102, 294 and 292 um without a run-in; 4 to 7 with one of 0.6 ms and the
  // laser later by the lag, with holes smaller by 11, 58 and 84 um.
  constexpr double kGapsUm[] = {102, 294, 292}, kDiametersUm[] = {-11, -58, -84};
  for (std::size_t i = 0; i < 3; ++i) {
    Given at_once;
    at_once.run_in = at_once.lead = false;
    EXPECT_NEAR(Over49Places(kCases[i], at_once).gap_um, kGapsUm[i], 0.1 * kGapsUm[i]);
    Given run_in;
    run_in.lead = false;
    run_in.laser_waits = true;
    const Worst worst = Over49Places(kCases[i], run_in);
    EXPECT_LT(worst.gap_um, 12);
    EXPECT_NEAR(worst.diameter_um, kDiametersUm[i], 0.1 * std::abs(kDiametersUm[i]) + 2);
  }
}

TEST(MovingWeb, ByTheRawEncoderCirclesAreOutOfShapeByHalfACount) {
  // Without a lag, for a servo of 0.2 ms smooths the counts that come every 0.23 ms.
  Given raw = Ideal(true, true);
  raw.raw_encoder = true;
  const Worst tracked = Over49Places(kCases[0], Ideal(true, true));
  const Worst counted = Over49Places(kCases[0], raw);
  // Reference: 13 um raw, 3 to 4 tracked.
  EXPECT_GT(counted.shape_um, 8);
  EXPECT_LT(tracked.shape_um, 6);
}

}  // namespace
}  // namespace intaglio::galvo
