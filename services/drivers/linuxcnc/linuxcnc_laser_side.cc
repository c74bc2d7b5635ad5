// The LaserController of LinuxcncDriver.
#include <cmath>

#include "services/drivers/linuxcnc/linuxcnc_driver.h"

namespace intaglio::drivers {

using link::TickOutcome;

void LinuxcncDriver::Poll(const ReportSink& sink, const PastSink& past) {
  Turn();
  if (up()) ticks_.Deliver(status_.tick, sink, past);
}

TickOutcome LinuxcncDriver::OutcomeOf(const SentRow& row, const HalSample& sample) const {
  if (!row.decision.fire) return TickOutcome::kNotArmed;
  if (sample.Has(kHalLaser))
    return sample.Has(kHalFlash) ? TickOutcome::kFiredSeen : TickOutcome::kFiredUnseen;
  if (row.decision.interlocked || sample.arm != row.arm || !sample.Has(kHalLaserOk) ||
      !sample.Has(kHalMotionOk))
    return TickOutcome::kInterlocked;
  if (!sample.Has(kHalWarm)) return TickOutcome::kLampNotReady;
  if (!sample.Has(kHalShutter)) return TickOutcome::kShutterClosed;
  return TickOutcome::kNotInPosition;
}

void LinuxcncDriver::UpdateStatus(const HalSample& sample) {
  status_.rate_hz = 1 / tick_s();
  status_.warm_ratio = sample.Has(kHalWarm) ? 1 : 0;
  const auto bit = [&](HalFlags flag, link::InterlockBits as) {
    return static_cast<std::uint8_t>(sample.Has(flag) ? as : 0);
  };
  status_.interlocks = static_cast<std::uint8_t>(
      bit(kHalKey, link::kKeyOn) | bit(kHalDoor, link::kDoorClosed) |
      (session_.stopped() ? 0 : bit(kHalStopFree, link::kStopReleased)) |
      bit(kHalLamp, link::kLampOn) | bit(kHalWarm, link::kLampWarm) |
      (sample.Has(kHalLaserOk) ? 0 : link::kSafeState));
  status_.shutters_open = sample.Has(kHalShutter) ? 1 : 0;
  status_.pulse_count = sample.pulses;
  status_.last_fired_tick = ticks_.last_fired();
  status_.decided_through = ticks_.decided_through();
  status_.disarms_taken = sample.arm >= disarm_number_ ? disarms_ : disarms_ - 1;
  status_.openings = sample.openings + lost_places_;
  if (status_.tick == 0) status_.tick = sample.tick;
  ++status_number_;
  status_at_ = clock_();
}

bool LinuxcncDriver::disarmed() const {
  return up() && status_.disarms_taken == disarms_;
}

// Whole periods of a tick, 2 or more: a pulse ends with its period. 0: it has none.
std::uint32_t LinuxcncDriver::PeriodsOf(double rate_hz) const {
  if (!(rate_hz > 0)) return 0;
  const double periods = 1 / (rate_hz * period_s());
  const double whole = std::round(periods);
  if (whole < 2 || whole > kMaxPeriods || std::abs(periods - whole) > 1e-6 * whole)
    return 0;
  return static_cast<std::uint32_t>(whole);
}

Status LinuxcncDriver::Lamp(bool on, double rate_hz) {
  if (!up()) return LinkLost();
  const std::uint32_t periods = PeriodsOf(rate_hz);
  if (on && periods == 0)
    return Fail(ErrorCode::kInvalidValue,
                "laser.rates_hz: a rate under LinuxCNC is the servo rate divided by a "
                "whole number, 2 or more",
                std::to_string(rate_hz));
  if (periods != 0) {
    wanted_periods_ = periods;
    if (auto sent = session_.SetPeriods(periods); !sent) return sent;
  }
  return session_.SetLamp(on);
}

// The laser's latch is open, and no Reset is under way.
bool LinuxcncDriver::interlocked() const {
  const HalSample& newest = session_.newest();
  return newest.command >= reset_number_ && !newest.Has(kHalLaserOk);
}

Status LinuxcncDriver::OpenShutters(std::uint8_t mask) {
  if (!up()) return LinkLost();
  // Not in the safe state: HAL would open it with the next Reset; nor by hand.
  shutter_open_ = (mask & 1) != 0 && !interlocked() && !jog_in_flight_;
  return session_.SetShutter(shutter_open_);
}

// Rows of a tick are sent together, or its first one is: what it fires is settled.
std::uint64_t LinuxcncDriver::sent_through() const {
  return next_period_ == 0 ? next_tick_ - 1 : next_tick_;
}

Status LinuxcncDriver::Arm(const link::ArmWindow& window) {
  if (!up()) return LinkLost();
  if (auto one = CheckOnePulse(window); !one) return one;
  if (auto energy = CheckEnergy(identity_, window); !energy) return energy;
  ticks_.Arm(window, sent_through());
  if (interlocked()) ticks_.Interlock();
  return {};
}

Status LinuxcncDriver::Disarm() {
  if (!up()) return LinkLost();
  if (auto sent = session_.NextArm(); !sent) return sent;
  ticks_.Disarm(sent_through());
  disarm_number_ = session_.arm();
  ++disarms_;
  status_.disarms_taken = disarms_ - 1;
  return {};
}

Status LinuxcncDriver::Reset() {
  if (!up()) return LinkLost();
  shutter_open_ = false;
  // The gate wants both latches. A fault of the motion stays one until ClearFault.
  auto sent = session_.ResetLaser();
  if (sent && !session_.newest().Has(kHalMotionOk)) sent = session_.ResetMotion();
  reset_number_ = session_.number();
  return sent;
}

Status LinuxcncDriver::Stop() {
  if (!up()) return LinkLost();
  shutter_open_ = false;
  ticks_.Disarm(sent_through());
  if (auto sent = session_.NextArm(); !sent) return sent;
  return session_.SetStop(true);
}

// A status comes with every report of HAL's sampler, every 10 ms or so.
Status LinuxcncDriver::RequestStatus() { return up() ? Status() : LinkLost(); }

bool LinuxcncDriver::RequestPast(std::uint64_t first_tick, std::uint16_t count) {
  if (!up()) return false;
  ticks_.RequestPast(first_tick, count);
  return true;
}

}  // namespace intaglio::drivers
