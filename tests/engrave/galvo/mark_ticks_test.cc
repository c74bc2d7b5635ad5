// Ticks of strokes: their length, speed, closure and laser, measured tick by tick.

#include "engrave/galvo/mark_ticks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engrave/galvo/web_follower.h"
#include "tests/engrave/galvo/virtual_head.h"

namespace intaglio::galvo {
namespace {

constexpr double kLsbMm = 20.0 / 65536;

MarkStroke Square() { return {{{0, 0}, {5, 0}, {5, 5}, {0, 5}}, true}; }
MarkStroke Circle(double radius_mm) {
  MarkStroke circle{{}, true};
  for (int k = 0; k < 720; ++k) {
    const double a = std::numbers::pi * k / 360;
    circle.points_mm.push_back(radius_mm * Vec2(std::cos(a), std::sin(a)));
  }
  return circle;
}

MarkTickOptions Plain() {
  MarkTickOptions options;
  options.mark_mm_s = 1000;
  options.jump_mm_s = 5000;
  return options;
}

TEST(MarkTicks, MoveByEqualMicroVectorsAtTheSpeedOfTheMark) {
  auto options = Plain();
  options.run_in_s = 6e-4;
  const auto ticks = MakeMarkTicks(std::vector{Circle(1)}, {1, 0}, options).value();
  double lit_mm = 0, longest_mm = 0, shortest_mm = 1;
  for (std::size_t k = 0; k + 1 < ticks.size(); ++k) {
    if (!ticks[k].laser) continue;
    const double step_mm = (ticks[k + 1].place_mm - ticks[k].place_mm).norm();
    lit_mm += step_mm;
    longest_mm = std::max(longest_mm, step_mm);
    shortest_mm = std::min(shortest_mm, step_mm);
  }
  EXPECT_NEAR(lit_mm, 2 * std::numbers::pi, 1e-4);
  EXPECT_LE(longest_mm, 0.01 + 1e-12);
  EXPECT_GT(shortest_mm, 0.01 - kLsbMm);
}

TEST(MarkTicks, OfAClosedStrokeEndWhereTheyBegan) {
  auto options = Plain();
  options.run_in_s = 6e-4;
  const auto ticks = MakeMarkTicks(std::vector{Circle(1)}, {-3, 2}, options).value();
  std::size_t first = ticks.size(), last = 0;
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    if (!ticks[k].laser) continue;
    first = std::min(first, k);
    last = k + 1;  // until here
  }
  EXPECT_LT((ticks[first].place_mm - Vec2(1, 0)).norm(), 1e-9);
  EXPECT_LT((ticks[last].place_mm - Vec2(1, 0)).norm(), 1e-9);
  // 0.6 ms on the circle before and behind it.
  for (std::size_t k = 1; k <= 60; ++k) {
    EXPECT_NEAR(ticks[first - k].place_mm.norm(), 1, 1e-4);
    EXPECT_NEAR(ticks[last + k].place_mm.norm(), 1, 1e-4);
    EXPECT_FALSE(ticks[first - k].laser);
    EXPECT_FALSE(ticks[last + k].laser);
  }
}

TEST(MarkTicks, RestAtCornersByThePolygonDelayAndSwitchTheLaserByItsDelays) {
  auto options = Plain();
  options.polygon_delay_s = 2e-4;
  options.jump_delay_s = 3e-4;
  options.mark_delay_s = 1e-4;
  options.laser_on_delay_s = 5e-5;
  options.laser_off_delay_s = 8e-5;
  const auto ticks = MakeMarkTicks(std::vector{Square()}, {-10, 0}, options).value();
  int at_corner = 0, lit = 0, at_begin_dark = 0;
  for (const MarkTick& tick : ticks) {
    lit += tick.laser;
    at_corner += tick.place_mm == Vec2(5, 0);
    at_begin_dark += tick.place_mm == Vec2(0, 0) && !tick.laser;
  }
  // A right angle: 1 - cos is 1. The arriving tick and 20 more.
  EXPECT_EQ(at_corner, 21);
  // 20 mm in 2000 ticks, three corners of 20, off 3 ticks later than on.
  EXPECT_EQ(lit, 2000 + 60 + 3);
  // Arriving, 30 of the jump delay, the first of the stroke until the laser is on; behind
  // the stroke 10 of the mark delay, of which 7 are lit, and one of the end.
  EXPECT_EQ(at_begin_dark, 1 + 30 + 1 + 3 + 1);
  // 10 mm of jump at 5 m/s.
  EXPECT_LT((ticks[199].place_mm - Vec2(0, 0)).norm(), 1e-12);
  EXPECT_GT((ticks[198].place_mm - Vec2(0, 0)).norm(), 0.04);
}

/// Largest distance in um of what the servo makes of lit ticks from an outline.
template <typename Distance>
double ServoErrorUm(const std::vector<MarkTick>& ticks, double lag_s,
                    const Distance& distance_mm) {
  TwoPoleServo x(lag_s, ticks[0].place_mm.x()), y(lag_s, ticks[0].place_mm.y());
  double worst_mm = 0;
  for (const MarkTick& tick : ticks) {
    if (tick.laser)
      worst_mm = std::max(worst_mm, distance_mm(Vec2(x.place(), y.place())));
    x.Advance(tick.place_mm.x(), 1e-5);
    y.Advance(tick.place_mm.y(), 1e-5);
  }
  return 1000 * worst_mm;
}

TEST(MarkTicks, ThatLeadTheServoKeepItOnCirclesAndCorners) {
  auto options = Plain();
  options.run_in_s = 1e-3;
  options.lag_s = 2e-4;
  const auto from_circle = [](const Vec2& p) { return std::abs(p.norm() - 0.5); };
  const auto from_square = [](const Vec2& p) {
    const double u = std::abs(p.x() - 2.5) - 2.5, v = std::abs(p.y() - 2.5) - 2.5;
    return std::abs(u <= 0 && v <= 0 ? std::max(u, v)
                                     : std::hypot(std::max(u, 0.), std::max(v, 0.)));
  };
  const auto lagging = MakeMarkTicks(std::vector{Circle(.5)}, {-3, 2}, options).value();
  options.lead_servo = true;
  const auto circle = MakeMarkTicks(std::vector{Circle(.5)}, {-3, 2}, options).value();
  const auto square = MakeMarkTicks(std::vector{Square()}, {-3, 2}, options).value();
  EXPECT_GT(ServoErrorUm(lagging, 2e-4, from_circle), 15);
  EXPECT_LT(ServoErrorUm(circle, 2e-4, from_circle), 1.5);
  EXPECT_LT(ServoErrorUm(square, 2e-4, from_square), 1.5);
  int lit = 0;
  for (const MarkTick& tick : square) lit += tick.laser;
  EXPECT_EQ(lit, 2000);
}

TEST(MarkTicks, RefuseOptionsAndStrokesByName) {
  auto options = Plain();
  options.mark_mm_s = 0;
  EXPECT_EQ(MakeMarkTicks(std::vector{Square()}, {0, 0}, options).error().message,
            "ticks: mark_mm_s is 0; give 0.001..1000000");
  options = Plain();
  options.lead_servo = true;
  EXPECT_EQ(MakeMarkTicks(std::vector{Square()}, {0, 0}, options).error().message,
            "ticks: lead_servo needs lag_s above 0");
  EXPECT_EQ(
      MakeMarkTicks(std::vector<MarkStroke>{{{{1, 1}, {1, 1}}, true}}, {0, 0}, Plain())
          .error()
          .message,
      "stroke 1 has fewer than two places; leave it out");
}

TEST(WebFollower, DelaysTheEdgeByTheWayFromTheSensor) {
  // A wave of 0.5 mm, 40 mm long, measured 10 mm upstream, at 200 mm/s.
  WebFollowerOptions options;
  options.edge_sensor_upstream_mm = 10;
  WebFollower follower(options, 0, 200);
  WebFollowerOptions none = options;
  none.edge_sensor_upstream_mm = 0;
  WebFollower undelayed(none, 0, 200);
  double worst_um = 0, undelayed_um = 0;
  for (int k = 0; k < 100'000; ++k) {
    const double web_mm = 200 * 1e-5 * k;
    const auto edge_at = [&](double upstream_mm) {
      return 0.5 * std::sin(2 * std::numbers::pi * (web_mm + upstream_mm) / 40);
    };
    const auto count = static_cast<std::int64_t>(std::floor(web_mm / .023));
    // The wave reaches the sensor first: there it is what the field has 10 mm later.
    const double measured_mm = edge_at(10);
    const double by_mm = follower.Update(count, measured_mm).y();
    const double early_mm = undelayed.Update(count, measured_mm).y();
    if (web_mm < 20) continue;
    worst_um = std::max(worst_um, 1000 * std::abs(by_mm - edge_at(0)));
    undelayed_um = std::max(undelayed_um, 1000 * std::abs(early_mm - edge_at(0)));
  }
  // Two counts of 23 um on a slope of 0.08.
  EXPECT_LT(worst_um, 4);
  // 2 A sin(pi s / l).
  EXPECT_NEAR(undelayed_um, 1000 * std::sin(std::numbers::pi / 4), 10);
}

TEST(WebFollower, TracksACoarseEncoderAndSeesAhead) {
  WebFollowerOptions options;
  options.preview_s = 2e-4;
  WebFollower follower(options, 0, 90);  // 10 % wrong
  double worst_um = 0;
  for (int k = 0; k < 50'000; ++k) {
    const double web_mm = 100 * 1e-5 * k;
    const Vec2 by_mm =
        follower.Update(static_cast<std::int64_t>(std::floor(web_mm / .023)), 0);
    // The first count began at 0: half a count.
    if (k > 10'000)
      worst_um = std::max(worst_um,
                          1000 * std::abs(by_mm.x() + 0.0115 - web_mm - 100 * 2.05e-4));
  }
  EXPECT_LT(worst_um, 5);  // of a quantum of 23
  EXPECT_NEAR(follower.speed_mm_s(), 100, 2);
  options.alpha = 0;
  EXPECT_EQ(CheckFollower(options).error().message,
            "follower: alpha is 0; give more than 0 and up to 1");
}

TEST(MarkTicks, AreAsManyAsTheyAreCounted) {
  const std::vector strokes = {Square(), Circle(0.3),
                               MarkStroke{{{0, 0}, {0.001, 0}}, false},
                               MarkStroke{{{9, 9}, {-9, 9}, {-9, -9}}, false}, Square()};
  MarkTickOptions delays = Plain();
  delays.laser_on_delay_s = 1e-4, delays.laser_off_delay_s = 3e-4;
  delays.jump_delay_s = 5e-4, delays.mark_delay_s = 2e-4, delays.polygon_delay_s = 1e-4;
  MarkTickOptions run_in = Plain(), lead = Plain();
  run_in.run_in_s = lead.run_in_s = 6e-4;
  lead.lag_s = 2e-4;
  lead.lead_servo = true;
  for (const MarkTickOptions& options : {Plain(), delays, run_in, lead}) {
    for (const std::size_t count : {1, 3, 5}) {
      const std::vector part(strokes.begin(),
                             strokes.begin() + static_cast<std::ptrdiff_t>(count));
      const auto ticks = MakeMarkTicks(part, {2, -7}, options).value();
      const auto counted = CountStrokeTicks(part, options).value();
      const double jump_mm = (counted.first_mm - Vec2(2, -7)).norm();
      EXPECT_EQ(CountJumpTicks(jump_mm, options) + counted.count, ticks.size());
      EXPECT_LT((counted.end_mm - ticks.back().place_mm).norm(), 1e-9);
    }
  }
  EXPECT_FALSE(CountStrokeTicks(strokes, MarkTickOptions()));
  EXPECT_FALSE(CountStrokeTicks({}, Plain()));
}

}  // namespace
}  // namespace intaglio::galvo
