#include "services/reference_controller/measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "engrave/core/try.h"
#include "services/reference_controller/simulated_pins.h"

namespace intaglio::reference_controller {
namespace {

constexpr std::uint64_t kTicksAhead = 100;

/// Decides the next ticks, all to fire.
void ArmAhead(virtual_engraver::Laser& laser, double energy_mj) {
  const link::LaserStatus status = laser.Report();
  if (status.decided_through >= status.tick + kTicksAhead) return;
  link::ArmWindow window;
  window.first_tick = std::max(status.tick, status.decided_through) + 1;
  window.gated = false;
  window.fire.assign(kTicksAhead, true);
  window.pulse_energy_mj = energy_mj;
  laser.Decide(window);
}

}  // namespace

Result<Jitter> MeasureJitter(ControllerOptions options, double rate_hz, double seconds,
                             const ControllerTime& time,
                             const std::function<bool()>& stops) {
  if (!std::ranges::count(options.laser.rates_hz, rate_hz)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("--rate {}: is none of the board's rates_hz", rate_hz),
                fmt::format("{}", rate_hz));
  }
  options.laser.rates_hz = {rate_hz};
  options.laser.warm_up_s = 0;
  std::vector<Edge> edges;
  SimulatedPins pins({options.laser.channels}, time.clock,
                     [&edges](const Edge& edge) { edges.push_back(edge); });
  Controller controller(options, pins, time);
  controller.laser().SetLamp({true, rate_hz});
  controller.laser().SetShutters(1);
  const auto end =
      time.clock() + std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * seconds));
  while (time.clock() < end && !stops()) {
    ArmAhead(controller.laser(), options.laser.max_energy_mj);
    const auto idle = INTAGLIO_TRY(controller.Turn());
    if (idle.count() > 0) time.wait_until(time.clock() + idle);
  }
  controller.MakeSafe();
  // Before the first pulse the shutter opens.
  const auto fired = std::ranges::find(edges, Output::kQSwitch, &Edge::output);
  std::vector<Edge> measured(fired, edges.end());
  if (std::ranges::count(measured, Output::kLampTrigger, &Edge::output) >= 4)
    return JitterOf(measured);
  return Fail(ErrorCode::kRefused, "too few pulses came to measure them");
}

}  // namespace intaglio::reference_controller
