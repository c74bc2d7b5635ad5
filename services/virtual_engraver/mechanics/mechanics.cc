#include "services/virtual_engraver/mechanics/mechanics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

// First order. An axis follows its command u with x' = (u - x) / tau. For a cubic u the
// particular solution is q = u - tau u' + tau^2 u'' - tau^3 u''' (insert it: q + tau q' =
// u, as the fourth derivative is zero), so over any piece of a cubic the exact state is
//   x(t) = q(t) + (x(t0) - q(t0)) exp(-(t - t0) / tau).
//
// Second order. With a = w t and derivatives by a, y = (x, x', u, u', u'', u''') obeys
// y' = M y:  x'' = u - x - 2 d x', and u'''' = 0. So y(a) = exp(M a) y(0), whatever the
// damping. The exponential is the Taylor series of M a / 2^k, squared k times.

namespace intaglio::virtual_engraver {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Below 0.25^13 / 13!, 3e-18, nothing is left of the series.
constexpr int kTerms = 12;
constexpr double kSmall = 0.25;

// Between two set points of a controller.
constexpr double kSetPointS = 1e-4;

Matrix6 Exponential(const Matrix6& exponent) {
  const double size = exponent.cwiseAbs().colwise().sum().maxCoeff();
  const int halvings =
      size > kSmall ? static_cast<int>(std::ceil(std::log2(size / kSmall))) : 0;
  const Matrix6 small = std::ldexp(1.0, -halvings) * exponent;
  Matrix6 sum = Matrix6::Identity(), term = Matrix6::Identity();
  for (int i = 1; i <= kTerms; ++i) {
    term = (term * small / i).eval();
    sum += term;
  }
  for (int i = 0; i < halvings; ++i) sum = (sum * sum).eval();
  return sum;
}

}  // namespace

bool MechanicsOptions::first_order() const {
  if (!of_axis.empty()) {
    return std::ranges::all_of(of_axis, [](const auto& of) { return of.first_order(); });
  }
  return !second_order && !loop;
}

std::optional<MechanicsOptions> Undisturbed(const MechanicsOptions& options) {
  MechanicsOptions undisturbed = options;
  if (options.first_order() && options.of_axis.empty()) return std::nullopt;
  undisturbed.steps_per_mm = Vec3::Zero();
  if (undisturbed.loop) undisturbed.loop = Undisturbed(*undisturbed.loop);
  for (MechanicsOptions& of : undisturbed.of_axis) {
    if (of.loop) of.loop = Undisturbed(*of.loop);
  }
  return undisturbed;
}

Mechanics::Mechanics(const MechanicsOptions& options, const Vec3& at_mm)
    : lag_s_(options.lag_s),
      steps_per_mm_(options.steps_per_mm),
      second_order_(options.second_order),
      actual_mm_(at_mm) {
  for (const MechanicsOptions& of : options.of_axis) of_axis_.emplace_back(of, at_mm);
  if (!options.loop || !of_axis_.empty()) return;
  for (int axis = 0; axis < 3; ++axis) loops_.emplace_back(*options.loop, at_mm[axis]);
}

Vec3 Mechanics::velocity_lag_s() const {
  if (!of_axis_.empty()) {
    return {of_axis_[0].velocity_lag_s()[0], of_axis_[1].velocity_lag_s()[1],
            of_axis_[2].velocity_lag_s()[2]};
  }
  if (!loops_.empty()) return Vec3::Constant(loops_.front().velocity_lag_s());
  if (!second_order_) return Vec3::Constant(lag_s_);
  return Vec3::Constant(second_order_->damping_ratio /
                        (std::numbers::pi * second_order_->natural_frequency_hz));
}

void Mechanics::Stick(int axis) {
  for (int i = 0; i < 3; ++i) {
    if (axis < 0 || axis == i) stuck_[static_cast<std::size_t>(i)] = true;
  }
  for (Mechanics& own : of_axis_) own.Stick(axis);
}

void Mechanics::Unstick() {
  stuck_ = {false, false, false};
  for (Mechanics& own : of_axis_) own.Unstick();
}

CubicCommand Mechanics::InSteps(const CubicCommand& command, double at_s) const {
  CubicCommand set = command;
  const Vec3 at_mm = command.At(at_s);
  for (int axis = 0; axis < 3; ++axis) {
    const double steps = steps_per_mm_[axis];
    if (steps > 0) set.p[axis] += std::round(at_mm[axis] * steps) / steps - at_mm[axis];
  }
  return set;
}

void Mechanics::Follow(const CubicCommand& command, double from_s, double to_s) {
  if (steps_per_mm_.isZero(0)) return FollowAsSet(command, from_s, to_s);
  const int count =
      std::max(1, static_cast<int>(std::ceil((to_s - from_s) / kSetPointS)));
  const double between_s = (to_s - from_s) / count;
  for (int i = 0; i < count; ++i) {
    const double at_s = from_s + i * between_s;
    FollowAsSet(InSteps(command, at_s), at_s, at_s + between_s);
  }
}

void Mechanics::FollowAsSet(const CubicCommand& command, double from_s, double to_s) {
  if (!of_axis_.empty()) {
    for (int axis = 0; axis < 3; ++axis) {
      Mechanics& own = of_axis_[static_cast<std::size_t>(axis)];
      own.Follow(command, from_s, to_s);
      actual_mm_[axis] = own.actual_mm_[axis];
    }
    return;
  }
  const Vec3 next = !loops_.empty() ? Loops(command, from_s, to_s)
                    : second_order_ ? SecondOrder(command, from_s, to_s)
                                    : FirstOrder(command, from_s, to_s);
  for (int axis = 0; axis < 3; ++axis) {
    if (stuck_[static_cast<std::size_t>(axis)]) {
      actual_mm_per_rad_[axis] = 0;
    } else {
      actual_mm_[axis] = next[axis];
    }
  }
}

Vec3 Mechanics::FirstOrder(const CubicCommand& command, double from_s,
                           double to_s) const {
  const double tau = lag_s_;
  const auto particular = [&](double s) {
    return Vec3(command.At(s) - tau * command.SpeedAt(s) +
                tau * tau * (2 * command.c2 + 6 * s * command.c3) -
                6 * tau * tau * tau * command.c3);
  };
  const double fade = tau > 0 ? std::exp(-(to_s - from_s) / tau) : 0;
  return particular(to_s) + fade * (actual_mm_ - particular(from_s));
}

Vec3 Mechanics::Loops(const CubicCommand& command, double from_s, double to_s) {
  Vec3 next;
  for (int axis = 0; axis < 3; ++axis) {
    LoopAxis& loop = loops_[static_cast<std::size_t>(axis)];
    if (stuck_[static_cast<std::size_t>(axis)]) {
      loop.Rest();
    } else {
      loop.Follow({command.p[axis], command.v[axis], command.c2[axis], command.c3[axis]},
                  from_s, to_s);
    }
    next[axis] = loop.actual();
  }
  return next;
}

void Mechanics::Step(double angle_rad) {
  if (angle_rad == step_rad_) return;
  Matrix6 m = Matrix6::Zero();
  m(0, 1) = 1;
  m(1, 0) = -1, m(1, 1) = -2 * second_order_->damping_ratio, m(1, 2) = 1;
  m(2, 3) = m(3, 4) = m(4, 5) = 1;
  step_ = Exponential(angle_rad * m).topRows<2>();
  step_rad_ = angle_rad;
}

Vec3 Mechanics::SecondOrder(const CubicCommand& command, double from_s, double to_s) {
  const double w = 2 * std::numbers::pi * second_order_->natural_frequency_hz;
  if (!(to_s > from_s)) return actual_mm_;
  Step(w * (to_s - from_s));
  Eigen::Matrix<double, 6, 3> y;
  y.row(0) = actual_mm_;
  y.row(1) = actual_mm_per_rad_;
  y.row(2) = command.At(from_s);
  y.row(3) = command.SpeedAt(from_s) / w;
  y.row(4) = (2 * command.c2 + 6 * from_s * command.c3) / (w * w);
  y.row(5) = 6 * command.c3 / (w * w * w);
  const Eigen::Matrix<double, 2, 3> next = step_ * y;
  actual_mm_per_rad_ = next.row(1);
  return next.row(0);
}

}  // namespace intaglio::virtual_engraver
