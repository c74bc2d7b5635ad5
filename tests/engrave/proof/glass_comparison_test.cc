#include "engrave/proof/glass_comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace intaglio::proof {
namespace {

PointList Grid(int n, double step_mm) {
  PointList points;
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) points.push_back(step_mm * Vec3(x, y, z));
    }
  }
  return points;
}

struct Crack {
  Vec3 position_mm;
  std::uint64_t tick;
  ChannelMask channel = 1;
};

Cracks All(const std::vector<Crack>& cracks) {
  Cracks all;
  for (const auto& [position_mm, tick, channel] : cracks) {
    all.positions_mm.push_back(position_mm);
    all.ticks.push_back(tick);
    all.channels.push_back(channel);
  }
  return all;
}

std::vector<Crack> Exactly(const PointList& plan) {
  std::vector<Crack> cracks;
  for (std::size_t i = 0; i < plan.size(); ++i) cracks.push_back({plan[i], 100 + 2 * i});
  return cracks;
}

TEST(GlassComparison, ExactGlassHasEveryPointOnce) {
  const PointList plan = Grid(6, 0.1);
  const auto result = CompareGlass(plan, All(Exactly(plan)), 0.05);
  EXPECT_EQ(result.made_count, plan.size());
  EXPECT_EQ(result.doubled_count + result.empty_count + result.stray_count, 0u);
  EXPECT_EQ(result.errors.max_um, 0.0);
  EXPECT_EQ(result.first_tick, 100u);
  EXPECT_EQ(result.last_tick, 100u + 2 * (plan.size() - 1));
}

TEST(GlassComparison, SeesWhatIsDoubledMissingAndStray) {
  const PointList plan = Grid(4, 0.1);
  auto cracks = Exactly(plan);
  cracks.erase(cracks.begin() + 5);
  cracks.push_back({plan[7] + Vec3(0.002, 0, 0), 9000});
  cracks.push_back({Vec3(5, 5, 5), 9001});
  const auto result = CompareGlass(plan, All(cracks), 0.05);
  EXPECT_EQ(result.empty_count, 1u);
  EXPECT_EQ(result.cracks_of_point[5], 0u);
  EXPECT_EQ(result.doubled_count, 1u);
  EXPECT_EQ(result.cracks_of_point[7], 2u);
  EXPECT_EQ(result.stray_count, 1u);
  EXPECT_EQ(result.made_count, plan.size() - 2);
}

TEST(GlassComparison, ErrorsAreThoseThatWerePutIn) {
  const PointList plan = Grid(10, 0.1);
  auto cracks = Exactly(plan);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.003);
  double squares = 0, worst = 0;
  for (Crack& crack : cracks) {
    const Vec3 error(noise(random), noise(random), noise(random));
    crack.position_mm += error;
    squares += error.squaredNorm();
    worst = std::max(worst, error.norm());
  }
  const auto result = CompareGlass(plan, All(cracks), 0.05);
  // Same sums in another order: equal to rounding.
  EXPECT_NEAR(result.errors.rms_um, 1000 * std::sqrt(squares / plan.size()), 1e-9);
  EXPECT_NEAR(result.errors.max_um, 1000 * worst, 1e-9);
}

TEST(GlassComparison, OrderIsThatOfTheTicksNotOfTheFile) {
  const PointList plan = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)};
  const std::vector<Crack> cracks = {{plan[0], 30}, {plan[1], 10}, {plan[2], 20}};
  const auto result = CompareGlass(plan, All(cracks), 0.4);
  EXPECT_EQ(result.made_order, (std::vector<std::uint32_t>{1, 2, 0}));
}

TEST(GlassComparison, EmptyPlanAndEmptyGlass) {
  EXPECT_EQ(CompareGlass({}, All({{Vec3(1, 1, 1), 5}}), 0.1).stray_count, 1u);
  EXPECT_EQ(CompareGlass(Grid(2, 1), {}, 0.1).empty_count, 8u);
}

TEST(MinSpacing, EqualsBruteForce) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(0, 10);
  PointList points;
  for (int i = 0; i < 500; ++i) {
    points.emplace_back(coordinate(random), coordinate(random), coordinate(random));
  }
  double smallest = INFINITY;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      smallest = std::min(smallest, (points[i] - points[j]).norm());
    }
  }
  EXPECT_NEAR(MinSpacing(points), smallest, 1e-12);
  EXPECT_TRUE(std::isinf(MinSpacing({Vec3::Zero()})));
  EXPECT_EQ(MinSpacing({Vec3(1, 2, 3), Vec3(1, 2, 3)}), 0.0);
}

// The nearest two are in another task than the first points.
TEST(MinSpacing, DoesNotDependOnTheExecutor) {
  PointList points = Grid(30, 0.1);
  points.back() = points[points.size() - 3] + Vec3(0.01, 0, 0);
  const Executor backwards = [](std::size_t count, const auto& work) {
    while (count > 0) work(--count);
  };
  EXPECT_EQ(MinSpacing(points, backwards), MinSpacing(points));
  EXPECT_NEAR(MinSpacing(points, backwards), 0.01, 1e-12);
}

// The same places in three blocks, each with some points of its own.
TEST(CompareGlass, EveryChannelIsMatchedToItsOwnPoints) {
  const PointList plan = {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {2, 0, 0}};
  const std::vector<ChannelMask> masks = {1, 3, 2, 4};
  const std::vector<Crack> cracks = {{plan[0], 1, 1}, {plan[1], 2, 1}, {plan[1], 2, 2},
                                     {plan[2], 3, 2}, {plan[3], 4, 1}, {plan[2], 5, 2}};
  const GlassComparison glass = CompareGlass(plan, masks, All(cracks), 0.1);
  EXPECT_EQ(glass.made_count, 2u);
  EXPECT_EQ(glass.doubled_count, 1u);
  EXPECT_EQ(glass.empty_count, 1u);
  EXPECT_EQ(glass.stray_count, 1u) << "in the first block, and planned in the third";
  EXPECT_EQ(glass.cracks_of_point, (std::vector<std::uint32_t>{1, 1, 2, 0}));
  EXPECT_EQ(glass.made_order, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(glass.channels[0].made_count, 2u);
  EXPECT_EQ(glass.channels[0].stray_count, 1u);
  EXPECT_EQ(glass.channels[1].planned_count, 2u);
  EXPECT_EQ(glass.channels[1].doubled_count, 1u);
  EXPECT_EQ(glass.channels[2].empty_count, 1u);
  EXPECT_EQ(glass.channels[3].planned_count, 0u);
}

TEST(MinSpacing, IsThatOfEachChannel) {
  const PointList points = {{0, 0, 0}, {0.1, 0, 0}, {0.4, 0, 0}};
  EXPECT_NEAR(MinSpacing(points, std::vector<ChannelMask>{1, 2, 3}), 0.3, 1e-12);
  EXPECT_NEAR(MinSpacing(points, std::vector<ChannelMask>{1, 3, 2}), 0.1, 1e-12);
  EXPECT_TRUE(std::isinf(MinSpacing(points, std::vector<ChannelMask>{1, 2, 4})));
}

}  // namespace
}  // namespace intaglio::proof
