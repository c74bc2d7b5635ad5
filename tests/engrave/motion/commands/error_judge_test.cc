// Plans under the limit of an error, against the drive's own equation over the commands.

#include "engrave/motion/commands/error_judge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "engrave/core/check.h"
#include "engrave/drive/drive_kinds.h"
#include "engrave/motion/commands/error_prediction.h"
#include "engrave/motion/planner.h"
#include "engrave/motion/point_plan.h"

namespace intaglio::motion {
namespace {

constexpr double kJudgeHz = 200;

PointList Cloud() {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal(0, 0.12);
  PointList points = {Vec3::Zero()};
  for (int i = 0; i < 700; ++i)
    points.push_back(points.back() + Vec3(normal(random), normal(random), 0));
  return points;
}

struct Planned {
  std::vector<Segment> commands;
  std::uint64_t ticks = 0;
};

Planned PlanWith(const PointList& points, const drive::AxisDrives& drives,
                 double error_limit, bool compensated = true) {
  PlanOptions options;
  options.rate_hz = kJudgeHz;
  options.continuous = true;
  options.drives = drives;
  options.error_limit = error_limit;
  options.compensated = compensated;
  Planned planned{PlanPoints(options, points)};
  for (const Segment& command : planned.commands)
    planned.ticks += command.duration_subticks;
  planned.ticks /= kSubticksPerTick;
  return planned;
}

double GreatestError(const PointList& points, const Planned& planned,
                     const drive::AxisDrives& drives) {
  ErrorPrediction prediction(drives, kJudgeHz, points.front());
  std::vector<PredictedPlace> places;
  for (const Segment& command : planned.commands) prediction.Append(command, places);
  EXPECT_EQ(places.size(), points.size());
  double greatest = 0;
  for (const PredictedPlace& place : places) {
    greatest = std::max(
        greatest, (place.axes - points.at(static_cast<std::size_t>(place.point))).norm());
  }
  return greatest;
}

drive::AxisDrives Springs(double frequency_hz) {
  return drive::AllAxes(
      drive::MakeDrive("second_order", std::vector{frequency_hz, 0.7}).value());
}

// A drive too weak for the limits of its axes: the plan slows where it has to, and only
// there.
TEST(ErrorJudge, ThePlanKeepsTheErrorLimit) {
  const PointList points = Cloud();
  const drive::AxisDrives drives = Springs(60);
  const Planned free = PlanWith(points, drives, 0);
  const double without_mm = GreatestError(points, free, drives);
  double ticks = static_cast<double>(free.ticks);
  for (const double limit_mm : {0.03, 0.015}) {
    ASSERT_GT(without_mm, limit_mm);
    const Planned limited = PlanWith(points, drives, limit_mm);
    // Behind the end of a window the first knot is planned anew.
    EXPECT_LT(GreatestError(points, limited, drives), 1.1 * limit_mm);
    EXPECT_GT(static_cast<double>(limited.ticks), ticks);
    ticks = static_cast<double>(limited.ticks);
    EXPECT_LT(ticks, 2.0 * static_cast<double>(free.ticks));
  }
}

// Slower steps need more way to brake: what comes near the end of the travel stays within
// it, and the plan ends.
TEST(ErrorJudge, AtTheEndsOfTheTravelThePlanStaysWithinIt) {
  const PointList points = Cloud();
  Box3 extent{points.front(), points.front()};
  for (const Vec3& point : points) extent.Extend(point);
  const drive::AxisDrives drives = Springs(60);
  PlanOptions options;
  options.rate_hz = kJudgeHz;
  options.continuous = true;
  options.drives = drives;
  options.error_limit = 0.02;
  options.compensated = false;
  const Vec3 lead_mm =
      drives[0]->lead_s2() * options.limits.max_acceleration_mm_s2 + Vec3::Constant(0.01);
  options.limits.travel_mm = {extent.min_mm - lead_mm, extent.max_mm + lead_mm};
  const std::vector<Segment> plan = PlanPoints(options, points);
  const Vec3 wall_mm = Vec3::Constant(0.0101);
  KnotState from{points.front(), Vec3::Zero()};
  for (const Segment& to : plan) {
    const double duration_s = DurationSeconds(to.duration_subticks, kJudgeHz);
    for (int i = 0; i <= 8; ++i) {
      const Vec3 at_mm = HermitePosition(from, to, duration_s * i / 8, duration_s);
      EXPECT_TRUE((at_mm.array() >= (extent.min_mm - wall_mm).array()).all() &&
                  (at_mm.array() <= (extent.max_mm + wall_mm).array()).all());
    }
    from = to.end();
  }
}

// It is planned in shorter windows, which may cost a tick now and then.
TEST(ErrorJudge, APlanWithinItsLimitTakesNoLonger) {
  const PointList points = Cloud();
  const drive::AxisDrives drives = Springs(400);
  const auto free = static_cast<double>(PlanWith(points, drives, 0).ticks);
  EXPECT_NEAR(static_cast<double>(PlanWith(points, drives, 1).ticks), free, 0.005 * free);
}

// Each axis is compensated by its own inverse; with one for all, those that are driven
// otherwise are beside the points.
TEST(ErrorJudge, EachAxisIsCompensatedByItsOwnDrive) {
  const PointList points = Cloud();
  drive::AxisDrives own = Springs(120);
  own[1] = drive::MakeDrive("servo", std::vector{300.0, 0.001, 0.0, 0.0}).value();
  own[2] = nullptr;
  const double own_mm = GreatestError(points, PlanWith(points, own, 0), own);
  const double alike_mm = GreatestError(points, PlanWith(points, Springs(120), 0), own);
  EXPECT_LT(own_mm, 0.03);
  EXPECT_GT(alike_mm, 3 * own_mm);
}

TEST(ErrorJudge, APlanThatIsNotCompensatedIsThePlan) {
  const PointList points = Cloud();
  const Planned plan = PlanWith(points, Springs(60), 0.015, false);
  std::size_t made = 0;
  for (const Segment& segment : plan.commands) {
    if (segment.point < 0) continue;
    EXPECT_EQ(segment.end_position_mm, points[static_cast<std::size_t>(segment.point)]);
    ++made;
  }
  EXPECT_EQ(made, points.size());
  EXPECT_EQ(plan.ticks, PlanWith(points, Springs(60), 0.015).ticks);
}

TEST(ErrorJudge, ALimitOfNothingIsRefused) {
  EXPECT_THROW(ErrorJudge(Springs(60), kJudgeHz, Vec3::Zero(), 0), PreconditionError);
}

}  // namespace
}  // namespace intaglio::motion
