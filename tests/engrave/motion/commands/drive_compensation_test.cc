#include "engrave/motion/commands/drive_compensation.h"

#include <gtest/gtest.h>

#include <functional>
#include <numbers>
#include <random>

#include "engrave/drive/first_order.h"
#include "engrave/drive/second_order.h"
#include "engrave/motion/planner.h"
#include "engrave/motion/point_plan.h"

namespace intaglio::motion {
namespace {

using drive::FirstOrder;
using drive::SecondOrder;
using DrivePtr = std::shared_ptr<const drive::Drive>;

/// The equation of a stage, x' and v' of x, v and the command, and a short time of it.
struct Stage {
  std::function<KnotState(const KnotState&, const Vec3&)> slope;
  double shortest_s = 0;
};

Stage LaggingStage(double lag_s) {
  return {[lag_s](const KnotState& at, const Vec3& command_mm) {
            return KnotState{(command_mm - at.position_mm) / lag_s, Vec3::Zero()};
          },
          lag_s};
}

Stage SpringyStage(double frequency_hz, double damping) {
  const double w = 2 * std::numbers::pi * frequency_hz;
  return {[w, damping](const KnotState& at, const Vec3& command_mm) {
            return KnotState{at.velocity_mm_s, w * w * (command_mm - at.position_mm) -
                                                   2 * damping * w * at.velocity_mm_s};
          },
          1 / w};
}

/// Distances of the stage from the points at their ticks, by integrating its equation
/// with Runge-Kutta steps of 0.03 of its shortest time, whose error is below 1 nm.
std::vector<double> DistancesAtPoints(const std::vector<Segment>& commands,
                                      const PointList& points, const Stage& stage,
                                      double rate_hz) {
  std::vector<double> distances;
  KnotState from{points.front(), Vec3::Zero()}, x = from;
  const auto along = [](const KnotState& a, double h, const KnotState& slope) {
    return KnotState{a.position_mm + h * slope.position_mm,
                     a.velocity_mm_s + h * slope.velocity_mm_s};
  };
  for (const Segment& to : commands) {
    const double duration_s = DurationSeconds(to.duration_subticks, rate_hz);
    const int steps = static_cast<int>(std::ceil(duration_s / (0.03 * stage.shortest_s)));
    const double h = duration_s / steps;
    for (int i = 0; i < steps; ++i) {
      const auto command = [&](double t) {
        return HermitePosition(from, to, t, duration_s);
      };
      const double t = i * h;
      const KnotState k1 = stage.slope(x, command(t));
      const KnotState k2 = stage.slope(along(x, h / 2, k1), command(t + h / 2));
      const KnotState k3 = stage.slope(along(x, h / 2, k2), command(t + h / 2));
      const KnotState k4 = stage.slope(along(x, h, k3), command(t + h));
      x = along(along(along(along(x, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
    }
    if (to.point >= 0) {
      distances.push_back(
          (x.position_mm - points[static_cast<std::size_t>(to.point)]).norm());
    }
    from = to.end();
  }
  return distances;
}

PointList WanderingPoints() {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0, 0.15);
  PointList points = {Vec3::Zero()};
  for (int i = 0; i < 600; ++i) {
    points.push_back(points.back() +
                     Vec3(normal(random), normal(random), 0.2 * normal(random)));
  }
  return points;
}

/// The largest distance from a point when the commands are made for `compensated`.
double LargestDistance(const Stage& stage, const DrivePtr& compensated, double rate_hz) {
  const PointList points = WanderingPoints();
  PlanOptions options;
  options.rate_hz = rate_hz;
  options.continuous = true;
  options.drives = drive::AllAxes(compensated);
  const auto distances =
      DistancesAtPoints(PlanPoints(options, points), points, stage, rate_hz);
  EXPECT_EQ(distances.size(), points.size());
  return *std::max_element(distances.begin(), distances.end());
}

TEST(DriveCompensation, BringsALaggingStageToItsPoints) {
  const auto drive = std::make_shared<FirstOrder>(0.0002);
  for (const double rate_hz : {100.0, 200.0, 1000.0}) {
    EXPECT_GT(LargestDistance(LaggingStage(0.0002), nullptr, rate_hz), 0.008)
        << "without it the points are passed late";
    // A jump of 14 m/s^2 on an axis leaves lag^2 a / 2 = 0.28 um; two axes may jump.
    EXPECT_LT(LargestDistance(LaggingStage(0.0002), drive, rate_hz), 0.0005) << rate_hz;
  }
}

TEST(DriveCompensation, BringsASpringyStageToItsPoints) {
  for (const double frequency_hz : {60.0, 120.0, 400.0}) {
    const double damping = 0.7, w = 2 * std::numbers::pi * frequency_hz;
    const Stage stage = SpringyStage(frequency_hz, damping);
    for (const double rate_hz : {100.0, 1000.0}) {
      const double without_mm = LargestDistance(stage, nullptr, rate_hz);
      // The first order of the same lag at constant speed.
      const double first_mm =
          LargestDistance(stage, std::make_shared<FirstOrder>(2 * damping / w), rate_hz);
      const double second_mm = LargestDistance(
          stage, std::make_shared<SecondOrder>(frequency_hz, damping), rate_hz);
      // The acceleration of an axis jumps by up to 14 m/s^2, the exact command by w^-2 of
      // it; half of it is missing on either side, on two axes at most.
      EXPECT_LT(second_mm, std::sqrt(2.0) * 14000 / (2 * w * w)) << frequency_hz;
      EXPECT_LT(second_mm, 0.65 * first_mm) << frequency_hz << " " << rate_hz;
      EXPECT_LT(first_mm, 0.5 * without_mm) << frequency_hz << " " << rate_hz;
    }
  }
}

TEST(DriveCompensation, KeepsTimesPointsAndTheRestAtTheEnd) {
  const PointList points = {Vec3(0, 0, 0), Vec3(0.2, 0, 0), Vec3(0.5, 0.1, 0)};
  for (const DrivePtr& drive : {DrivePtr(std::make_shared<FirstOrder>(0.0002)),
                                DrivePtr(std::make_shared<SecondOrder>(120, 0.7))}) {
    PlanOptions options;
    options.rate_hz = 100;
    options.continuous = true;
    const auto plain = PlanPoints(options, points);
    options.drives = drive::AllAxes(drive);
    const auto commands = PlanPoints(options, points);
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
}

}  // namespace
}  // namespace intaglio::motion
