#pragma once

// What every order for the stage is tried with, and what must be true of it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "engrave/core/executor.h"
#include "engrave/sort/order.h"
#include "tests/engrave/sort/clouds.h"
#include "tests/engrave/sort/shadow_oracle.h"

namespace intaglio::sort {

/// A cloud with a beam, a stage and a lamp.
struct StageCase {
  std::string name;
  PointList points_mm;
  OrderOptions options;
};

/// Clouds of all kinds, as they are and with steps a hundred times as long or short, each
/// with a beam, a stage and a lamp of its own.
inline std::vector<StageCase> StageCases(std::size_t count, Method method) {
  std::vector<NamedCloud> clouds = Clouds(count);
  for (NamedCloud& cloud : DegenerateClouds()) clouds.push_back(std::move(cloud));
  const BeamCone cones[] = {
      {0},          {0.05}, {0.1328}, {0.4}, {1.5}, {0.13, 0.03, 0.1}, {0.13, 0.2, 0.1},
      {0, 0.5, 0.3}};
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<StageCase> cases;
  for (const double scale : {1.0, 0.01, 100.0}) {
    for (const NamedCloud& cloud : clouds) {
      StageCase made{cloud.name + " x " + std::to_string(scale), cloud.points_mm, {}};
      for (Vec3& p : made.points_mm) p *= scale;
      OrderOptions& options = made.options;
      options.method = method;
      options.cone = cones[random() % std::size(cones)];
      options.rate_hz = std::round(50 * std::pow(80.0, unit(random)));
      for (int axis = 0; axis < 3; ++axis) {
        options.limits.max_speed_mm_s[axis] = 20 * std::pow(10.0, unit(random));
        options.limits.max_acceleration_mm_s2[axis] = 500 * std::pow(20.0, unit(random));
      }
      cases.push_back(std::move(made));
    }
  }
  return cases;
}

inline void ExpectEachOnce(Order order, std::size_t count) {
  std::sort(order.begin(), order.end());
  ASSERT_EQ(order.size(), count);
  for (std::uint32_t i = 0; i < count; ++i) ASSERT_EQ(order[i], i);
}

/// By the index and by every pair.
inline void ExpectNoneShaded(const PointList& points_mm, const Order& order,
                             const BeamCone& cone) {
  const PointList made_mm = InOrder(points_mm, order);
  EXPECT_EQ(CountShadowViolations(made_mm, cone), 0);
  EXPECT_EQ(CountShadowViolationsBruteForce(made_mm, cone), 0);
}

/// Executors that do the same work in different orders.
inline std::vector<Executor> Executors() {
  using Work = std::function<void(std::size_t)>;
  return {[](std::size_t count, const Work& work) {
            for (std::size_t i = 0; i < count; ++i) work(i);
          },
          [](std::size_t count, const Work& work) {
            for (std::size_t i = count; i-- > 0;) work(i);
          },
          [](std::size_t count, const Work& work) {
            std::vector<std::jthread> threads;
            for (std::size_t i = 0; i < count; ++i) threads.emplace_back(work, i);
          }};
}

}  // namespace intaglio::sort
