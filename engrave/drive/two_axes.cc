#include "engrave/drive/two_axes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/core/check.h"
#include "engrave/core/try.h"

namespace intaglio::drive {
namespace {

double PeriodOf(const TwoAxes& axes) {
  Require(axes[0].period_s == axes[1].period_s, "periods of {} and {} s",
          axes[0].period_s, axes[1].period_s);
  return axes[0].period_s;
}

Result<TwoAxisRun> Driven(const TwoAxes& axes, std::vector<Vec2> setpoints_m) {
  TwoAxisRun run;
  run.setpoints_m = std::move(setpoints_m);
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> places;
    for (const Vec2& setpoint : run.setpoints_m) places.push_back(setpoint[axis]);
    const auto number = static_cast<std::size_t>(axis);
    run.axes[number] = INTAGLIO_TRY(Simulate(axes[number], places));
  }
  return run;
}

Vec2 PlaceAt(const TwoAxisRun& run, std::size_t sample) {
  return {run.axes[0][sample].position_m, run.axes[1][sample].position_m};
}

void AddDeviation(double outside_m, double& largest_out_m, double& largest_in_m) {
  largest_out_m = std::max(largest_out_m, outside_m);
  largest_in_m = std::max(largest_in_m, -outside_m);
}

/// Distance to the nearer leg; above 0 on the outer side of a turn to the left.
double OutsideOfCorner(const Vec2& place_m, const CornerCourse& course) {
  const Vec2 corner(course.length_m, 0);
  const Vec2 out(std::cos(course.turn_rad), std::sin(course.turn_rad));
  const double on_first = std::clamp(place_m.x(), 0.0, course.length_m);
  const double on_second = std::clamp((place_m - corner).dot(out), 0.0, course.length_m);
  const Vec2 to_first = place_m - Vec2(on_first, 0);
  const Vec2 to_second = place_m - (corner + on_second * out);
  const bool first = to_first.norm() < to_second.norm();
  // To the right of a leg is outside.
  const Vec2 along = first ? Vec2(1, 0) : out;
  const Vec2& off = first ? to_first : to_second;
  const double right = along.y() * off.x() - along.x() * off.y();
  return right >= 0 ? off.norm() : -off.norm();
}

}  // namespace

std::vector<double> SampleCommand(std::span<const CommandPiece> pieces, double period_s) {
  double total_s = 0;
  for (const CommandPiece& piece : pieces) total_s += piece.duration_s;
  std::vector<double> places = {0};
  double begin_s = 0;
  std::size_t piece = 0;
  for (std::size_t i = 1; static_cast<double>(i) * period_s <= total_s; ++i) {
    const double t_s = static_cast<double>(i) * period_s;
    while (piece + 1 < pieces.size() && t_s > begin_s + pieces[piece].duration_s)
      begin_s += pieces[piece++].duration_s;
    places.push_back(pieces[piece].command.At(t_s - begin_s));
  }
  return places;
}

Result<TwoAxisRun> SimulateCircle(const TwoAxes& axes, const CircleCourse& course) {
  Require(course.turns >= 1, "{} turns", course.turns);
  CircularInterpolator circle(course.radius_m, course.speed_m_s, PeriodOf(axes),
                              course.rule);
  std::vector<Vec2> setpoints = {circle.at()};
  const std::size_t count = static_cast<std::size_t>(course.turns) *
                            static_cast<std::size_t>(circle.steps_per_turn());
  for (std::size_t i = 0; i < count; ++i) setpoints.push_back(circle.Next());
  TwoAxisRun run = INTAGLIO_TRY(Driven(axes, std::move(setpoints)));
  for (std::size_t i = 0; i < run.setpoints_m.size(); ++i) {
    const double outside_m = PlaceAt(run, i).norm() - course.radius_m;
    AddDeviation(outside_m, run.outside_m, run.inside_m);
    if (i >= static_cast<std::size_t>(circle.steps_per_turn()))
      AddDeviation(outside_m, run.settled_outside_m, run.settled_inside_m);
  }
  return run;
}

Result<TwoAxisRun> SimulateCorner(const TwoAxes& axes, const CornerCourse& course) {
  Require(
      course.length_m > 0 && course.turn_rad >= 0 && course.turn_rad <= std::numbers::pi,
      "a corner of {} rad behind {} m", course.turn_rad, course.length_m);
  const double length_m = course.stops ? course.length_m : 2 * course.length_m;
  const auto once = Trapezoid(length_m, course.speed_m_s, course.acceleration_m_s2, 0);
  std::vector<CommandPiece> pieces = once;
  if (course.stops) {
    for (CommandPiece piece : once) {
      piece.command.position_u += course.length_m;
      pieces.push_back(piece);
    }
  }
  pieces.push_back({{2 * course.length_m, 0, 0, 0}, course.rest_s});
  const Vec2 out(std::cos(course.turn_rad), std::sin(course.turn_rad));
  std::vector<Vec2> setpoints;
  for (const double way_m : SampleCommand(pieces, PeriodOf(axes))) {
    const double behind_m = std::max(0.0, way_m - course.length_m);
    setpoints.push_back(Vec2(way_m - behind_m, 0) + behind_m * out);
  }
  TwoAxisRun run = INTAGLIO_TRY(Driven(axes, std::move(setpoints)));
  for (std::size_t i = 0; i < run.setpoints_m.size(); ++i)
    AddDeviation(OutsideOfCorner(PlaceAt(run, i), course), run.outside_m, run.inside_m);
  return run;
}

}  // namespace intaglio::drive
