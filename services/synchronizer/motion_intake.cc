#include "services/synchronizer/motion_intake.h"

#include "services/platform/bus/samples.h"

namespace intaglio::synchronizer {
namespace {

using bus::View;

constexpr std::chrono::milliseconds kLease{500};
constexpr char kBridge[] = "motion bridge";

}  // namespace

MotionIntake::MotionIntake(bus::Bus& bus, const std::string& cell)
    : states_(bus, bus::kMotionState, cell),
      positions_(bus, bus::kPositionReport, cell) {}

void MotionIntake::Receive(PermissionIntake& permission,
                           const drivers::LaserController& laser,
                           std::chrono::nanoseconds now) {
  states_.TakeAll(
      [&](const intaglio_MotionState& sample, const bus::SampleOrigin& origin) {
        view_.answers = origin.alive;
        if (!origin.alive) return;
        received_at_ = now;
        view_.tick = sample.tick;
        view_.position_mm = Vec3(sample.x_mm, sample.y_mm, sample.z_mm);
        view_.run = sample.run;
        view_.highest_run = sample.highest_run;
        view_.covered_through_tick = sample.covered_through_tick;
        view_.at_rest = sample.at_rest;
        view_.fault = sample.fault;
        view_.message = View(sample.message);
        view_.clock = sample.clock;
        view_.position_tolerance_um = sample.position_tolerance_um;
        view_.has_block_stage = sample.has_block_stage;
        view_.block_mm = Vec2(sample.block_x_mm, sample.block_y_mm);
        permission.ReceiveHeld(kBridge, View(sample.bus_stops));
      });
  view_.fresh = received_at_.count() >= 0 && now - received_at_ < kLease;
  if (!view_.fresh) permission.ReceiveHeld(kBridge, {});
  ReceivePositions(laser);
}

void MotionIntake::ReceivePositions(const drivers::LaserController& laser) {
  const ClockPair pair{view_.clock, laser.identity().power_up, laser.status().rate_hz};
  if (laser.up() && pair.rate_hz > 0 && pair != clock_pair_) {
    clock_pair_ = pair;
    clock_from_tick_ = laser.status().tick;
    clock_.Reset(pair.rate_hz);
  }
  positions_.Take([this](const intaglio_PositionReport& report) {
    if (report.clock == 0 || report.clock != clock_pair_.motion) return;
    std::uint64_t tick = report.first_tick;
    for (const std::uint64_t at_ns : View(report.at_ns)) {
      if (tick > clock_from_tick_) clock_.Observe(tick, at_ns);
      ++tick;
    }
  });
}

EngravingInputs MotionIntake::InputsWith(const GrantInputs& grant) {
  EngravingInputs inputs;
  static_cast<GrantInputs&>(inputs) = grant;
  inputs.motion = view_;
  if (view_.clock != 0) inputs.motion_clock = &clock_;
  return inputs;
}

}  // namespace intaglio::synchronizer
