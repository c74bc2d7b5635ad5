#include "engrave/drive/linear_drive.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>
#include <utility>

#include "engrave/core/check.h"

// In the drive's own time, whose unit a_n^(1/n) makes the highest coefficient 1, the
// states of the observer form (Kailath, Linear Systems, 1980, ch. 2.1) are
//   z1 = x,  zi' = z(i+1) - a(n-i) x + b(n-i) c,  z(n+1) = 0.
// No derivative of the command is in it, so a command that jumps needs no care. On the
// settled course q each state is a cubic, z(i+1) = zi' + a(n-i) q - b(n-i) c. The rest e
// = z - z(q) obeys the same equation without a command: e(t) = exp(A t) e(0). Only what
// decays is in the exponential, so nothing cancels, however long the step.
//
// Lead, of a course that brakes with A. Without zeros the command is p + f1 p' + f2 p'',
// see second_order.cc. With one zero less than poles, and one, the command is p + a1 p' +
// a2 p'' behind a lag, and a lag does not go beyond what it follows. With two and an
// integrator (a1 = b1, a2 = b2) it is p + G p'' with G = a3 s / (1 + b1 s + b2 s^2),
// whose step response rises once to below a3 / b1 and comes back to 0, or swings with the
// damping b1 / (2 sqrt b2) from at most a3 / sqrt b2. Twice the sum of its peaks is its
// variation, which times A bounds it. Poles beyond the third are delays of a controller,
// which the inverse leaves to the prediction.

namespace intaglio::drive {
namespace {

constexpr int kMaxStates = static_cast<int>(kMaxOrder);
using Matrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxStates, kMaxStates>;
using StateVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxStates, 1>;

/// The cubic in a time whose unit is `unit_s`.
Cubic InTimeOf(const Cubic& c, double unit_s) {
  return {c.position_u, c.velocity_u_s * unit_s, c.acceleration_u_s2 * unit_s * unit_s,
          c.jerk_u_s3 * unit_s * unit_s * unit_s};
}

/// f(s) applied to a cubic.
Cubic Applied(const std::array<double, 4>& f, const Cubic& to) {
  const std::array<double, 4> of = {to.position_u, to.velocity_u_s, to.acceleration_u_s2,
                                    to.jerk_u_s3};
  std::array<double, 4> out = {};
  for (std::size_t k = 0; k < out.size(); ++k) {
    for (std::size_t j = 0; k + j < of.size(); ++j) out[k] += f[j] * of[k + j];
  }
  return {out[0], out[1], out[2], out[3]};
}

/// z' + a q - b c.
Cubic NextState(const Cubic& z, double a, const Cubic& q, double b, const Cubic& c) {
  return {z.velocity_u_s + a * q.position_u - b * c.position_u,
          z.acceleration_u_s2 + a * q.velocity_u_s - b * c.velocity_u_s,
          z.jerk_u_s3 + a * q.acceleration_u_s2 - b * c.acceleration_u_s2,
          a * q.jerk_u_s3 - b * c.jerk_u_s3};
}

Matrix ExponentialOf(const Polynomial& a, std::size_t order, double duration) {
  const auto n = static_cast<Eigen::Index>(order);
  Matrix matrix = Matrix::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    matrix(i, 0) = -a[order - 1 - static_cast<std::size_t>(i)];
    if (i + 1 < n) matrix(i, i + 1) = 1;
  }
  matrix *= duration;
  return matrix.exp();
}

/// exp(A t). Steps of a plan last whole ticks, a few of them: the newest of each slot is
/// kept, and what is kept has the bits of what would be computed anew.
const Matrix& Decay(const Polynomial& a, std::size_t order, double duration) {
  struct Kept {
    Polynomial a = {};
    std::size_t order = 0;
    double duration = 0;
    Matrix decay;
  };
  thread_local std::array<Kept, 32> slots;
  const std::size_t hash = std::hash<double>()(duration) ^ std::hash<double>()(a[1]);
  Kept& slot = slots[(hash ^ hash >> 17 ^ hash >> 41) % slots.size()];
  if (slot.order != order || slot.duration != duration || slot.a != a)
    slot = {a, order, duration, ExponentialOf(a, order, duration)};
  return slot.decay;
}

}  // namespace

LinearDrive::LinearDrive(std::string name, const Transfer& transfer)
    : name_(std::move(name)),
      transfer_(transfer),
      order_(OrderOf(transfer.denominator)),
      a_(transfer.denominator),
      b_(transfer.numerator) {
  Require(order_ >= 1 && OrderOf(b_) < order_,
          "a drive of order {} cannot have a numerator of order {}", order_, OrderOf(b_));
  Require(a_[0] == 1 && b_[0] == 1, "the polynomials begin with {} and {} in place of 1",
          b_[0], a_[0]);
  unit_s_ = std::pow(a_[order_], 1 / static_cast<double>(order_));
  double power = 1;
  for (std::size_t k = 0; k <= order_; ++k, power *= unit_s_) {
    a_[k] /= power;
    b_[k] /= power;
  }
  a_[order_] = 1;
}

Cubic LinearDrive::Settled(const Cubic& command) const {
  return Applied(SeriesOf(transfer_.numerator, transfer_.denominator), command);
}

Cubic LinearDrive::CommandFor(const Cubic& course) const {
  return Applied(SeriesOf(transfer_.denominator, transfer_.numerator), course);
}

LinearDrive::States LinearDrive::SettledStates(const Cubic& command) const {
  const Cubic c = InTimeOf(command, unit_s_);
  States states;
  states[0] = Applied(SeriesOf(b_, a_), c);
  for (std::size_t i = 1; i < order_; ++i) {
    const std::size_t power = order_ - i;
    states[i] = NextState(states[i - 1], a_[power], states[0], b_[power], c);
  }
  return states;
}

AxisState LinearDrive::SettledState(const Cubic& command) const {
  const States states = SettledStates(command);
  AxisState state{states[0].position_u, states[0].velocity_u_s / unit_s_};
  for (std::size_t i = 1; i < order_; ++i) state.inner[i - 1] = states[i].position_u;
  return state;
}

AxisState LinearDrive::Follow(const AxisState& state, const Cubic& command,
                              double duration_s) const {
  const States settled = SettledStates(command);
  const auto n = static_cast<Eigen::Index>(order_);
  StateVector rest(n);
  rest[0] = state.position_u - settled[0].position_u;
  for (std::size_t i = 1; i < order_; ++i)
    rest[static_cast<Eigen::Index>(i)] = state.inner[i - 1] - settled[i].position_u;
  const double duration = duration_s / unit_s_;
  if (!rest.isZero(0)) rest = (Decay(a_, order_, duration) * rest).eval();
  AxisState next;
  next.position_u = settled[0].At(duration) + rest[0];
  const double slope = (n > 1 ? rest[1] : 0) - a_[order_ - 1] * rest[0];
  next.velocity_u_s = (settled[0].VelocityAt(duration) + slope) / unit_s_;
  for (std::size_t i = 1; i < order_; ++i)
    next.inner[i - 1] = settled[i].At(duration) + rest[static_cast<Eigen::Index>(i)];
  return next;
}

double LinearDrive::lead_s2() const {
  const Polynomial& a = transfer_.denominator;
  const Polynomial& b = transfer_.numerator;
  const bool lags = order_ == OrderOf(b) + 1;
  if (lags && OrderOf(b) == 1) return 0.5 * a[1] * a[1] + a[2];
  if (OrderOf(b) == 2 && a[1] == b[1] && a[2] == b[2]) {
    const double damping = b[1] / (2 * std::sqrt(b[2]));
    if (damping >= 1) return 2 * a[3] / b[1];
    const double ratio =
        std::exp(-std::numbers::pi * damping / std::sqrt(1 - damping * damping));
    return 2 * a[3] / std::sqrt(b[2]) / (1 - ratio);
  }
  const auto f = SeriesOf(a, b);
  const double forward = std::max(f[1], 0.0);
  return 0.5 * forward * forward + std::abs(f[2]);
}

}  // namespace intaglio::drive
