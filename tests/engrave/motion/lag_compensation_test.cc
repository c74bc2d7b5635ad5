#include "engrave/motion/lag_compensation.h"

#include <gtest/gtest.h>

#include <random>

#include "engrave/motion/planner.h"

namespace intaglio::motion {
namespace {

/// Distances of a lagging stage from the points at their ticks, by integrating its
/// equation x' = (c - x) / lag with Runge-Kutta steps a hundredth of the lag long.
std::vector<double> DistancesAtPoints(const std::vector<Segment>& commands,
                                      const PointList& points, const Vec3& start_mm,
                                      double lag_s, double rate_hz) {
  std::vector<double> distances;
  KnotState from{start_mm, Vec3::Zero()};
  Vec3 x = start_mm;
  for (const Segment& to : commands) {
    const double duration_s = DurationSeconds(to.duration_subticks, rate_hz);
    const auto steps = static_cast<int>(std::ceil(duration_s / (0.01 * lag_s)));
    const double h = duration_s / steps;
    const auto slope = [&](double t, const Vec3& at) -> Vec3 {
      return (HermitePosition(from, to, t, duration_s) - at) / lag_s;
    };
    for (int i = 0; i < steps; ++i) {
      const double t = i * h;
      const Vec3 k1 = slope(t, x), k2 = slope(t + h / 2, x + h / 2 * k1);
      const Vec3 k3 = slope(t + h / 2, x + h / 2 * k2), k4 = slope(t + h, x + h * k3);
      x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    if (to.point >= 0) {
      distances.push_back((x - points[static_cast<std::size_t>(to.point)]).norm());
    }
    from = to.end();
  }
  return distances;
}

std::vector<Segment> Commands(const PointList& points, const PlanOptions& options) {
  const auto planner = MakePlanner(options, points.front());
  std::vector<Segment> commands;
  for (std::size_t i = 0; i < points.size(); ++i) {
    planner->Append(points[i], static_cast<std::int32_t>(i), true, commands);
  }
  planner->Finish(commands);
  return commands;
}

TEST(LagCompensation, BringsALaggingStageToItsPoints) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0, 0.15);
  PointList points = {Vec3::Zero()};
  for (int i = 0; i < 600; ++i) {
    points.push_back(points.back() +
                     Vec3(normal(random), normal(random), 0.2 * normal(random)));
  }
  for (const double rate_hz : {100.0, 200.0, 1000.0}) {
    PlanOptions options;
    options.rate_hz = rate_hz;
    options.continuous = true;
    const auto largest = [&](double compensated_s) {
      options.stage_lag_s = compensated_s;
      const auto distances = DistancesAtPoints(Commands(points, options), points,
                                               points.front(), 0.0002, rate_hz);
      EXPECT_EQ(distances.size(), points.size());
      return *std::max_element(distances.begin(), distances.end());
    };
    EXPECT_GT(largest(0), 0.008) << "without it the points are passed late";
    // A jump of 14 m/s^2 on an axis leaves lag^2 a / 2 = 0.28 um; two axes may jump.
    EXPECT_LT(largest(0.0002), 0.0005) << rate_hz;
  }
}

TEST(LagCompensation, KeepsTimesPointsAndTheRestAtTheEnd) {
  PlanOptions options;
  options.rate_hz = 100;
  options.continuous = true;
  const PointList points = {Vec3(0, 0, 0), Vec3(0.2, 0, 0), Vec3(0.5, 0.1, 0)};
  const auto plain = Commands(points, options);
  options.stage_lag_s = 0.0002;
  const auto commands = Commands(points, options);
  ASSERT_EQ(commands.size(), plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_EQ(commands[i].duration_subticks, plain[i].duration_subticks);
    EXPECT_EQ(commands[i].point, plain[i].point);
    EXPECT_EQ(commands[i].pulse, plain[i].pulse);
  }
  EXPECT_TRUE(commands.back().program_end);
  EXPECT_EQ(commands.back().end_velocity_mm_s, Vec3(Vec3::Zero()));
  EXPECT_EQ(commands.back().end_position_mm, points.back());
}

}  // namespace
}  // namespace intaglio::motion
