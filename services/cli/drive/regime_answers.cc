#include "services/cli/drive/regime_answers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/drive/continuous_axis.h"
#include "engrave/drive/two_axes.h"
#include "services/cli/drive/simulate_options.h"

namespace intaglio::cli {
namespace {

// The source's circle and corner (4.6, 4.7); a move at full speed for a tenth of a
// second.
constexpr double kRegimeRadius_m = 0.03, kRegimeSpeed_m_s = 2.0 / 60;
constexpr double kCornerLeg_m = 0.01, kCornerAcceleration_m_s2 = 1.5;
constexpr double kAtSpeed_s = 0.1, kRestOfRegime_s = 0.3;
/// Within it a move has come to rest.
constexpr double kSettled_m = 10e-6;

drive::SampledAxis AxisWith(const DriveProfile& profile, const NamedLoops& loops,
                            int axis) {
  drive::SampledAxis sampled = SampledAxisOf(profile, profile.axes(axis), kSimulatedRule);
  sampled.loop = loops.loops[static_cast<std::size_t>(axis)];
  return sampled;
}

double LargestAcceleration(const DriveProfile& profile) {
  double largest_m_s2 = 0;
  for (const drive::DemandPhase& phase : DemandOf(profile))
    largest_m_s2 = std::max(largest_m_s2, std::abs(phase.acceleration_m_s2));
  return largest_m_s2 > 0 ? largest_m_s2 : kCornerAcceleration_m_s2;
}

void AddRapid(const DriveProfile& profile, const NamedLoops& loops, int axis,
              RegimeAnswer& answer) {
  const drive::SampledAxis sampled = AxisWith(profile, loops, axis);
  const double speed = profile.max_speed_m_s(), a = LargestAcceleration(profile);
  const auto pieces =
      drive::Trapezoid(speed * speed / a + speed * kAtSpeed_s, speed, a, kRestOfRegime_s);
  const auto setpoints = drive::SampleCommand(pieces, sampled.period_s);
  const auto run = drive::Simulate(sampled, setpoints);
  if (!run) return;
  RapidAnswer& rapid = *answer.add_rapid();
  rapid.set_axis(profile.axes(axis).name());
  rapid.set_static_error_um(1e6 * run->back().following_error_m);
  std::size_t settled = run->size();
  while (settled > 0 && std::abs((*run)[settled - 1].following_error_m) <= kSettled_m)
    --settled;
  const double end_s =
      static_cast<double>(setpoints.size() - 1) * sampled.period_s - kRestOfRegime_s;
  rapid.set_settles(settled < run->size());
  rapid.set_settling_ms(
      1e3 * std::max(0.0, static_cast<double>(settled) * sampled.period_s - end_s));
}

}  // namespace

std::vector<RegimeAnswer> AnswersOf(const DriveProfile& profile,
                                    const NamedLoops& loops) {
  std::vector<RegimeAnswer> answers(1);
  answers[0].set_regime("rapid");
  for (int axis = 0; axis < profile.axes_size(); ++axis)
    AddRapid(profile, loops, axis, answers[0]);
  if (profile.axes_size() >= 2) {
    const drive::TwoAxes axes = {AxisWith(profile, loops, 0),
                                 AxisWith(profile, loops, 1)};
    RegimeAnswer circle, corner;
    circle.set_regime("circle");
    if (const auto run =
            drive::SimulateCircle(axes, {kRegimeRadius_m, kRegimeSpeed_m_s, 2})) {
      circle.set_simulated(true);
      circle.set_outside_um(1e6 * run->settled_outside_m);
      circle.set_inside_um(1e6 * run->settled_inside_m);
    }
    corner.set_regime("corner");
    if (const auto run = drive::SimulateCorner(
            axes, {kCornerLeg_m, kRegimeSpeed_m_s, kCornerAcceleration_m_s2,
                   std::numbers::pi / 2, false, kRestOfRegime_s})) {
      corner.set_simulated(true);
      corner.set_outside_um(1e6 * run->outside_m);
      corner.set_inside_um(1e6 * run->inside_m);
    }
    answers.push_back(circle);
    answers.push_back(corner);
  }
  answers[0].set_simulated(answers[0].rapid_size() == profile.axes_size());
  for (RegimeAnswer& answer : answers) answer.set_gains(loops.gains);
  return answers;
}

std::string AnswerText(const RegimeAnswer& answer) {
  std::string text = fmt::format("{:<8} {:<8} ", answer.regime(), answer.gains());
  if (!answer.simulated()) return text + "NOT STABLE\n";
  for (const RapidAnswer& rapid : answer.rapid()) {
    text += fmt::format("{}{}: {:.4g} um left", &rapid == &answer.rapid(0) ? "" : "; ",
                        rapid.axis(), rapid.static_error_um());
    text += rapid.settles() ? fmt::format(", within {:g} um after {:.3g} ms",
                                          1e6 * kSettled_m, rapid.settling_ms())
                            : fmt::format(", never within {:g} um", 1e6 * kSettled_m);
  }
  if (answer.rapid().empty()) {
    text += fmt::format("{:.4g} um outside, {:.4g} um inside of the path at most",
                        answer.outside_um(), answer.inside_um());
  }
  return text + "\n";
}

}  // namespace intaglio::cli
