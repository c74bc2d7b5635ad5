#include "services/reference_controller/measure_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "engrave/core/try.h"
#include "services/reference_controller/exact_time.h"
#include "services/reference_controller/simulated_stage.h"

namespace intaglio::reference_controller {
namespace {

using std::chrono::nanoseconds;

link::JogMove ToX(double x_mm, const Vec3& from_mm, double speed_mm_s) {
  const auto nm = [](double mm) {
    return static_cast<std::int32_t>(std::lround(1e6 * mm));
  };
  return {nm(x_mm), nm(from_mm.y()), nm(from_mm.z()),
          static_cast<std::uint32_t>(1e6 * speed_mm_s)};
}

/// The periods of a way without what accelerates and brakes at its ends.
void AddPeriods(const std::vector<nanoseconds>& steps, double ramp_steps,
                std::vector<double>& periods_us) {
  const auto ramp = static_cast<std::size_t>(std::ceil(ramp_steps)) + 1;
  for (std::size_t i = ramp + 1; i + ramp < steps.size(); ++i)
    periods_us.push_back(1e-3 * static_cast<double>((steps[i] - steps[i - 1]).count()));
}

}  // namespace

Result<StepJitter> MeasureSteps(StageControllerOptions options, double seconds,
                                const ControllerTime& time,
                                const std::function<bool()>& stops) {
  StepJitter jitter;
  const double steps_per_mm = options.steps.steps_per_mm.x();
  jitter.speed_mm_s = options.stage.max_speed_mm_s.x();
  jitter.period_us = 1e6 / (jitter.speed_mm_s * steps_per_mm);
  const double acceleration_mm_s2 = options.stage.brake_acceleration_mm_s2 / 10;
  const double ramp_mm = jitter.speed_mm_s * jitter.speed_mm_s / (2 * acceleration_mm_s2);
  SimulatedStageOptions pins_options{options.steps, *options.stage.homing};
  pins_options.at_mm = virtual_engraver::StartMm(options.stage);
  options.stage.homing.reset();  // it is where it begins
  jitter.limit_mm = std::exchange(options.stage.following_error_limit_mm,
                                  std::numeric_limits<double>::infinity());
  std::vector<nanoseconds> steps;
  SimulatedStage pins(pins_options, time.clock, [&steps](const Edge& edge) {
    if (edge.output == Output::kStepX && edge.on) steps.push_back(edge.at);
  });
  StageController controller(options, pins, time);
  virtual_engraver::Stage& stage = controller.stage();
  std::vector<double> periods_us;
  const nanoseconds end =
      time.clock() + nanoseconds(static_cast<std::int64_t>(1e9 * seconds));
  TurnWait turns(time);
  bool to_max = true, was_late = false;
  while (time.clock() < end && !stops()) {
    if (!stage.running()) {
      AddPeriods(steps, ramp_mm * steps_per_mm, periods_us);
      steps.clear();
      const Vec3& goal_mm =
          to_max ? options.stage.travel_max_mm : options.stage.travel_min_mm;
      stage.Jog(ToX(goal_mm.x(), pins_options.at_mm, jitter.speed_mm_s));
      to_max = !to_max;
    }
    const auto idle = INTAGLIO_TRY(controller.Turn());
    const double behind_mm = stage.Report().following_error_max_nm / 1e6;
    jitter.behind_mm = std::max(jitter.behind_mm, behind_mm);
    const bool is_late = behind_mm > jitter.limit_mm;
    if (!std::exchange(was_late, is_late) && is_late) ++jitter.stops;
    turns.WaitFor(idle);
  }
  AddPeriods(steps, ramp_mm * steps_per_mm, periods_us);
  if (periods_us.empty())
    return Fail(ErrorCode::kRefused, "too few steps came to measure them");
  jitter.period = SpreadOf(std::move(periods_us));
  return jitter;
}

std::string ToText(const StepJitter& jitter) {
  return TextOfSpreads({{"step period", jitter.period}}) +
         fmt::format(
             "{:.2f} us are commanded, {} mm/s along x; steps were {:.3f} mm late at "
             "most, and {} times more than following_error_limit_mm, {}: the stage would "
             "have stopped\n",
             jitter.period_us, jitter.speed_mm_s, jitter.behind_mm, jitter.stops,
             jitter.limit_mm);
}

}  // namespace intaglio::reference_controller
