#include "engrave/sort/smooth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "engrave/core/check.h"
#include "engrave/sort/beam/lowest_point.h"
#include "engrave/sort/planned_ticks.h"
#include "tests/engrave/motion/paths.h"
#include "tests/engrave/sort/order_checks.h"
#include "tests/engrave/sort/shadow_oracle.h"

namespace intaglio::sort {
namespace {

using ::testing::HasSubstr;

TEST(Smooth, MakesEveryPointOnceAndNoneThroughACrack) {
  for (const auto& [name, points_mm, options] : StageCases(250, Method::kSmooth)) {
    SCOPED_TRACE(name);
    const Order order = MakeOrder(points_mm, options).value();
    ExpectEachOnce(order, points_mm.size());
    ExpectNoneShaded(points_mm, order, options.cone);
    if (!order.empty()) {
      EXPECT_EQ(order.front(), LowestPoint(points_mm));
    }
  }
}

TEST(Smooth, IsTheSameWhateverTheExecutorDoes) {
  for (auto& [name, points_mm, options] : StageCases(60, Method::kSmooth)) {
    const Order order = MakeOrder(points_mm, options).value();
    for (const Executor& executor : Executors()) {
      options.executor = executor;
      EXPECT_EQ(MakeOrder(points_mm, options).value(), order) << name;
    }
  }
}

// A sphere by its contours: nothing but the way from one contour to the next costs more
// than a tick a point.
TEST(Smooth, FollowsTheContoursOfASphere) {
  const PointList points_mm = SphereContours(4, 0.1, 0.1);
  OrderOptions options;
  options.method = Method::kSmooth;
  options.rate_hz = 200;
  options.cone = 0.1328;
  const Order order = MakeOrder(points_mm, options).value();
  ExpectEachOnce(order, points_mm.size());
  EXPECT_EQ(CountShadowViolations(points_mm, order, options.cone), 0);
  const auto ticks = PlannedTicks(points_mm, order, options.limits, options.rate_hz);
  const double utilisation =
      static_cast<double>(points_mm.size() - 1) / static_cast<double>(ticks);
  RecordProperty("utilisation", std::to_string(utilisation));
  EXPECT_GE(utilisation, 0.98);
}

// Its purpose: fewer ticks than the nearest-neighbour order.
TEST(Smooth, TakesFewerTicksThanKdz) {
  for (const double rate_hz : {100.0, 400.0}) {
    double smooth_ticks = 0;
    double kdz_ticks = 0;
    for (const auto& [name, points_mm] : Clouds(600)) {
      OrderOptions options;
      options.rate_hz = rate_hz;
      kdz_ticks += static_cast<double>(PlannedTicks(
          points_mm, MakeOrder(points_mm, options).value(), options.limits, rate_hz));
      options.method = Method::kSmooth;
      smooth_ticks += static_cast<double>(PlannedTicks(
          points_mm, MakeOrder(points_mm, options).value(), options.limits, rate_hz));
    }
    EXPECT_LT(smooth_ticks, kdz_ticks) << rate_hz;
  }
}

TEST(Smooth, EndsWhenAskedWhereverItIs) {
  const PointList points_mm = RandomBox(20000, {20, 20, 20}, 1);
  OrderOptions options;
  options.method = Method::kSmooth;
  int calls = 0;
  std::uint64_t last_done = 0;
  const auto listen = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_GE(done, last_done);
    EXPECT_LE(done, total);
    EXPECT_EQ(total, points_mm.size());
    last_done = done;
    return --calls != 0;
  };
  ASSERT_TRUE(MakeOrder(points_mm, options, listen).has_value());
  const int all = -calls;
  EXPECT_GT(all, 3) << "every trial asks";
  EXPECT_GT(last_done, points_mm.size() / 2);
  for (int last = 1; last <= all; ++last) {
    calls = last;
    last_done = 0;
    const auto order = MakeOrder(points_mm, options, listen);
    ASSERT_FALSE(order.has_value()) << last;
    EXPECT_EQ(order.error().code, ErrorCode::kCancelled);
    EXPECT_EQ(calls, 0) << "it went on";
  }
}

// Whatever trial is asked to end ends all of them, on however many threads.
TEST(Smooth, EndsOnManyThreads) {
  const PointList points_mm = RandomBox(5000, {20, 20, 20}, 1);
  OrderOptions options;
  options.method = Method::kSmooth;
  for (const Executor& executor : Executors()) {
    options.executor = executor;
    const auto order =
        MakeOrder(points_mm, options, [](std::uint64_t, std::uint64_t) { return false; });
    ASSERT_FALSE(order.has_value());
    EXPECT_EQ(order.error().code, ErrorCode::kCancelled);
  }
}

TEST(Smooth, NamesARateOutsideItsRange) {
  OrderOptions options;
  options.method = Method::kSmooth;
  for (const double wrong : {0.0, 0.9, 50000.5, -100.0, std::nan("")}) {
    options.rate_hz = wrong;
    const auto order = MakeOrder(RandomBox(10, {1, 1, 1}, 1), options);
    ASSERT_FALSE(order.has_value()) << wrong;
    EXPECT_EQ(order.error().code, ErrorCode::kInvalidValue);
    EXPECT_THAT(order.error().message, HasSubstr("rate_hz"));
    EXPECT_THAT(order.error().message, HasSubstr("1..50000"));
  }
}

TEST(Smooth, WrongConesAndLimitsThrow) {
  const PointList points_mm = RandomBox(10, {1, 1, 1}, 1);
  OrderOptions options;
  options.method = Method::kSmooth;
  options.cone.tangent = -0.1;
  EXPECT_THROW((void)MakeOrder(points_mm, options), PreconditionError);
  options = {};
  options.method = Method::kSmooth;
  options.limits.max_acceleration_mm_s2.z() = 0;
  EXPECT_THROW((void)MakeOrder(points_mm, options), PreconditionError);
}

TEST(PlannedTicks, OfOneOrderIsWhatItsStepsTakeAtLeast) {
  motion::Limits limits;
  EXPECT_EQ(PlannedTicks({}, {}, limits, 100), 0);
  EXPECT_EQ(PlannedTicks({Vec3(1, 2, 3)}, {0}, limits, 100), 0);
  // From rest to rest: 2 sqrt(s / a), a tick at 0.175 mm.
  EXPECT_EQ(PlannedTicks({Vec3(0, 0, 0), Vec3(0.174, 0, 0)}, {0, 1}, limits, 100), 1);
  EXPECT_EQ(PlannedTicks({Vec3(0, 0, 0), Vec3(0.18, 0, 0)}, {0, 1}, limits, 100), 2);
  // 10 mm in steps of 0.5 mm at 80 mm/s: one tick each, but for the first and the last.
  const PointList row = Row(21, {0.5, 0, 0});
  Order order(row.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  EXPECT_EQ(PlannedTicks(row, order, limits, 100), 22);
}

}  // namespace
}  // namespace intaglio::sort
