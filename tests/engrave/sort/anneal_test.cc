#include "engrave/sort/anneal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "engrave/sort/beam/lowest_point.h"
#include "engrave/sort/planned_ticks.h"
#include "tests/engrave/sort/order_checks.h"
#include "tests/engrave/sort/shadow_oracle.h"

namespace intaglio::sort {
namespace {

using ::testing::HasSubstr;

std::uint64_t Ticks(const StageCase& made, const Order& order) {
  return PlannedTicks(made.points_mm, order, made.options.limits, made.options.rate_hz);
}

TEST(Anneal, MakesEveryPointOnceAndNoneThroughACrack) {
  for (StageCase& made : StageCases(200, Method::kAnneal)) {
    SCOPED_TRACE(made.name);
    const Order order = MakeOrder(made.points_mm, made.options).value();
    ExpectEachOnce(order, made.points_mm.size());
    ExpectNoneShaded(made.points_mm, order, made.options.cone);
    if (!order.empty()) {
      EXPECT_EQ(order.front(), LowestPoint(made.points_mm));
    }
    made.options.method = Method::kSmooth;
    EXPECT_LE(Ticks(made, order),
              Ticks(made, MakeOrder(made.points_mm, made.options).value()));
  }
}

TEST(Anneal, IsTheSameWhateverTheExecutorDoes) {
  // The larger one is more than a stretch.
  std::vector<StageCase> cases = StageCases(40, Method::kAnneal);
  cases.push_back({"large", DentedSphere(9000, 3), cases.front().options});
  for (auto& [name, points_mm, options] : cases) {
    options.anneal.tries_per_point = 3;
    options.rate_hz = std::min(options.rate_hz, 500.0);
    const Order order = MakeOrder(points_mm, options).value();
    for (const Executor& executor : Executors()) {
      options.executor = executor;
      EXPECT_EQ(MakeOrder(points_mm, options).value(), order) << name;
    }
    ExpectEachOnce(order, points_mm.size());
    EXPECT_EQ(CountShadowViolations(points_mm, order, options.cone), 0) << name;
  }
}

// Then a search follows, of stretches that are searched at the same time.
TEST(Anneal, ByWorthIsTheSameWhateverTheExecutorDoes) {
  const PointList points_mm = DentedSphere(9000, 3);
  OrderOptions options;
  options.method = Method::kAnneal;
  options.rate_hz = 200;
  const Order order = MakeOrder(points_mm, options).value();
  for (const Executor& executor : Executors()) {
    options.executor = executor;
    EXPECT_EQ(MakeOrder(points_mm, options).value(), order);
  }
  ExpectEachOnce(order, points_mm.size());
  EXPECT_EQ(CountShadowViolations(points_mm, order, options.cone), 0);
}

TEST(Anneal, MoreTriesAreBetter) {
  double before = 0;
  for (const double tries : {0.0, 12.0, 200.0}) {
    double ticks = 0;
    for (const auto& [name, points_mm] : Clouds(300)) {
      for (const std::uint64_t seed : {1, 2}) {
        StageCase made{name, points_mm, {}};
        made.options.method = Method::kAnneal;
        made.options.anneal.tries_per_point = tries;
        made.options.anneal.seed = seed;
        made.options.cone = 0.1328;
        ticks +=
            static_cast<double>(Ticks(made, MakeOrder(points_mm, made.options).value()));
      }
    }
    if (tries > 0) {
      EXPECT_LT(ticks, before) << tries;
    }
    before = ticks;
  }
}

TEST(Anneal, WithoutTriesIsSmooth) {
  for (StageCase& made : StageCases(100, Method::kAnneal)) {
    made.options.anneal.tries_per_point = 0;
    const Order order = MakeOrder(made.points_mm, made.options).value();
    made.options.method = Method::kSmooth;
    EXPECT_EQ(MakeOrder(made.points_mm, made.options).value(), order) << made.name;
  }
}

TEST(Anneal, FromRowsIsNeverWorseThanThem) {
  for (StageCase& made : StageCases(200, Method::kAnneal)) {
    SCOPED_TRACE(made.name);
    made.options.boustrophedon = {0.4, 0.3, 0.5};
    OrderOptions by_rows = made.options;
    by_rows.method = Method::kBoustrophedon;
    const Order rows = MakeOrder(made.points_mm, by_rows).value();
    made.options.anneal.start = AnnealStart::kRows;
    const Order order = MakeOrder(made.points_mm, made.options).value();
    ExpectEachOnce(order, made.points_mm.size());
    ExpectNoneShaded(made.points_mm, order, made.options.cone);
    EXPECT_LE(Ticks(made, order), Ticks(made, rows));
    made.options.anneal.tries_per_point = 0;
    EXPECT_EQ(MakeOrder(made.points_mm, made.options).value(), rows);
    made.options.boustrophedon.row_width_mm = 0;
    EXPECT_THAT(MakeOrder(made.points_mm, made.options).error().message,
                HasSubstr("row_width_mm"));
  }
}

TEST(Anneal, AnotherSeedIsAnotherOrder) {
  const PointList points_mm = DentedSphere(1000, 3);
  OrderOptions options;
  options.method = Method::kAnneal;
  const Order order = MakeOrder(points_mm, options).value();
  options.anneal.seed = 2;
  EXPECT_NE(MakeOrder(points_mm, options).value(), order);
}

TEST(Anneal, ImprovesAnyOrderThatKeepsToTheCone) {
  for (StageCase& made : StageCases(200, Method::kAnneal)) {
    SCOPED_TRACE(made.name);
    made.options.rate_hz = std::min(made.options.rate_hz, 500.0);
    Order by_height(made.points_mm.size());
    for (std::uint32_t i = 0; i < by_height.size(); ++i) by_height[i] = i;
    std::sort(by_height.begin(), by_height.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(made.points_mm[a].z(), a) < std::pair(made.points_mm[b].z(), b);
    });
    const Order order = ImproveOrder(made.points_mm, by_height, made.options, {});
    ExpectEachOnce(order, made.points_mm.size());
    ExpectNoneShaded(made.points_mm, order, made.options.cone);
    EXPECT_LE(Ticks(made, order), Ticks(made, by_height));
  }
}

TEST(Anneal, EndsWhenTheTimeIsUsed) {
  const PointList points_mm = RandomBox(300, {4, 4, 4}, 1);
  OrderOptions options;
  options.method = Method::kAnneal;
  options.anneal.tries_per_point = 0;
  int asked = 0;
  options.anneal.used_share = [&asked] { return 0.1 * asked++; };
  const Order order = MakeOrder(points_mm, options).value();
  ExpectEachOnce(order, points_mm.size());
  ExpectNoneShaded(points_mm, order, options.cone);
  EXPECT_EQ(asked, 11) << "asked once a round and never again";
  options.anneal.used_share = [] { return 1.0; };
  const Order none_left = MakeOrder(points_mm, options).value();
  options.method = Method::kSmooth;
  EXPECT_EQ(MakeOrder(points_mm, options).value(), none_left);
}

TEST(Anneal, EndsWhenAskedWhereverItIs) {
  const PointList points_mm = RandomBox(6000, {15, 15, 15}, 1);
  OrderOptions options;
  options.method = Method::kAnneal;
  options.anneal.tries_per_point = 2;
  int calls = 0;
  const auto listen = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_LE(done, total);
    EXPECT_EQ(total, points_mm.size());
    return --calls != 0;
  };
  ASSERT_TRUE(MakeOrder(points_mm, options, listen).has_value());
  const int all = -calls;
  ASSERT_GT(all, 4);
  for (const int last : {1, 2, 3, 4, all}) {
    calls = last;
    const auto order = MakeOrder(points_mm, options, listen);
    ASSERT_FALSE(order.has_value()) << last;
    EXPECT_EQ(order.error().code, ErrorCode::kCancelled);
    EXPECT_EQ(calls, 0) << "it went on";
  }
}

TEST(Anneal, NamesOptionsOutsideTheirRange) {
  const PointList points_mm = RandomBox(10, {1, 1, 1}, 1);
  OrderOptions options;
  options.method = Method::kAnneal;
  for (const double wrong : {-1.0, 1.1e6, std::nan("")}) {
    options.anneal.tries_per_point = wrong;
    const auto order = MakeOrder(points_mm, options);
    ASSERT_FALSE(order.has_value()) << wrong;
    EXPECT_EQ(order.error().code, ErrorCode::kInvalidValue);
    EXPECT_THAT(order.error().message, HasSubstr("anneal.tries_per_point"));
  }
  options.anneal.tries_per_point = 1;
  options.rate_hz = 60000;
  const auto order = MakeOrder(points_mm, options);
  ASSERT_FALSE(order.has_value());
  EXPECT_THAT(order.error().message, HasSubstr("rate_hz"));
}

}  // namespace
}  // namespace intaglio::sort
