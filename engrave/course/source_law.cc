#include "engrave/course/source_law.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/course/corner_response.h"

namespace intaglio::course {
namespace {

constexpr double kCurveTurnRad = 20 * std::numbers::pi / 180;

/// The greatest speed on a circle whose settled error is within the tolerance: the error
/// is R g(v / R), g from CircleError, made ascending.
class CurveLimit {
 public:
  CurveLimit(const AxisPair& axes, double tolerance_mm) : tolerance_mm_(tolerance_mm) {
    constexpr int kRates = 100;
    constexpr double kFirstRate = 0.01;
    const double last = axes[0].parameters().bandwidth_rad_s;
    double worst = 0;
    for (int i = 0; i < kRates; ++i) {
      const double rate = kFirstRate * std::pow(last / kFirstRate, i / (kRates - 1.0));
      worst = std::max(worst, CircleError(axes, rate));
      rate_rad_s_.push_back(rate);
      error_.push_back(worst);
    }
  }

  double SpeedFor(double radius_mm) const {
    const double allowed = tolerance_mm_ / radius_mm;
    const auto above = std::upper_bound(error_.begin(), error_.end(), allowed);
    if (above == error_.begin()) return radius_mm * rate_rad_s_.front();
    if (above == error_.end()) return radius_mm * rate_rad_s_.back();
    const auto i = static_cast<std::size_t>(above - error_.begin());
    const double share = (allowed - error_[i - 1]) / (error_[i] - error_[i - 1]);
    return radius_mm *
           (rate_rad_s_[i - 1] + share * (rate_rad_s_[i] - rate_rad_s_[i - 1]));
  }

 private:
  double tolerance_mm_;
  std::vector<double> rate_rad_s_, error_;
};

}  // namespace

double SourceCornerError(double turn_rad, double slow_damping_ratio,
                         double natural_1_rad_s, double natural_2_rad_s) {
  const double f1 = turn_rad < std::numbers::pi / 2 ? std::abs(std::sin(turn_rad)) : 1;
  return f1 * (std::abs(slow_damping_ratio - 0.25) + 0.25) *
         (1.5 * std::abs(1 / natural_1_rad_s - 1 / natural_2_rad_s) +
          1 / (2 * CommonBandwidth(natural_1_rad_s, natural_2_rad_s)));
}

std::vector<double> SourceNodeSpeeds(const Path& path, const AxisPair& axes,
                                     const SourceLawOptions& options) {
  const auto& first = axes[0].parameters();
  const auto& second = axes[1].parameters();
  const double xi = first.natural_rad_s <= second.natural_rad_s ? first.damping_ratio
                                                                : second.damping_ratio;
  const double allowed_mm = options.tolerance_mm * options.allowance_ratio;
  const CurveLimit curve(axes, allowed_mm);
  std::vector<double> limits;
  for (std::size_t node = 1; node + 1 < path.node_count(); ++node) {
    const double turn_rad = std::abs(path.TurnAt(node));
    double limit =
        allowed_mm / std::max(SourceCornerError(turn_rad, xi, first.natural_rad_s,
                                                second.natural_rad_s),
                              1e-12);
    const Segment& before = path.segments()[node - 1];
    const Segment& behind = path.segments()[node];
    // An arc turns by half of its sweep up to each of its ends.
    const double bent_rad =
        turn_rad + (std::abs(before.sweep_rad) + std::abs(behind.sweep_rad)) / 2;
    if (options.limit_curves && bent_rad > 1e-9 && turn_rad < kCurveTurnRad) {
      const double radius_mm = (before.length_mm + behind.length_mm) / 2 / bent_rad;
      limit = std::min(limit, curve.SpeedFor(std::min(radius_mm, 1e5)));
    }
    limits.push_back(limit);
  }
  return limits;
}

}  // namespace intaglio::course
