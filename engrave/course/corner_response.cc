#include "engrave/course/corner_response.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

// The residue of 1 / (s^2 D(s)) at the pole p of 1 / D is 1 / (p^2 D'(p)), where D'(p) =
// d_n times the product of p - q over the other poles q.

namespace intaglio::course {
namespace {

using Complex = std::complex<double>;

std::vector<Complex> ResiduesOf(const AxisDynamics& axis) {
  const auto& poles = axis.poles();
  std::vector<Complex> residues;
  for (std::size_t i = 0; i < poles.size(); ++i) {
    Complex derivative = axis.product().back();
    for (std::size_t k = 0; k < poles.size(); ++k)
      if (k != i) derivative *= poles[i] - poles[k];
    residues.push_back(1.0 / (poles[i] * poles[i] * derivative));
  }
  return residues;
}

class Corner {
 public:
  Corner(const AxisPair& axes, const Vec2& before, const Vec2& behind)
      : axes_(axes), before_(before), behind_(behind) {
    for (std::size_t i = 0; i < 2; ++i) residues_[i] = ResiduesOf(axes[i]);
  }

  Vec2 At(double t_s) const {
    Vec2 point;
    for (int i = 0; i < 2; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double u = t_s > 0 ? behind_[i] : before_[i];
      point[i] = u * (t_s - axes_[k].lag_s());
      if (t_s > 0) point[i] += (behind_[i] - before_[i]) * TailOf(k, t_s);
    }
    return point;
  }
  double OneSided(double t_s) const {
    const Vec2 p = At(t_s);
    return std::min(FromLeg(p, before_, -1), FromLeg(p, behind_, 1));
  }
  double FromNode(double t_s) const { return At(t_s).norm(); }

  /// Until the slowest pole has died out.
  double end_s() const {
    double slowest = 1e300, lag_s = 0;
    for (const AxisDynamics& axis : axes_) {
      lag_s = std::max(lag_s, axis.lag_s());
      for (const Complex& p : axis.poles()) slowest = std::min(slowest, -p.real());
    }
    return std::min(14 / slowest, 120 * lag_s);
  }

 private:
  double TailOf(std::size_t axis, double t_s) const {
    double sum = 0;
    for (std::size_t k = 0; k < residues_[axis].size(); ++k)
      sum += (residues_[axis][k] * std::exp(axes_[axis].poles()[k] * t_s)).real();
    return sum;
  }
  /// `side`: -1 of the leg that ends at the corner, 1 of the one that begins there.
  static double FromLeg(const Vec2& p, const Vec2& direction, double side) {
    if (side * direction.dot(p) < 0) return p.norm();
    return std::abs(direction.x() * p.y() - direction.y() * p.x());
  }

  const AxisPair& axes_;
  Vec2 before_, behind_;
  std::array<std::vector<Complex>, 2> residues_;
};

constexpr int kSamples = 1500, kNarrowings = 4, kFine = 40;

/// The greatest value of f on lo..hi: samples, then narrower around the best three.
template <typename F>
double Maximum(const F& f, double lo, double hi) {
  std::array<double, kSamples + 1> value{};
  const double step = (hi - lo) / kSamples;
  for (int i = 0; i <= kSamples; ++i)
    value[static_cast<std::size_t>(i)] = f(lo + step * i);
  double best = value[0];
  for (int rank = 0; rank < 3; ++rank) {
    const auto top = std::max_element(value.begin(), value.end());
    double from = lo + step * (static_cast<double>(top - value.begin()) - 1);
    double width = 2 * step;
    *top = -1e300;
    for (int pass = 0; pass < kNarrowings; ++pass) {
      double at = from, found = -1e300;
      for (int i = 0; i <= kFine; ++i) {
        const double t = std::clamp(from + width * i / kFine, lo, hi);
        if (const double x = f(t); x > found) {
          found = x;
          at = t;
        }
      }
      best = std::max(best, found);
      from = at - width / kFine;
      width = 2 * width / kFine;
    }
  }
  return best;
}

}  // namespace

CornerError CornerResponse(const AxisPair& axes, const Vec2& before, const Vec2& behind) {
  const Corner corner(axes, before, behind);
  const double end_s = corner.end_s();
  const double lag_s = std::max(axes[0].lag_s(), axes[1].lag_s());
  if (end_s <= 0) return {};
  CornerError error;
  error.one_sided_s =
      std::max(0.0, Maximum([&](double t) { return corner.OneSided(t); }, 0, end_s));
  error.node_miss_s = -Maximum([&](double t) { return -corner.FromNode(t); }, -2 * lag_s,
                               std::min(end_s, 8 * lag_s));
  return error;
}

double CircleError(const AxisPair& axes, double rate_rad_s) {
  std::array<Complex, 2> response;
  for (std::size_t i = 0; i < 2; ++i) {
    Complex denominator = 0, power = 1;
    for (const double d : axes[i].product()) {
      denominator += d * power;
      power *= Complex(0, rate_rad_s);
    }
    response[i] = 1.0 / denominator;
  }
  // Opposite points of the circle have the same error.
  constexpr int kAngles = 90;
  double worst = 0;
  for (int k = 0; k < kAngles; ++k) {
    const Complex turn = std::polar(1.0, std::numbers::pi * k / kAngles);
    const double radius =
        std::hypot((response[0] * turn).real(), (response[1] * turn).imag());
    worst = std::max(worst, std::abs(radius - 1));
  }
  return worst;
}

}  // namespace intaglio::course
