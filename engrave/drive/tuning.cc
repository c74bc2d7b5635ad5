#include "engrave/drive/tuning.h"

#include <fmt/format.h>

#include <algorithm>

#include "engrave/core/check.h"
#include "engrave/core/geometry.h"
#include "engrave/drive/sampled_axis.h"

// The loop is tau s^2 + s + K, so zeta = 1 / (2 sqrt(K tau)). The derivative of a
// reference that is held for a period is a pulse of the speed: with the gain Vd in V s/m
// it asks for Vd F Ka / R amperes in every period (Tirnovean 2016, ch. 5, the circle with
// Kd = 1: 121 A), which has to fit between the current of the motion and the peak.

namespace intaglio::drive {
namespace {

// Ten samples in what the loop can bear: its phase turns by a few degrees.
constexpr double kPeriodMargin = 10;

double SpeedPerVolt(const TunedAxis& axis) {
  return axis.velocity.gain_rad_v_s * axis.lead_m / kTwoPi;
}

SampledAxis SampledOf(const TunedAxis& axis, const PositionLoop& loop, double period_s) {
  SampledAxis sampled;
  sampled.speed_per_volt = SpeedPerVolt(axis);
  sampled.velocity_time_s = axis.velocity.time_s;
  sampled.loop = loop;
  sampled.period_s = period_s;
  return sampled;
}

double LargestGain(const TunedAxis& axis, double damping_ratio) {
  return 1 / (4 * damping_ratio * damping_ratio * axis.velocity.time_s);
}

double StablePeriod(const TunedAxis& axis, double gain_per_s) {
  return LargestStablePeriod(SampledOf(axis, {gain_per_s / SpeedPerVolt(axis)}, 1));
}

double CommonGain(std::span<const TunedAxis> axes, const TuningDemand& demand) {
  double gain = LargestGain(axes.front(), demand.damping_ratio);
  for (const TunedAxis& axis : axes)
    gain = std::min(gain, LargestGain(axis, demand.damping_ratio));
  for (const TunedAxis& axis : axes) {
    while (StablePeriod(axis, gain) < kPeriodMargin * demand.period_s) gain /= 2;
  }
  return gain;
}

std::string FeedForwardReason(Regime regime) {
  switch (regime) {
    case Regime::kRapid:
      return "1 leaves no lag, so a move ends with its command";
    case Regime::kCircle:
      return "1 leaves no lag, so a circle keeps its radius";
    case Regime::kCorner:
      break;
  }
  return "1 leaves no lag, so an axis does not begin before the other has ended";
}

Advice PositionAdvice(const TunedAxis& axis, double gain, const TuningDemand& demand) {
  const double limit = LargestGain(axis, demand.damping_ratio);
  std::string reason =
      gain < limit ? fmt::format(
                         "as on the slowest axis or as fast as the controller samples: "
                         "unequal gains make an ellipse of a circle; {:.4g} 1/s would "
                         "have the damping {:g} here",
                         limit, demand.damping_ratio)
                   : fmt::format("1 / (4 zeta^2 tau) with zeta = {:g} and tau = {:.4g} s",
                                 demand.damping_ratio, axis.velocity.time_s);
  return {"position gain, 1/s", gain, limit, std::move(reason)};
}

Advice DerivativeAdvice(const TunedAxis& axis, const TuningDemand& demand) {
  Advice advice{"derivative gain, V s/m", 0, 0, ""};
  if (demand.references_are_held) {
    const double left_a = std::max(0.0, axis.peak_current_a - axis.moving_current_a);
    advice.limit = left_a / (demand.speed_m_s * axis.amplifier_a_per_v);
    advice.reason = fmt::format(
        "the damping needs none; references that jump ask for {:.4g} A per V s/m at "
        "{:.4g} m/s, and {:.4g} A are left",
        demand.speed_m_s * axis.amplifier_a_per_v, demand.speed_m_s, left_a);
  } else {
    advice.limit = axis.velocity.time_s / (demand.period_s * SpeedPerVolt(axis));
    advice.reason =
        "the damping needs none; beyond this the loop answers faster than it is sampled";
  }
  return advice;
}

}  // namespace

std::vector<Tuning> Tune(std::span<const TunedAxis> axes, const TuningDemand& demand) {
  Require(!axes.empty(), "no axis to tune");
  Require(demand.speed_m_s > 0 && demand.period_s > 0 && demand.damping_ratio > 0,
          "a demand of {} m/s, sampled every {} s, damping {}", demand.speed_m_s,
          demand.period_s, demand.damping_ratio);
  for (const TunedAxis& axis : axes) {
    Require(axis.lead_m > 0 && axis.velocity.time_s > 0 && axis.amplifier_a_per_v > 0,
            "axis {}: a lead of {} m, {} s and {} A/V", axis.name, axis.lead_m,
            axis.velocity.time_s, axis.amplifier_a_per_v);
  }
  const double gain = CommonGain(axes, demand);
  std::vector<Tuning> tunings;
  for (const TunedAxis& axis : axes) {
    Tuning tuning;
    tuning.axis = axis.name;
    tuning.loop = {gain / SpeedPerVolt(axis), 0, 1};
    tuning.servo = CloseAxis(axis.velocity, tuning.loop, axis.lead_m);
    tuning.following_lag_s = LagSeconds(tuning.servo);
    tuning.static_error_m = StaticError(tuning.servo, axis.load_acceleration_m_s2);
    tuning.largest_stable_period_s = StablePeriod(axis, gain);
    tuning.advice = {
        PositionAdvice(axis, gain, demand),
        DerivativeAdvice(axis, demand),
        {"feed-forward, of the perfect one", 1, 1, FeedForwardReason(demand.regime)}};
    tunings.push_back(std::move(tuning));
  }
  return tunings;
}

}  // namespace intaglio::drive
