#include "engrave/sort/sweep.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engrave/motion/planner.h"
#include "engrave/sort/planned_ticks.h"
#include "engrave/sort/sweep_begin.h"
#include "tests/engrave/sort/order_checks.h"

namespace intaglio::sort::sweep_test {
namespace {

using ::testing::HasSubstr;

OrderOptions SweepIn(double slab_mm) {
  OrderOptions options;
  options.method = Method::kSweep;
  options.sweep.slab_mm = slab_mm;
  options.limits.max_speed_mm_s = {8000, 8000, 50};
  options.limits.max_acceleration_mm_s2 = {5e7, 5e7, 1000};
  options.rate_hz = 4000;
  options.cone = {0.02, 0.035, 0.15};
  return options;
}

TEST(Sweep, MakesSlabAfterSlabAndFiresThroughNothing) {
  // Near enough in the slab of the last that cracks reach into the cones of others.
  for (const auto& [points_mm, slab_mm] :
       {std::pair(RandomBox(3000, {50, 50, 50}, 1), 0.5),
        std::pair(RandomBox(1500, {1, 1, 1}, 2), 0.2),
        std::pair(SlicedVase(12, 0.1, 0.1), 0.35),
        std::pair(PointList{{1, 2, 3}}, 1.0)}) {
    const OrderOptions options = SweepIn(slab_mm);
    const Order order = MakeOrder(points_mm, options).value();
    ExpectEachOnce(order, points_mm.size());
    ExpectNoneShaded(points_mm, order, options.cone);
    const PointList made_mm = InOrder(points_mm, order);
    double lowest_mm = made_mm.front().z();
    for (const Vec3& point : points_mm) lowest_mm = std::min(lowest_mm, point.z());
    double slab = 0;
    for (const Vec3& point : made_mm) {
      const double own = std::floor((point.z() - lowest_mm) / slab_mm + 1e-6);
      ASSERT_GE(own, slab);
      slab = own;
    }
  }
}

/// Whether an axis that never falls can be within the tolerance of each point: no earlier
/// point is more than twice the tolerance higher.
void ExpectCourse(const PointList& made_mm, double tolerance_mm) {
  double highest_mm = made_mm.front().z();
  for (const Vec3& point : made_mm) {
    ASSERT_GE(point.z() + tolerance_mm, highest_mm - tolerance_mm - 1e-9);
    highest_mm = std::max(highest_mm, point.z());
  }
}

std::uint64_t SweptTicks(const PointList& made_mm, const OrderOptions& options,
                         double tolerance_mm) {
  motion::PlanOptions plan;
  plan.limits = options.limits;
  plan.rate_hz = options.rate_hz;
  plan.continuous = true;
  plan.sweep_mm = tolerance_mm;
  const auto planner = motion::MakePlanner(plan, made_mm.front());
  std::vector<motion::Segment> segments;
  for (const Vec3& point : made_mm) planner->Append(point, -1, false, segments);
  planner->Finish(segments);
  return planner->ticks();
}

// A slab of 50 um has 100 of these points. Even without limits of acceleration no order
// of such slabs has more than 0.776 and 0.466 points a tick at 8 m/s (Held and Karp's
// bound of the travelling salesman, ticks of the longer axis as lengths). Rounds of the
// same tolerance have more.
TEST(Sweep, RoundsOfAScatterNeedFewerTicksThanAnyOrderOfSlabs) {
  const PointList points_mm = RandomBox(4000, {50, 50, 2}, 3);
  for (const auto& [rate_hz, ratio] :
       {std::pair(2000, 0.776 * 1.12), std::pair(4000, 0.466 * 1.15)}) {
    OrderOptions options = SweepIn(0.05);
    options.sweep.tolerance_mm = 0.05;
    options.rate_hz = rate_hz;
    const Order order = MakeOrder(points_mm, options).value();
    ExpectEachOnce(order, points_mm.size());
    ExpectNoneShaded(points_mm, order, options.cone);
    const PointList made_mm = InOrder(points_mm, order);
    ExpectCourse(made_mm, options.sweep.tolerance_mm);
    const std::uint64_t ticks = SweptTicks(made_mm, options, options.sweep.tolerance_mm);
    EXPECT_GT(static_cast<double>(made_mm.size()) / static_cast<double>(ticks), ratio)
        << rate_hz;
  }
}

// Nine tenths of the points stand in a corner, so in rounds a slow axis would have to go
// up fast beside it and wait in it. Whatever the mirrors alone would need, the order
// takes no more ticks than slabs do.
TEST(Sweep, ChoosesByTheTicksOfTheSlowAxisToo) {
  PointList points_mm = RandomBox(9000, {3, 3, 2}, 11);
  for (const Vec3& point : RandomBox(1000, {50, 50, 2}, 12)) points_mm.push_back(point);
  constexpr double kToleranceMm = 0.05;
  OrderOptions options = SweepIn(0.85 * kToleranceMm);
  options.limits.max_acceleration_mm_s2.z() = 50;
  const PointList slabs_mm = InOrder(points_mm, MakeOrder(points_mm, options).value());
  options.sweep.tolerance_mm = kToleranceMm;
  const PointList chosen_mm = InOrder(points_mm, MakeOrder(points_mm, options).value());
  EXPECT_LT(static_cast<double>(SweptTicks(chosen_mm, options, kToleranceMm)),
            1.02 * static_cast<double>(SweptTicks(slabs_mm, options, kToleranceMm)));
}

TEST(Sweep, KeepsToItsToleranceOfHeight) {
  for (const double tolerance_mm : {0.02, 0.1, 0.4}) {
    OrderOptions options = SweepIn(tolerance_mm);
    options.sweep.tolerance_mm = tolerance_mm;
    options.cone = {};
    for (const PointList& points_mm : {RandomBox(3000, {50, 50, 4}, 8),
                                       SlicedVase(40, 0.1, 0.1), DentedSphere(3000, 2)}) {
      const Order order = MakeOrder(points_mm, options).value();
      ExpectEachOnce(order, points_mm.size());
      ExpectCourse(InOrder(points_mm, order), tolerance_mm);
    }
  }
}

TEST(Sweep, RoundsAreNeverFartherThanHalfOfThePitchFromTheAxis) {
  for (const double pitch_mm : {0.05, 0.7}) {
    const PointList points_mm = RandomBox(2000, {30, 10, 5}, 9);
    const SweptOrder begun = BeginInRounds(points_mm, pitch_mm);
    ExpectEachOnce(begun.order, points_mm.size());
    EXPECT_EQ(begun.ends.back(), points_mm.size());
    EXPECT_TRUE(std::ranges::is_sorted(begun.axis_mm));
    for (std::size_t i = 0; i < begun.order.size(); ++i) {
      const double height_mm = points_mm[begun.order[i]].z();
      ASSERT_LE(std::abs(height_mm - begun.axis_mm[i]), pitch_mm / 2 + 1e-9);
    }
  }
}

// Neighbours on the closed curve are neighbours in the field, at its ends, too.
TEST(Sweep, ARoundGoesToTheNextPlaceOfTheFieldAndEndsWhereItBegan) {
  constexpr int kSide = 32;
  const PointList points_mm = Grid(kSide, kSide, 1, 1, 1, 4);
  const SweptOrder begun = BeginInRounds(points_mm, 10);
  const PointList made_mm = InOrder(points_mm, begun.order);
  for (std::size_t i = 0; i < made_mm.size(); ++i) {
    const Vec3& next = made_mm[(i + 1) % made_mm.size()];
    ASSERT_NEAR((next - made_mm[i]).norm(), 1, 1e-9) << i;
  }
}

TEST(Sweep, DoesNotDependOnTheWorkers) {
  const PointList points_mm = RandomBox(4000, {20, 20, 2}, 5);
  OrderOptions options = SweepIn(0.1);
  options.sweep.tolerance_mm = 0.1;
  const Order alone = MakeOrder(points_mm, options).value();
  for (const Executor& executor : Executors()) {
    options.executor = executor;
    EXPECT_EQ(MakeOrder(points_mm, options).value(), alone);
  }
}

// Measured by the planner, of the two mirrors alone.
TEST(Sweep, ChangesSaveTicksOfTheMirrors) {
  const PointList points_mm = RandomBox(4000, {30, 30, 1}, 6);
  PointList flat_mm = points_mm;
  for (Vec3& point : flat_mm) point.z() = 0;
  OrderOptions options = SweepIn(0.1);
  const auto ticks = [&] {
    return PlannedTicks(flat_mm, MakeOrder(points_mm, options).value(), options.limits,
                        options.rate_hz);
  };
  options.sweep.tries_per_point = 0;
  const std::uint64_t nearest = ticks();
  options.sweep.tries_per_point = 30;
  EXPECT_LT(static_cast<double>(ticks()), 0.95 * static_cast<double>(nearest));
}

TEST(Sweep, RefusesWhatIsOutsideItsRangesAndStopsWhenAsked) {
  const PointList points_mm = RandomBox(100, {1, 1, 1}, 7);
  for (const double slab_mm : {0.0, 0.009, 101.0}) {
    const auto order = MakeOrder(points_mm, SweepIn(slab_mm));
    ASSERT_FALSE(order);
    EXPECT_THAT(order.error().message, HasSubstr("sweep.slab_mm"));
  }
  OrderOptions options = SweepIn(0.1);
  options.sweep.tries_per_point = -1;
  EXPECT_THAT(MakeOrder(points_mm, options).error().message,
              HasSubstr("sweep.tries_per_point"));
  options = SweepIn(0.1);
  options.sweep.tolerance_mm = -0.1;
  EXPECT_THAT(MakeOrder(points_mm, options).error().message,
              HasSubstr("sweep.tolerance_mm"));
  options = SweepIn(0.1);
  options.rate_hz = 60000;
  EXPECT_THAT(MakeOrder(points_mm, options).error().message, HasSubstr("rate_hz"));
  const auto stopped = MakeOrder(points_mm, SweepIn(0.1),
                                 [](std::uint64_t, std::uint64_t) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace intaglio::sort::sweep_test
