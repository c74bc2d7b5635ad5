#include "services/synchronizer/publisher.h"

#include "services/platform/bus/samples.h"

namespace intaglio::synchronizer {
namespace {

using bus::Borrow;
using formats::PointOutcome;
using namespace std::chrono_literals;

constexpr auto kPulsePeriod = 20ms;
// Whoever moves the stage by hand stops when what it has is older than 150 ms.
constexpr auto kInterlockPeriod = 50ms;
// A status in which only the time has passed.
constexpr auto kUnchangedPeriod = 100ms;
constexpr std::size_t kPulseBatch = 1024;

intaglio_PulseOutcome WireOutcome(PointOutcome outcome) {
  switch (outcome) {
    case PointOutcome::kMade:
      return intaglio_PULSE_MADE;
    case PointOutcome::kMissed:
      return intaglio_PULSE_MISSED;
    case PointOutcome::kUncertain:
      return intaglio_PULSE_UNCERTAIN;
    case PointOutcome::kSkipped:
    case PointOutcome::kLeftOut:
    case PointOutcome::kNone:
      break;
  }
  return intaglio_PULSE_SKIPPED;
}

}  // namespace

Publisher::Publisher(bus::Bus& bus, std::string cell, std::string instance)
    : cell_(std::move(cell)),
      pulses_(bus, bus::kPulseEventBatch, cell_),
      lamp_(bus, bus::kLampSync, cell_),
      interlocks_(bus, bus::kInterlock, cell_),
      reporter_(bus, std::move(instance)) {}

void Publisher::BeginJob(const std::string& job_uid) {
  job_uid_ = job_uid;
  pulse_number_ = 0;
  tick_.clear(), point_.clear(), outcome_.clear(), reason_.clear();
}

void Publisher::Add(const PulseResult& result) {
  tick_.push_back(result.tick);
  point_.push_back(result.point);
  outcome_.push_back(static_cast<std::uint8_t>(WireOutcome(result.outcome)));
  reason_.push_back(static_cast<std::uint8_t>(result.reason));
}

void Publisher::Flush(std::chrono::nanoseconds now, bool all) {
  if (tick_.empty() || (!all && tick_.size() < kPulseBatch && now < next_pulses_)) return;
  next_pulses_ = now + kPulsePeriod;
  intaglio_PulseEventBatch batch{};
  batch.job_uid = Borrow(job_uid_);
  batch.sequence_number = pulse_number_++;
  Borrow(batch.tick, tick_);
  Borrow(batch.point, point_);
  Borrow(batch.outcome, outcome_);
  Borrow(batch.reason, reason_);
  (void)pulses_.Write(batch);
  tick_.clear(), point_.clear(), outcome_.clear(), reason_.clear();
}

void Publisher::PublishLaser(const drivers::LaserController& laser,
                             const host::StopLatch& stop, std::chrono::nanoseconds now) {
  if (laser.up() && laser.status_number() != published_number_) {
    published_number_ = laser.status_number();
    PublishLampSync(laser, now);
  }
  const std::uint32_t interlocks =
      (laser.up()
           ? laser.status().interlocks | laser.status().shutters_open << 8 | 1u << 16
           : 0) |
      (stop.pressed() ? 1u << 17 : 0u);
  const drivers::Accessories& accessories = laser.accessories();
  if (interlocks != published_interlocks_ || stop.revision() != published_stop_ ||
      accessories != published_accessories_ || now >= next_interlock_) {
    published_interlocks_ = interlocks;
    published_stop_ = stop.revision();
    published_accessories_ = accessories;
    next_interlock_ = now + kInterlockPeriod;
    PublishInterlock(laser, stop, now);
  }
  reporter_.Turn(now);
}

void Publisher::PublishLampSync(const drivers::LaserController& laser,
                                std::chrono::nanoseconds now) {
  const link::LaserStatus& status = laser.status();
  link::LaserStatus newest = status;
  newest.tick = newest.machine_us = 0;
  if (newest == published_status_ && now < next_status_) return;
  published_status_ = newest;
  next_status_ = now + kUnchangedPeriod;
  intaglio_LampSync sample{};
  sample.cell = Borrow(cell_);
  sample.tick = status.tick;
  sample.machine_us = status.machine_us;
  sample.rate_hz = status.rate_hz;
  sample.warm_ratio = status.warm_ratio;
  sample.pulse_count = status.pulse_count;
  sample.last_fired_tick = status.last_fired_tick;
  (void)lamp_.Write(sample);
  reporter_.Update(sample);
}

void Publisher::PublishInterlock(const drivers::LaserController& laser,
                                 const host::StopLatch& stop,
                                 std::chrono::nanoseconds now) {
  intaglio_Interlock sample{};
  sample.bus_stop_pressed = stop.pressed();
  const auto held = host::WireOf(stop.held());
  Borrow(sample.bus_stops, held);
  sample.cell = Borrow(cell_);
  sample.laser_link_up = laser.up();
  sample.message = Borrow(laser.message());
  if (laser.up()) {
    sample.state_age_ms = bus::AgeMs(now - laser.status_at());
    sample.key_on = laser.Has(link::kKeyOn);
    sample.door_closed = laser.Has(link::kDoorClosed);
    sample.emergency_stop_released = laser.Has(link::kStopReleased);
    sample.lamp_on = laser.Has(link::kLampOn);
    sample.lamp_warm = laser.Has(link::kLampWarm);
    sample.safe_state = laser.Has(link::kSafeState);
    sample.door_locked = laser.Has(link::kDoorLocked);
    sample.shutters_open = laser.status().shutters_open;
    sample.open_input = Borrow(laser.accessories().open_input);
    sample.outputs_on = Borrow(laser.accessories().on_names);
  }
  (void)interlocks_.Write(sample);
  reporter_.Update(sample);
}

}  // namespace intaglio::synchronizer
