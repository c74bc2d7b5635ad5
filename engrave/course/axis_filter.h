#pragma once

// An axis stepped through setpoints between which its controller interpolates linearly:
// the exact solution of the drive's linear equation at the setpoints, whatever their
// period.

#include <span>
#include <vector>

namespace intaglio::course {

class AxisFilter {
 public:
  /// `denominator` by ascending powers of s, the first is 1: command = denominator x
  /// actual; at most kMaxOrder. period_s > 0.
  AxisFilter(std::span<const double> denominator, double period_s);

  static constexpr int kMaxOrder = 6;

  /// The actual position at each setpoint. Before the first the command came along the
  /// straight line through the first two, for ever: the axis lags behind it as settled.
  void Run(std::span<const double> setpoints, std::span<double> actual) const;

 private:
  template <int kOrder>
  void RunOf(std::span<const double> setpoints, std::span<double> actual) const;

  int order_ = 0;
  double lag_s_ = 0;
  double period_s_ = 0;
  // state' = step state + now u + next u', u the command at the begin and the end.
  double step_[kMaxOrder][kMaxOrder] = {};
  double now_[kMaxOrder] = {}, next_[kMaxOrder] = {};
};

}  // namespace intaglio::course
