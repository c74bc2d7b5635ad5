#include "tests/engrave/course/oracle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace intaglio::course {
namespace {

/// Motor position, speed, acceleration; load position, speed.
using State = std::array<double, 5>;

State Slope(const OracleAxis& axis, const State& x, double command) {
  const double wc = axis.bandwidth_rad_s, w = axis.natural_rad_s;
  State d{};
  if (axis.cascade) {
    const double speed = wc * (command - x[0]);
    const double acceleration = 3 * wc * (speed - x[1]);
    d[0] = x[1];
    d[1] = x[2];
    d[2] = 12 * wc * (acceleration - x[2]);
  } else {
    d[0] = wc * (command - x[0]);
  }
  d[3] = x[4];
  d[4] = w * w * (x[0] - x[3]) - 2 * axis.damping_ratio * w * x[4];
  return d;
}

State Plus(const State& x, const State& d, double step) {
  State y{};
  for (std::size_t i = 0; i < x.size(); ++i) y[i] = x[i] + step * d[i];
  return y;
}

State Step(const OracleAxis& axis, const State& x, double from, double to,
           double step_s) {
  const double middle = (from + to) / 2;
  const State k1 = Slope(axis, x, from);
  const State k2 = Slope(axis, Plus(x, k1, step_s / 2), middle);
  const State k3 = Slope(axis, Plus(x, k2, step_s / 2), middle);
  const State k4 = Slope(axis, Plus(x, k3, step_s), to);
  State y = x;
  for (std::size_t i = 0; i < x.size(); ++i)
    y[i] += step_s / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  return y;
}

State Settled(const OracleAxis& axis, double command, double speed) {
  const double motor = command - speed / axis.bandwidth_rad_s;
  const double load = motor - 2 * axis.damping_ratio / axis.natural_rad_s * speed;
  return {motor, speed, 0, load, speed};
}

double ToLine(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  if (d.squaredNorm() <= 0) return (p - a).norm();
  const double share = std::clamp(d.dot(p - a) / d.squaredNorm(), 0.0, 1.0);
  return (p - a - share * d).norm();
}

constexpr double kReachMm = 12;

}  // namespace

std::array<OracleAxis, 2> OracleOf(const AxisPair& axes) {
  std::array<OracleAxis, 2> oracle;
  for (std::size_t i = 0; i < 2; ++i) {
    const AxisParameters& p = axes[i].parameters();
    oracle[i] = {p.loop == LoopKind::kCascade, p.bandwidth_rad_s, p.natural_rad_s,
                 p.damping_ratio};
  }
  return oracle;
}

std::vector<Vec2> OracleFollow(const std::array<OracleAxis, 2>& axes,
                               const std::vector<Vec2>& setpoints_mm, double period_s,
                               int fine) {
  constexpr double kStepS = 1e-4;
  const int inner =
      std::max(1, static_cast<int>(std::ceil(period_s / fine / kStepS - 1e-9)));
  std::vector<Vec2> actual((setpoints_mm.size() - 1) * static_cast<std::size_t>(fine) +
                           1);
  for (int k = 0; k < 2; ++k) {
    const OracleAxis& axis = axes[static_cast<std::size_t>(k)];
    State x = Settled(axis, setpoints_mm[0][k],
                      (setpoints_mm[1][k] - setpoints_mm[0][k]) / period_s);
    std::size_t out = 0;
    actual[out++][k] = x[3];
    const int steps = fine * inner;
    for (std::size_t i = 0; i + 1 < setpoints_mm.size(); ++i) {
      const double from = setpoints_mm[i][k];
      const double change = (setpoints_mm[i + 1][k] - from) / steps;
      for (int j = 0; j < steps; ++j) {
        x = Step(axis, x, from + change * j, from + change * (j + 1), period_s / steps);
        if ((j + 1) % inner == 0) actual[out++][k] = x[3];
      }
    }
  }
  return actual;
}

double ToLeg(const Vec2& p_mm, const Vec2& direction, double side) {
  return (p_mm - direction * (side * std::max(0.0, side * direction.dot(p_mm)))).norm();
}

OracleError OracleMeasure(const Path& path, const std::vector<Vec2>& actual_mm,
                          const std::vector<double>& commanded_s_mm) {
  OracleError error;
  const auto& s = path.node_s_mm();
  for (std::size_t i = 0; i < actual_mm.size(); ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < path.segment_count(); ++k) {
      if (s[k + 1] < commanded_s_mm[i] - kReachMm || s[k] > commanded_s_mm[i] + kReachMm)
        continue;
      nearest =
          std::min(nearest, ToLine(actual_mm[i], path.node_mm(k), path.node_mm(k + 1)));
    }
    error.one_sided_mm = std::max(error.one_sided_mm, nearest);
  }
  const auto to_course = [&](const Vec2& p, double at_mm) {
    const auto first =
        std::lower_bound(commanded_s_mm.begin(), commanded_s_mm.end(), at_mm - kReachMm) -
        commanded_s_mm.begin();
    double nearest = std::numeric_limits<double>::infinity();
    for (auto i = static_cast<std::size_t>(first);
         i + 1 < actual_mm.size() && commanded_s_mm[i] <= at_mm + kReachMm; ++i) {
      nearest = std::min(nearest, ToLine(p, actual_mm[i], actual_mm[i + 1]));
    }
    return nearest;
  };
  for (std::size_t k = 0; k < path.node_count(); ++k)
    error.node_miss_mm = std::max(error.node_miss_mm, to_course(path.node_mm(k), s[k]));
  for (std::size_t k = 0; k < path.segment_count(); ++k) {
    const double length = path.segments()[k].length_mm;
    for (double at = 0.1; at < length; at += 0.1)
      error.other_side_mm = std::max(
          error.other_side_mm, to_course(path.segments()[k].PointAt(at), s[k] + at));
  }
  return error;
}

}  // namespace intaglio::course
