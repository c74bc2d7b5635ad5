#include "services/cell/permission_intake.h"

#include <algorithm>

#include "services/platform/bus/samples.h"
#include "services/platform/host/process/log.h"

namespace intaglio::cell {
namespace {

using bus::View;

// Permission is written every 20 ms; one or two lost samples are no withdrawal yet.
constexpr std::chrono::milliseconds kLease{90};
constexpr std::uint32_t kMinSpeedPercent = 1, kMaxSpeedPercent = 140;
constexpr char kJobService[] = "job service";
constexpr std::chrono::nanoseconds kNever{-1};

}  // namespace

PermissionIntake::PermissionIntake(bus::Bus& bus, const std::string& cell)
    : permissions_(bus, bus::kPermission, cell), stops_(bus, bus::kEmergencyStop, cell) {}

void PermissionIntake::Receive(std::chrono::nanoseconds now) {
  stop_came_ = false;
  permissions_.TakeAll([&](const intaglio_Permission& sample,
                           const bus::SampleOrigin& origin) {
    if (!origin.alive) {
      granted_ = false;
      // The library ends the lease of a job service that it has not heard as if it had
      // gone, also when this process was the one that was stopped, and beside a sample
      // that has just come: the permission is late then, and not withdrawn.
      received_at_ = kNever;
      ReceiveHeld(kJobService, {});
      return;
    }
    received_at_ = now;
    granted_ = sample.granted;
    epoch_ = sample.epoch;
    grant_ = {sample.grant, sample.renewal};
    first_point_ = sample.first_point;
    fire_uncertain_ = sample.fire_uncertain;
    job_uid_ = View(sample.job_uid);
    speed_percent_ = std::clamp(sample.speed_percent, kMinSpeedPercent, kMaxSpeedPercent);
    ReceiveHeld(kJobService, View(sample.bus_stops));
  });
  stops_.Take([this](const intaglio_EmergencyStop& stop) {
    if (stop_.Receive(stop)) NoteStop(View(stop.operator_name), View(stop.reason));
  });
}

void PermissionIntake::ReceiveHeld(std::string_view listener,
                                   std::span<const intaglio_StopPress> presses) {
  if (stop_.TakeHeld(listener, presses)) NoteStop(listener, "it holds a press");
}

void PermissionIntake::NoteStop(std::string_view source, std::string_view reason) {
  stop_came_ = true;
  host::LogWarning("emergency stop by {}: {}", source, reason);
}

GrantInputs PermissionIntake::InputsFor(const std::string& job_uid, std::uint64_t epoch,
                                        std::chrono::nanoseconds now) const {
  GrantInputs inputs;
  inputs.now = now;
  inputs.permission_fresh = received_at_.count() >= 0 && now - received_at_ < kLease;
  inputs.stop_pressed = stopped();
  if (job_uid.empty() || epoch != epoch_ || job_uid != job_uid_) return inputs;
  inputs.permission_granted = granted_;
  inputs.grant = grant_;
  inputs.first_point = first_point_;
  inputs.fire_uncertain = fire_uncertain_;
  inputs.speed_percent = speed_percent_;
  return inputs;
}

}  // namespace intaglio::cell
