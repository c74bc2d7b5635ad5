// Compensation and prediction against the equations of the drives, integrated by
// Runge-Kutta over the commands of a plan.

#include "engrave/motion/commands/error_prediction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>

#include "engrave/drive/drive_kinds.h"
#include "engrave/motion/planner.h"
#include "engrave/motion/point_plan.h"

namespace intaglio::motion {
namespace {

constexpr double kFullTurn = 2 * std::numbers::pi;
constexpr double kLampHz = 100;

using DriveStates = std::array<double, 5>;
using SlopeOfDrive = std::function<DriveStates(const DriveStates&, double c, double c_s)>;

struct ModelledDrive {
  const char* kind;
  std::vector<double> values;
  SlopeOfDrive slope;
  int inner_position = -1;  ///< a state that is a position, too
  double left_ratio = 0;    ///< of the error without compensation, at most
};

std::vector<ModelledDrive> ModelledDrives() {
  const auto spring = [](double hz) { return kFullTurn * hz; };
  return {
      {"servo",
       {300, 0.003, 0, 0},
       [](const DriveStates& y, double c, double) {
         return DriveStates{y[1], (300 * (c - y[0]) - y[1]) / 0.003};
       },
       -1,
       0.35},
      {"servo",
       {100, 0.003, 0.3, 0.9},
       [](const DriveStates& y, double c, double c_s) {
         return DriveStates{
             y[1], (100 * (c - y[0]) + 0.3 * (c_s - y[1]) + 0.9 * c_s - y[1]) / 0.003};
       },
       -1,
       0.3},
      {"cascade",
       {500, 250, 0.5},
       [m = spring(250)](const DriveStates& y, double c, double) {
         const double a = 1500 * (500 * (c - y[2]) - y[3]);
         return DriveStates{y[1], m * m * (y[2] - y[0]) - m * y[1], y[3], y[4],
                            6000 * (a - y[4])};
       },
       2,
       0.25},
      {"stepper_screw",
       {100, 0.5, 300, 0.1, 0.5},
       [p = spring(100), q = spring(300)](const DriveStates& y, double c, double) {
         const double f = q * q * (y[2] - y[0]) + 0.2 * q * (y[3] - y[1]);
         return DriveStates{y[1], f, y[3], p * p * (c - y[2]) - p * y[3] - 0.5 * f};
       },
       2,
       0.35},
      {"planar_drive",
       {60, 0.7, 30, 0.0004},
       [w = spring(60)](const DriveStates& y, double c, double) {
         const double e = c - y[0], late_s = 0.0002, ki = w * w * 30;
         const double e_s = (e - y[4]) / late_s;
         const double asked =
             (w * w + 1.4 * w * 30 + ki * late_s) * e + ki * y[2] + (1.4 * w + 30) * e_s;
         return DriveStates{y[1], y[3], e, (asked - y[3]) / late_s, e_s};
       },
       -1,
       0.3},
  };
}

PointList RandomWalk() {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0, 0.15);
  PointList points = {Vec3::Zero()};
  for (int i = 0; i < 300; ++i)
    points.push_back(points.back() + Vec3(normal(random), normal(random), 0));
  return points;
}

std::vector<Segment> CommandsOf(const PointList& points,
                                const std::shared_ptr<const drive::Drive>& drive) {
  PlanOptions options;
  options.rate_hz = kLampHz;
  options.continuous = true;
  options.drives = drive::AllAxes(drive);
  return PlanPoints(options, points);
}

/// x and y of the axes at the points, integrated.
PointList Integrated(const ModelledDrive& of, const std::vector<Segment>& commands,
                     std::size_t count) {
  PointList places(count, Vec3::Zero());
  for (int axis = 0; axis < 2; ++axis) {
    DriveStates y = {};
    KnotState from;
    for (const Segment& to : commands) {
      const double duration_s = DurationSeconds(to.duration_subticks, kLampHz);
      const int steps = static_cast<int>(std::ceil(duration_s / 1e-5));
      const double h = duration_s / steps;
      const double p0 = from.position_mm[axis], v0 = from.velocity_mm_s[axis];
      const double mean = (to.end_position_mm[axis] - p0) / duration_s;
      const double v1 = to.end_velocity_mm_s[axis];
      const double c2 = (3 * mean - 2 * v0 - v1) / duration_s;
      const double c3 = (v0 + v1 - 2 * mean) / (duration_s * duration_s);
      const auto slope = [&](const DriveStates& at, double t) {
        return of.slope(at, p0 + t * (v0 + t * (c2 + t * c3)),
                        v0 + t * (2 * c2 + 3 * t * c3));
      };
      const auto along = [](DriveStates at, const DriveStates& by, double k) {
        for (std::size_t i = 0; i < at.size(); ++i) at[i] += k * by[i];
        return at;
      };
      for (int i = 0; i < steps; ++i) {
        const DriveStates k1 = slope(y, i * h);
        const DriveStates k2 = slope(along(y, k1, h / 2), (i + 0.5) * h);
        const DriveStates k3 = slope(along(y, k2, h / 2), (i + 0.5) * h);
        const DriveStates k4 = slope(along(y, k3, h), (i + 1) * h);
        y = along(along(along(along(y, k1, h / 6), k2, h / 3), k3, h / 3), k4, h / 6);
      }
      if (to.point >= 0) places[static_cast<std::size_t>(to.point)][axis] = y[0];
      from = to.end();
    }
  }
  return places;
}

double RmsDistance(const PointList& places, const PointList& points) {
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    sum += (places[i] - points[i]).head<2>().squaredNorm();
  return std::sqrt(sum / static_cast<double>(points.size()));
}

PointList Predicted(const std::shared_ptr<const drive::Drive>& drive,
                    const std::vector<Segment>& commands, std::size_t count) {
  ErrorPrediction prediction(drive::AllAxes(drive), kLampHz, Vec3::Zero());
  std::vector<PredictedPlace> found;
  for (const Segment& command : commands) prediction.Append(command, found);
  EXPECT_EQ(found.size(), count);
  PointList places(count, Vec3::Zero());
  for (const PredictedPlace& place : found)
    places[static_cast<std::size_t>(place.point)] = place.axes;
  return places;
}

TEST(ErrorPrediction, IsWhereTheEquationsOfTheDriveCome) {
  const PointList points = RandomWalk();
  for (const ModelledDrive& of : ModelledDrives()) {
    const auto drive = drive::MakeDrive(of.kind, of.values).value();
    for (const auto& compensated : {drive, decltype(drive)()}) {
      const auto commands = CommandsOf(points, compensated);
      const PointList expected = Integrated(of, commands, points.size());
      const PointList actual = Predicted(drive, commands, points.size());
      // Steps of 10 us of equations whose fastest rate is 6000 1/s.
      EXPECT_LT(RmsDistance(actual, expected), 1e-5) << of.kind;
    }
  }
}

TEST(ErrorPrediction, CompensationLeavesLittleOfTheError) {
  const PointList points = RandomWalk();
  for (const ModelledDrive& of : ModelledDrives()) {
    const auto drive = drive::MakeDrive(of.kind, of.values).value();
    const double with_mm =
        RmsDistance(Predicted(drive, CommandsOf(points, drive), points.size()), points);
    const double without_mm =
        RmsDistance(Predicted(drive, CommandsOf(points, nullptr), points.size()), points);
    EXPECT_LT(with_mm, of.left_ratio * without_mm)
        << of.kind << " " << with_mm << " of " << without_mm << " mm";
  }
}

// A plan that brakes at the end of the travel: the commands stay within the lead, and
// what its jerk adds, which a plan does not limit.
TEST(ErrorPrediction, CommandsWithTransientsKeepTheLeadOfTheDrive) {
  for (const ModelledDrive& of : ModelledDrives()) {
    const auto drive = drive::MakeDrive(of.kind, of.values).value();
    const PointList there_and_back = {Vec3::Zero(), Vec3(10, 0, 0), Vec3(10, 0.5, 0),
                                      Vec3::Zero()};
    double commanded_mm = 0, planned_mm = 0;
    for (const Segment& command : CommandsOf(there_and_back, drive))
      commanded_mm = std::max(commanded_mm, command.end_position_mm.x());
    for (const Segment& planned : CommandsOf(there_and_back, nullptr))
      planned_mm = std::max(planned_mm, planned.end_position_mm.x());
    EXPECT_LT(commanded_mm, planned_mm + drive->lead_s2() * 7000 + 0.005) << of.kind;
  }
}

}  // namespace
}  // namespace intaglio::motion
