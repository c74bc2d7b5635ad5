#include "services/drivers/isel/isel_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "services/drivers/power_up.h"

namespace intaglio::drivers {
namespace {

std::array<const AxisLimits*, 3> AxesOf(const MachineSpec& machine) {
  return {&machine.x(), &machine.y(), &machine.z()};
}

/// Why no controller is right for this profile; empty: it is whole.
std::string RefusalOf(const MachineSpec& machine) {
  if (!machine.motion_line().serial_number().empty()) {
    return "motion_line.serial_number: controllers of this family report none, so it "
           "cannot be compared: remove it";
  }
  if (machine.has_polar()) {
    return "polar: this family is driven with three linear axes alone: remove it";
  }
  const auto axes = AxesOf(machine);
  for (std::size_t i = 0; i < 3; ++i) {
    if (axes[i]->steps_per_mm() > 0) continue;
    return fmt::format(
        "{}.steps_per_mm: is missing; this family counts in steps: give "
        "the steps of a turn of the motor over the screw's pitch",
        std::string(1, "xyz"[i]));
  }
  return "";
}

}  // namespace

IselDriver::IselDriver(const MachineSpec& machine, link::StreamOpener open,
                       link::SteadyClock clock)
    : clock_(clock),
      line_(std::move(open), std::move(clock), RefusalOf(machine)),
      rate_hz_(machine.laser().rates_hz_size() > 0 ? machine.laser().rates_hz(0) : 100),
      warm_up_s_(machine.laser().warm_up_s()),
      rates_hz_(machine.laser().rates_hz().begin(), machine.laser().rates_hz().end()) {
  Box3 travel;
  Vec3 steps_per_mm = Vec3::Ones();
  const auto axes = AxesOf(machine);
  for (int i = 0; i < 3; ++i) {
    const AxisLimits& axis = *axes[static_cast<std::size_t>(i)];
    travel.min_mm[i] = axis.travel_min_mm();
    travel.max_mm[i] = axis.travel_max_mm();
    if (axis.steps_per_mm() > 0) steps_per_mm[i] = axis.steps_per_mm();
  }
  pieces_.SetTravel(travel);
  pieces_.SetStepsPerMm(steps_per_mm);
  identity_.power_up = DrawPowerUp();
  identity_.lockstep = true;
  identity_.rates_hz = rates_hz_;
  identity_.model = "isel";
  passed_at_ = now();
}

void IselDriver::Poll() { Turn(); }

void IselDriver::Poll(const ReportSink& sink, const PastSink& past) {
  Turn();
  if (!up()) return;
  for (const link::PulseReport& report : std::exchange(reports_, {})) sink(report);
  for (const link::PastReport& report : std::exchange(pasts_, {})) past(report);
}

void IselDriver::Turn() {
  std::vector<IselLine::Event> events;
  line_.Poll(events);
  if (line_.power_ups() != power_ups_) TakePowerUp();
  for (const IselLine::Event& event : events) Take(event);
  if (!line_.up()) return SetDown();
  TakeRecovery();
  PassTicks();
  Feed();
  PassTicks();
  CheckStarved();
  Report();
}

void IselDriver::Take(const IselLine::Event& event) {
  if (std::holds_alternative<IselUp>(event)) return TakeUp();
  if (std::holds_alternative<IselLost>(event)) return TakeLost();
  TakeReply(std::get<IselReply>(event));
}

// Another power-up of the controller: nothing of before counts.
void IselDriver::TakePowerUp() {
  if (power_ups_ != 0) {
    Forget();
    identity_.power_up = DrawPowerUp();
    ticks_ = {};
    reports_.clear();
    positions_.clear();
    ran_ = false;
    state_.run = 0;
    executed_through_ = 0;
    lamp_on_ = false;
  }
  power_ups_ = line_.power_ups();
}

void IselDriver::TakeUp() {
  state_.fault = ran_ ? intaglio_MOTION_SAFE_STATE : intaglio_MOTION_OK;
  state_.message =
      ran_ ? "the line to the controller was lost in a run: check the block, then resume"
           : "";
  ran_ = false;
  halted_ = clearing_ = leaving_safe_ = checks_place_ = false;
  wanted_open_ = knows_chain_ = asks_chain_ = false;
  status_number_ = 0;
  disarms_sent_ = status_.disarms_taken = 0;
  pasts_.clear();
  reports_.clear();
  next_question_ = {};
  TakePlace(line_.first_place());
}

void IselDriver::TakeLost() {
  ran_ = ran_ || run_ != Run::kNone;
  safe_ = true;
  Forget();
  reports_.clear();
  pasts_.clear();
}

void IselDriver::SetDown() {
  const bool refused = !line_.refusal().empty();
  if (state_.link_up || state_.message != line_.message()) ++state_.number;
  state_.link_up = false;
  state_.refusal = line_.refusal();
  state_.fault = refused ? intaglio_MOTION_WRONG_CONTROLLER : intaglio_MOTION_LINK_LOST;
  state_.message = refused ? line_.refusal() : "motion line: " + line_.message();
  status_.shutters_open = 0;
  passed_at_ = now();
}

void IselDriver::SetFault(intaglio_MotionFault fault, std::string why) {
  state_.fault = fault;
  state_.message = std::move(why);
  clearing_ = false;
  pieces_.Drop();
  if (run_ == Run::kWaits) EndRun();
  ++state_.number;
}

void IselDriver::Report() {
  if (jog_ && !move_ && (jog_->cancelled || jog_->sent_mm >= jog_->length_mm))
    jog_.reset();
  state_.link_up = status_number_ > 0;
  state_.tick = ticks_.tick();
  state_.covered_through_tick =
      run_ == Run::kNone ? executed_through_ : pieces_.covered_through_tick();
  state_.at_rest = run_ == Run::kNone && !jog_ && !homing_ && !move_ && !is_fired_;
  if (state_.at_rest) state_.velocity_mm_s.setZero();
  ReportLaser();
}

void IselDriver::ReportLaser() {
  for (auto& report : ticks_.TakeReports()) reports_.push_back(std::move(report));
  status_.tick = ticks_.tick();
  status_.machine_us =
      static_cast<std::uint64_t>(std::max<std::int64_t>(0, now().count() / 1000));
  status_.rate_hz = rate_hz_;
  status_.warm_ratio = WarmRatio();
  status_.interlocks = static_cast<std::uint8_t>(
      (!chain_open_ ? link::kKeyOn | link::kDoorClosed : 0) |
      (!chain_open_ && !stop_ ? link::kStopReleased : 0) |
      (lamp_on_ ? link::kLampOn : 0) | (WarmRatio() >= 1 ? link::kLampWarm : 0) |
      (safe_ ? link::kSafeState : 0));
  status_.shutters_open = wanted_open_ ? 1 : 0;
  status_.pulse_count = ticks_.pulse_count();
  status_.last_fired_tick = ticks_.last_fired_tick();
  status_.decided_through = ticks_.decided_through();
  status_.openings = openings_;
  if (!is_fired_) status_.disarms_taken = disarms_sent_;
}

Status IselDriver::Down() const {
  return Fail(ErrorCode::kLinkLost, line_.up() ? state_.message : line_.message());
}

Vec3 IselDriver::PlaceOf(const IselSteps& steps) const {
  return Vec3(steps[0], steps[1], steps[2]).array() / pieces_.steps_per_mm().array();
}

IselSteps IselDriver::StepsOf(const Vec3& place_mm) const {
  IselSteps steps{};
  for (int i = 0; i < 3; ++i) {
    const double wanted = std::round(place_mm[i] * pieces_.steps_per_mm()[i]);
    steps[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(
        std::clamp<double>(wanted, -kIselMaxSteps, kIselMaxSteps));
  }
  return steps;
}

std::vector<LatchedPositions> IselDriver::TakePositions() {
  return std::exchange(positions_, {});
}

Status IselDriver::BeginRun(std::uint32_t run, std::uint64_t start_tick, std::uint64_t) {
  if (!up()) return Down();
  if (state_.fault != intaglio_MOTION_OK)
    return Fail(ErrorCode::kRefused, "the fault lasts: " + state_.message);
  if (!state_.homed) {
    SetFault(intaglio_MOTION_SAFE_STATE,
             "the controller has no reference: home it (intaglio teach home), then "
             "resume");
    return {};
  }
  const bool busy = run_ != Run::kNone || jog_ || homing_ || move_;
  if (busy || start_tick <= ticks_.tick()) {
    SetFault(intaglio_MOTION_LATE,
             busy ? "the stage was not at rest at the beginning of the run"
                  : "the run reached the controller after its start tick");
    return {};
  }
  state_.run = run;
  aborted_ = false;
  run_ = Run::kWaits;
  start_tick_ = start_tick;
  executed_through_ = start_tick;
  pieces_.Begin(start_tick, state_.position_mm);
  return {};
}

std::size_t IselDriver::Room() const {
  if (!up()) return 0;
  // A run that ended by a fault takes what still comes, and does nothing of it.
  if (run_ == Run::kNone || state_.fault != intaglio_MOTION_OK) return kQueuedPieces;
  return kQueuedPieces - std::min(kQueuedPieces, pieces_.size());
}

Status IselDriver::Append(std::span<const motion::Segment> segments,
                          std::span<const std::uint64_t>) {
  if (!up()) return Down();
  if (segments.size() > Room())
    return Fail(ErrorCode::kRefused, "the queue of segments is full");
  if (run_ == Run::kNone || state_.fault != intaglio_MOTION_OK) return {};
  if (auto taken = pieces_.Append(segments, rate_hz_); !taken)
    SetFault(intaglio_MOTION_LIMIT, taken.error().message);
  return {};
}

Status IselDriver::AbortRun() {
  if (!up()) return Down();
  pieces_.Drop();
  aborted_ = true;
  if (!is_fired_) pulse_tick_ = 0;
  if (run_ == Run::kWaits) EndRun();
  return {};
}

Status IselDriver::Jog(const Vec3& axes, double speed_mm_s) {
  if (!up()) return Down();
  if (!state_.at_rest || state_.fault != intaglio_MOTION_OK || !state_.homed) {
    return Fail(ErrorCode::kRefused, !state_.homed ? "the controller has no reference: "
                                                     "home it (intaglio teach home)"
                                     : state_.message.empty() ? "the stage is not at rest"
                                                              : state_.message);
  }
  if (auto good = pieces_.Check(axes); !good) return good;
  wanted_open_ = false;
  jog_ = JogWay{state_.position_mm, axes, std::max(0.01, speed_mm_s),
                (axes - state_.position_mm).norm()};
  state_.at_rest = false;
  return {};
}

Status IselDriver::Home() {
  if (!up()) return Down();
  if (!state_.at_rest || state_.fault != intaglio_MOTION_OK) {
    return Fail(ErrorCode::kRefused,
                state_.message.empty() ? "the stage is not at rest" : state_.message);
  }
  wanted_open_ = false;
  homing_ = true;
  state_.at_rest = false;
  return {};
}

Status IselDriver::Hold() {
  if (!up()) return Down();
  if (homing_ && home_sent_) {
    line_.SendStop();
    return {};
  }
  homing_ = false;
  if (!jog_) return AbortRun();
  jog_->cancelled = true;
  return {};
}

Status IselDriver::ClearFault() {
  if (!up()) return Down();
  clearing_ = state_.fault != intaglio_MOTION_OK;
  return {};
}

std::unique_ptr<MotionDriver> MakeIselDriver(const MachineSpec& machine,
                                             link::StreamOpener open,
                                             link::SteadyClock clock) {
  return std::make_unique<IselDriver>(machine, std::move(open), std::move(clock));
}

}  // namespace intaglio::drivers
