// What the synchronizer receives of permission, emergency stops and motion, and how it
// watches the machine while there is no path yet.

#include <algorithm>

#include "services/cell/pause_reason.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/process/log.h"
#include "services/synchronizer/cell_names.h"
#include "services/synchronizer/synchronizer.h"

namespace intaglio::synchronizer {
namespace {

using bus::View;
using namespace std::chrono_literals;

// Permission is written every 20 ms; one or two lost samples are no withdrawal yet.
constexpr auto kPermissionLease = 90ms;
constexpr auto kMotionLease = 500ms;

}  // namespace

void Synchronizer::TakePermission(std::chrono::nanoseconds now) {
  permissions_.TakeAll(
      [&](const intaglio_Permission& sample, const bus::SampleOrigin& o) {
        if (!o.alive) {
          permission_granted_ = false;
          (void)stop_.TakeHeld("job service", {});
          return;
        }
        permission_at_ = now;
        permission_granted_ = sample.granted;
        permission_epoch_ = sample.epoch;
        permission_grant_ = {sample.grant, sample.renewal};
        first_point_ = sample.first_point;
        fire_uncertain_ = sample.fire_uncertain;
        permission_job_ = View(sample.job_uid);
        speed_percent_ = std::clamp(sample.speed_percent, 1u, 140u);
        if (stop_.TakeHeld("job service", View(sample.bus_stops)))
          NoteStop("job service", "it holds a press");
      });
  stops_.Take([this](const intaglio_EmergencyStop& stop) {
    if (stop_.Take(stop)) NoteStop(View(stop.operator_name), View(stop.reason));
  });
  SendStop();
}

void Synchronizer::NoteStop(std::string_view source, std::string_view reason) {
  stop_came_ = true;
  host::LogWarning("emergency stop by {}: {}", source, reason);
}

// The controller keeps it latched by itself, over the end of this process, too.
void Synchronizer::SendStop() {
  if (!stop_.pressed()) {
    stop_sent_session_ = 0;
  } else if (stop_sent_session_ != laser_.session() && laser_.CanSend() &&
             laser_.Stop()) {
    stop_sent_session_ = laser_.session();
  }
}

void Synchronizer::TakeMotion(std::chrono::nanoseconds now) {
  motion_.Take([&](const intaglio_MotionState& sample) {
    motion_at_ = now;
    motion_view_.tick = sample.tick;
    motion_view_.position_mm = Vec3(sample.x_mm, sample.y_mm, sample.z_mm);
    motion_view_.run = sample.run;
    motion_view_.highest_run = sample.highest_run;
    motion_view_.covered_through_tick = sample.covered_through_tick;
    motion_view_.at_rest = sample.at_rest;
    motion_view_.fault = sample.fault;
    motion_view_.message = View(sample.message);
    motion_view_.clock = sample.clock;
    motion_view_.position_tolerance_um = sample.position_tolerance_um;
    if (stop_.TakeHeld("motion bridge", View(sample.bus_stops)))
      NoteStop("motion bridge", "it holds a press");
  });
  motion_view_.fresh = motion_at_.count() >= 0 && now - motion_at_ < kMotionLease;
  if (!motion_view_.fresh) (void)stop_.TakeHeld("motion bridge", {});
}

void Synchronizer::TakePositions() {
  const ClockPair pair{motion_view_.clock, laser_.identity().power_up,
                       laser_.status().rate_hz};
  if (laser_.up() && pair.rate_hz > 0 && pair != clock_pair_) {
    clock_pair_ = pair;
    clock_from_tick_ = laser_.status().tick;
    motion_clock_.Reset(pair.rate_hz);
  }
  positions_.Take([this](const intaglio_PositionReport& report) {
    if (report.clock == 0 || report.clock != clock_pair_.motion) return;
    std::uint64_t tick = report.first_tick;
    for (const std::uint64_t at_ns : View(report.at_ns)) {
      if (tick > clock_from_tick_) motion_clock_.Observe(tick, at_ns);
      ++tick;
    }
  });
}

void Synchronizer::WatchMachine(std::chrono::nanoseconds now) {
  const EngravingInputs inputs = InputsAt(now);
  const ChainLinks links = LinksOf(inputs, laser_, 0);
  if (!job_) return chain_.Watch(links, now);
  (void)chain_.Turn(links, now);
  const std::string other_device = OtherDevice(inputs, laser_);
  if (!other_device.empty()) chain_.Latch(false);
  if (inputs.grant.number == 0 || !chain_.has_lost(inputs.grant)) return;
  publisher_.PublishTask(
      {.job_uid = job_->job_uid(),
       .attempt = attempt_,
       .state = intaglio_TASK_PAUSED,
       .pause_reason =
           other_device.empty() ? PauseReasonOf(chain_.spent_by()) : intaglio_PAUSE_FAULT,
       .message = other_device.empty() ? TextOf(chain_.spent_by())
                                       : other_device + ", then resume"},
      now);
}

EngravingInputs Synchronizer::InputsAt(std::chrono::nanoseconds now) {
  EngravingInputs inputs;
  inputs.now = now;
  inputs.permission_fresh =
      permission_at_.count() >= 0 && now - permission_at_ < kPermissionLease;
  const bool ours =
      job_ && permission_epoch_ == job_->epoch() && permission_job_ == job_->job_uid();
  inputs.permission_granted = permission_granted_ && ours;
  if (ours) {
    inputs.grant = permission_grant_;
    inputs.first_point = first_point_;
    inputs.fire_uncertain = fire_uncertain_;
  }
  inputs.stop_pressed = stop_.pressed() || stop_came_;
  inputs.speed_percent = ours ? speed_percent_ : 100;
  inputs.motion = motion_view_;
  if (motion_view_.clock != 0) inputs.motion_clock = &motion_clock_;
  return inputs;
}

}  // namespace intaglio::synchronizer
