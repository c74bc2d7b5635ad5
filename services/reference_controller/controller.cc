#include "services/reference_controller/controller.h"

#include <algorithm>
#include <utility>

#include "engrave/core/try.h"

namespace intaglio::reference_controller {
namespace {

using std::chrono::nanoseconds;
using namespace std::chrono_literals;

// A lamp that was triggered has flashed by then, or does not.
constexpr nanoseconds kSyncWait = 500us;
// Between two reads of an input that is waited for.
constexpr nanoseconds kGlance = 1us;
// A lamp trigger that is later than this part of the period begins a new count of
// periods, for a lamp must not flash sooner.
constexpr int kLateShare = 10;

nanoseconds Microseconds(double us) {
  return nanoseconds(static_cast<std::int64_t>(1000 * us));
}

double Seconds(nanoseconds time) { return 1e-9 * static_cast<double>(time.count()); }

}  // namespace

Controller::Controller(const ControllerOptions& options, Pins& pins, ControllerTime time)
    : options_(options),
      pins_(pins),
      time_(std::move(time)),
      laser_(options.laser),
      next_tick_at_(time_.clock() + Period()) {}

void Controller::Plug(std::unique_ptr<link::ByteStream> end) {
  end_.Plug(std::move(end), time_.clock);
}

nanoseconds Controller::Period() const { return Microseconds(1e6 / laser_.rate_hz()); }

Result<nanoseconds> Controller::Turn() {
  auto idle = TryTurn();
  if (!idle) MakeSafe();
  return idle;
}

void Controller::MakeSafe() {
  laser_.EnterSafeState();
  for (int output = 0; output < kOutputCount; ++output)
    (void)pins_.Set(static_cast<Output>(output), false);
}

Result<nanoseconds> Controller::TryTurn() {
  INTAGLIO_TRY(ReadInputs());
  end_.Poll();
  end_.KeepSafe();
  INTAGLIO_TRY(WriteOutputs());
  const auto sync = INTAGLIO_TRY(AwaitTick());
  if (sync) INTAGLIO_TRY(PassTick(*sync));
  INTAGLIO_TRY(pins_.Set(Output::kLampTrigger, false));
  end_.SendOutcomes();
  end_.SendStatus(time_.clock(), false, virtual_engraver::kStatusPeriod);
  end_.line().Flush();
  // Sent data have to leave before the next wait.
  end_.Poll();
  return std::clamp(next_tick_at_ - kSpin - time_.clock(), nanoseconds(0), kIdle);
}

/// Returns whether the stage is in position.
Result<bool> Controller::ReadInputs() {
  const std::uint32_t levels = INTAGLIO_TRY(pins_.Levels());
  const auto on = [levels](Input input) { return (levels & BitOf(input)) != 0; };
  laser_.SetKey(on(Input::kKey));
  laser_.SetDoor(on(Input::kDoor));
  laser_.SetStopButton(!on(Input::kStop));
  for (int i = 0; i < laser_.accessories().input_count; ++i)
    laser_.SetInput(static_cast<std::size_t>(i), on(SpareInput(i)));
  return on(Input::kInPosition);
}

// The door is locked before a shutter opens, and until all are closed.
Status Controller::WriteOutputs() {
  const bool locked = laser_.door_locked();
  if (locked) INTAGLIO_TRY(pins_.Set(Output::kDoorLock, true));
  for (int channel = 0; channel < options_.laser.channels; ++channel) {
    const bool open = (laser_.shutters() >> channel & 1) != 0;
    INTAGLIO_TRY(pins_.Set(ShutterOutput(channel), open));
  }
  for (int i = 0; i < laser_.accessories().output_count; ++i)
    INTAGLIO_TRY(pins_.Set(SpareOutput(i), (laser_.accessories().on >> i & 1) != 0));
  INTAGLIO_TRY(pins_.Set(Output::kLamp, laser_.lamp_is_on()));
  if (!locked) INTAGLIO_TRY(pins_.Set(Output::kDoorLock, false));
  alive_ = !alive_;
  return pins_.Set(Output::kAlive, alive_);
}

Result<std::optional<nanoseconds>> Controller::AwaitTick() {
  if (pins_.Has(Output::kLampTrigger) || !pins_.Has(Input::kLampSync))
    return AwaitOwnTick();
  const nanoseconds now = time_.clock();
  const bool due = last_sync_ && now >= next_tick_at_ - kSpin;
  const auto sync = INTAGLIO_TRY(AwaitSync(due ? next_tick_at_ + kSpin : now));
  if (sync) {
    if (last_sync_ && *sync - *last_sync_ > Period() + Period() / kLateShare) LoseTime();
    next_tick_at_ = *sync + Period();
  } else if (time_.clock() >= next_tick_at_ + kSpin) {
    next_tick_at_ += Period();  // a flash was left out, or the lamp is cold
    LoseTime();
  }
  return sync;
}

Result<std::optional<nanoseconds>> Controller::AwaitOwnTick() {
  if (time_.clock() < next_tick_at_ - kSpin) return std::optional<nanoseconds>();
  INTAGLIO_TRY(HadEdge(Input::kLampSync));  // that no trigger of this controller has made
  time_.wait_until(next_tick_at_);
  // A cold lamp has no sync, and its ticks are counted all the same.
  const bool flashes = laser_.lamp_is_on();
  if (flashes) INTAGLIO_TRY(pins_.Set(Output::kLampTrigger, true));
  const nanoseconds began = time_.clock();
  const bool late = began - next_tick_at_ > Period() / kLateShare;
  if (late) LoseTime();
  next_tick_at_ = (late ? began : next_tick_at_) + Period();
  if (!flashes || !pins_.Has(Input::kLampSync)) return std::optional(began);
  const auto sync = INTAGLIO_TRY(AwaitSync(began + kSyncWait));
  if (!sync) LoseTime();
  return sync;
}

Result<std::optional<nanoseconds>> Controller::AwaitSync(nanoseconds until) {
  for (;;) {
    const auto sync = INTAGLIO_TRY(pins_.NextEdge(Input::kLampSync));
    const nanoseconds now = time_.clock();
    if (sync || now >= until) return sync;
    time_.wait_until(now + kGlance);
  }
}

// What the host knows of the stage's clock at the ticks is not right any more.
void Controller::LoseTime() { lost_time_at_ = laser_.tick(); }

std::uint64_t Controller::StaleTicks() const {
  constexpr std::uint64_t kMinSeen = 100, kOnTheWay = 50;
  return std::max(kMinSeen, static_cast<std::uint64_t>(laser_.rate_hz())) + kOnTheWay;
}

bool Controller::StageAgrees(nanoseconds sync) {
  if (!options_.stage) return true;
  const StageWitness stage = options_.stage();
  if (std::exchange(run_, stage.runs) != stage.runs) run_began_at_ = laser_.tick();
  return sync <= stage.in_position_until &&
         (!lost_time_at_ || run_began_at_ > *lost_time_at_ + StaleTicks());
}

Status Controller::PassTick(nanoseconds sync) {
  if (!laser_.CountsSync()) return {};
  const bool stage_agrees = StageAgrees(sync);
  const bool in_position = INTAGLIO_TRY(ReadInputs()) && stage_agrees;
  const double late_s =
      last_sync_ ? Seconds(sync - *last_sync_) - 1 / laser_.rate_hz() : 0;
  last_sync_ = sync;
  const std::uint8_t channels = laser_.AdvanceTick(in_position, late_s);
  if (options_.on_tick) options_.on_tick({laser_.tick(), sync, laser_.rate_hz()});
  return channels == 0 ? Status() : Trigger(channels, sync);
}

Status Controller::Trigger(std::uint8_t channels, nanoseconds sync) {
  INTAGLIO_TRY(Flashes());  // those of a light that is no pulse
  const link::PulseTiming& timing = laser_.timing();
  time_.wait_until(sync + Microseconds(timing.qswitch_delay_us));
  const double max_delay_us = options_.laser.signals.trigger_max_delay_us;
  if (time_.clock() > sync + Microseconds(max_delay_us)) {
    laser_.Withhold();
    return {};
  }
  INTAGLIO_TRY(pins_.Set(Output::kQSwitch, true));
  const nanoseconds fired = time_.clock();
  time_.wait_until(fired + Microseconds(timing.qswitch_width_us));
  INTAGLIO_TRY(pins_.Set(Output::kQSwitch, false));
  if (!pins_.Has(Input::kPhotosensor1)) {
    laser_.Unseen();
    return {};
  }
  time_.wait_until(fired + options_.sensor_window);
  const std::uint8_t seen = INTAGLIO_TRY(Flashes());
  laser_.Missed(static_cast<std::uint8_t>(channels & ~seen));
  return {};
}

/// Whether an input went on since the last call.
Result<bool> Controller::HadEdge(Input input) {
  for (bool had = false;; had = true) {
    const auto edge = INTAGLIO_TRY(pins_.NextEdge(input));
    if (!edge) return had;
  }
}

/// The channels whose photosensors have seen a flash since the last call.
Result<std::uint8_t> Controller::Flashes() {
  unsigned seen = 0;
  for (int channel = 0; channel < options_.laser.channels; ++channel) {
    const bool flashed = INTAGLIO_TRY(HadEdge(PhotosensorInput(channel)));
    if (flashed) seen |= 1U << channel;
  }
  return static_cast<std::uint8_t>(seen);
}

}  // namespace intaglio::reference_controller
