#include "engrave/sort/stretch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>

#include "engrave/core/check.h"
#include "engrave/sort/planned_ticks.h"
#include "engrave/sort/stretch_search.h"
#include "tests/engrave/sort/order_checks.h"

namespace intaglio::sort {
namespace {

/// In the order of sort Kdz, which keeps to the cone.
PointList Ordered(const PointList& points_mm, const BeamCone& cone) {
  OrderOptions options;
  options.kdz.up_ratio = std::max(0.6, cone.SteepestTangent());
  const Order order = MakeOrder(points_mm, options).value();
  PointList ordered_mm;
  for (const std::uint32_t i : order) ordered_mm.push_back(points_mm[i]);
  return ordered_mm;
}

Order OrderOf(const Stretch& stretch) {
  return Order(stretch.order().begin(), stretch.order().end());
}

/// Behind each of three changes of the order of each case, one after the other.
void ExpectEndsAndConeAreKept(
    const std::function<void(Stretch&, std::size_t i)>& change) {
  for (const auto& [name, points_mm, options] : StageCases(150, Method::kAnneal)) {
    SCOPED_TRACE(name);
    const PointList ordered_mm = Ordered(points_mm, options.cone);
    const TickCost cost(options.limits, options.rate_hz);
    Stretch stretch(ordered_mm, options.cone, cost);
    for (const std::size_t i : {0, 1, 2}) {
      change(stretch, i);
      const Order order = OrderOf(stretch);
      ExpectEachOnce(order, ordered_mm.size());
      ExpectNoneShaded(ordered_mm, order, options.cone);
      for (std::size_t k = 0; k < std::min<std::size_t>(2, order.size()); ++k) {
        ASSERT_EQ(order[k], k);
        ASSERT_EQ(order[order.size() - 1 - k], order.size() - 1 - k);
      }
    }
  }
}

TEST(Stretch, KeepsItsEndsAndTheCone) {
  constexpr double kTemperatures[] = {100, 0.15, 1e-6};
  ExpectEndsAndConeAreKept([&](Stretch& stretch, std::size_t i) {
    stretch.Anneal(20 * stretch.order().size(), kTemperatures[i], kTemperatures[i], 1);
  });
}

TEST(Stretch, BringsNoPointToAPlaceWhereTheAxisIsTooFarFromItsHeight) {
  PointList points_mm = RandomBox(1000, {20, 20, 1}, 3);
  std::ranges::sort(points_mm, {}, [](const Vec3& p) { return p.z(); });
  std::vector<double> heights_mm;
  for (const Vec3& p : points_mm) heights_mm.push_back(p.z());
  motion::Limits limits;
  limits.max_acceleration_mm_s2.z() = limits.max_speed_mm_s.z() = 1e9;
  const TickCost cost(limits, 500);
  constexpr double kToleranceMm = 0.1;
  Stretch stretch(points_mm, {}, cost, {heights_mm, heights_mm, kToleranceMm});
  PointList flat_mm = points_mm;
  for (Vec3& point : flat_mm) point.z() = 0;
  const auto ticks = [&] {
    return static_cast<double>(PlannedTicks(flat_mm, OrderOf(stretch), limits, 500));
  };
  const double before = ticks();
  stretch.Anneal(60 * points_mm.size(), 0.3, 0.03, 1);
  EXPECT_LT(ticks(), 0.8 * before);
  const Order order = OrderOf(stretch);
  ExpectEachOnce(order, points_mm.size());
  double farthest_mm = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    farthest_mm = std::max(farthest_mm, std::abs(heights_mm[order[i]] - heights_mm[i]));
  }
  EXPECT_LE(farthest_mm, kToleranceMm);
  EXPECT_GT(farthest_mm, kToleranceMm / 2) << "the tolerance was used";
}

/// Whether `improve` never costs ticks, and saves some where there are many.
void ExpectCheaper(const std::function<void(Stretch&)>& improve) {
  for (const double rate_hz : {100.0, 1000.0}) {
    for (const auto& [name, points_mm] : Clouds(300)) {
      const BeamCone cone = 0.1328;
      const PointList ordered_mm = Ordered(points_mm, cone);
      const TickCost cost({}, rate_hz);
      Stretch stretch(ordered_mm, cone, cost);
      const auto ticks = [&] {
        return PlannedTicks(ordered_mm, OrderOf(stretch), {}, rate_hz);
      };
      const auto before = ticks();
      improve(stretch);
      EXPECT_LE(ticks(), before) << name << ", " << rate_hz;
      if (before > 2 * ordered_mm.size()) {
        EXPECT_LT(ticks(), before) << name << ", " << rate_hz;
      }
    }
  }
}

TEST(Stretch, GetsCheaperWhereNothingWorseIsAccepted) {
  ExpectCheaper([](Stretch& stretch) {
    stretch.Anneal(100 * stretch.order().size(), 1e-6, 1e-6, 1);
  });
}

TEST(StretchSearch, MakesAStretchCheaper) {
  ExpectCheaper([](Stretch& stretch) {
    StretchSearch(stretch).Run(100 * stretch.order().size(), 1);
  });
}

TEST(StretchSearch, KeepsItsEndsAndTheCone) {
  constexpr std::uint64_t kTries[] = {1, 10, 100};
  ExpectEndsAndConeAreKept([&](Stretch& stretch, std::size_t i) {
    StretchSearch(stretch).Run(kTries[i] * stretch.order().size(), kTries[i]);
  });
}

// From a good order, annealing at the temperatures of its last stages needs more tries.
TEST(StretchSearch, GainsMoreThanAnnealingOfAsManyTries) {
  const BeamCone cone = 0.1328;
  motion::Limits limits;
  limits.max_speed_mm_s = Vec3::Constant(80);
  limits.max_acceleration_mm_s2 = Vec3::Constant(10000);
  constexpr double kRateHz = 200;
  const TickCost cost(limits, kRateHz);
  const PointList ordered_mm = Ordered(RandomBox(3000, {25, 25, 25}, 5), cone);
  Stretch annealed(ordered_mm, cone, cost), searched(ordered_mm, cone, cost);
  const std::uint64_t tries = 10 * ordered_mm.size();
  for (Stretch* stretch : {&annealed, &searched}) stretch->Anneal(tries, 0.12, 0.03, 1);
  annealed.Anneal(10 * tries, 0.12, 0.03, 2);
  StretchSearch(searched).Run(10 * tries, 2);
  const auto ticks = [&](const Stretch& stretch) {
    return PlannedTicks(ordered_mm, OrderOf(stretch), limits, kRateHz);
  };
  EXPECT_LT(ticks(searched), ticks(annealed));
}

TEST(StretchSearch, IsTheSameForTheSameSeedAlone) {
  const BeamCone cone = 0.1328;
  const PointList ordered_mm = Ordered(RandomBox(500, {15, 15, 15}, 7), cone);
  const TickCost cost({}, 200);
  const auto searched = [&](std::uint64_t seed) {
    Stretch stretch(ordered_mm, cone, cost);
    StretchSearch(stretch).Run(200 * ordered_mm.size(), seed);
    return OrderOf(stretch);
  };
  EXPECT_EQ(searched(1), searched(1));
  EXPECT_NE(searched(1), searched(2));
}

TEST(Stretch, IsTheSameForTheSameSeedAlone) {
  const BeamCone cone = 0.2;
  const PointList ordered_mm = Ordered(RandomBox(500, {5, 5, 5}, 1), cone);
  const TickCost cost({}, 100);
  const auto anneal = [&](std::uint64_t seed) {
    Stretch stretch(ordered_mm, cone, cost);
    stretch.Anneal(20000, 0.15, 0.03, seed);
    return OrderOf(stretch);
  };
  EXPECT_EQ(anneal(5), anneal(5));
  EXPECT_NE(anneal(5), anneal(6));
}

TEST(Stretch, WithoutTriesStaysAsItIs) {
  const PointList points_mm = Row(30, {0.1, 0, 0});
  const TickCost cost({}, 100);
  Stretch stretch(points_mm, 0.1, cost);
  stretch.Anneal(0, 1, 1, 1);
  Order expected(points_mm.size());
  std::iota(expected.begin(), expected.end(), 0U);
  EXPECT_EQ(OrderOf(stretch), expected);
}

TEST(Stretch, NoTemperatureThrows) {
  const PointList points_mm = Row(30, {0.1, 0, 0});
  const TickCost cost({}, 100);
  Stretch stretch(points_mm, 0.1, cost);
  EXPECT_THROW(stretch.Anneal(1, 0, 1, 1), PreconditionError);
  EXPECT_THROW(stretch.Anneal(1, 1, 0, 1), PreconditionError);
}

}  // namespace
}  // namespace intaglio::sort
