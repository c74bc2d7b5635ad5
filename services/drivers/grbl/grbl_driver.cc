#include "services/drivers/grbl/grbl_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "services/drivers/power_up.h"

namespace intaglio::drivers {
namespace {

link::ExpectedDevice ExpectedOf(const MachineSpec& machine) {
  const SerialLine& line = machine.motion_line();
  return {line.serial_number(), "controller", machine.name(), line.device(),
          "motion_line"};
}

Box3 TravelOf(const MachineSpec& machine) {
  Box3 travel;
  const AxisLimits* axes[] = {&machine.x(), &machine.y(), &machine.z()};
  for (int i = 0; i < 3; ++i) {
    travel.min_mm[i] = axes[i]->travel_min_mm();
    travel.max_mm[i] = axes[i]->travel_max_mm();
  }
  return travel;
}

}  // namespace

GrblDriver::GrblDriver(const MachineSpec& machine, link::StreamOpener open,
                       link::SteadyClock clock)
    : clock_(clock),
      line_(std::move(open), std::move(clock), ExpectedOf(machine)),
      rate_hz_(machine.laser().rates_hz_size() > 0 ? machine.laser().rates_hz(0) : 100),
      warm_up_s_(machine.laser().warm_up_s()),
      rates_hz_(machine.laser().rates_hz().begin(), machine.laser().rates_hz().end()) {
  program_.SetTravel(TravelOf(machine));
  identity_.power_up = DrawPowerUp();
  identity_.lockstep = true;
  identity_.rates_hz = rates_hz_;
  identity_.model = "grbl";
  passed_at_ = now();
}

void GrblDriver::Poll() { Turn(); }

void GrblDriver::Poll(const ReportSink& sink, const PastSink& past) {
  Turn();
  if (!up()) return;
  for (const link::PulseReport& report : std::exchange(reports_, {})) sink(report);
  for (const link::PastReport& report : std::exchange(pasts_, {})) past(report);
}

void GrblDriver::Turn() {
  std::vector<GrblLine::Event> events;
  line_.Poll(events);
  if (line_.power_ups() != power_ups_) TakePowerUp();
  for (const GrblLine::Event& event : events) Take(event);
  if (!line_.up()) return SetDown();
  TakeRecovery();
  PassTicks();
  Feed();
  PassTicks();
  CheckStarved();
  Report();
}

void GrblDriver::TakeRecovery() {
  if (!clearing_ && !leaving_safe_) return;
  if (!line_.takes_lines() || grbl_.state != GrblState::kIdle) return Recover();
  if (std::exchange(halted_, false)) program_.ForgetModes();
  if (std::exchange(leaving_safe_, false)) safe_ = false;
  if (!std::exchange(clearing_, false)) return;
  state_.fault = intaglio_MOTION_OK;
  state_.message.clear();
  ++state_.number;
}

void GrblDriver::SetFault(intaglio_MotionFault fault, std::string why) {
  state_.fault = fault;
  state_.message = std::move(why);
  clearing_ = false;
  program_.Drop();
  if (run_ == Run::kWaits) EndRun();
  ++state_.number;
}

void GrblDriver::Take(const GrblLine::Event& event) {
  if (std::holds_alternative<GrblUp>(event)) return TakeUp();
  if (std::holds_alternative<GrblLost>(event)) return TakeLost();
  if (std::holds_alternative<GrblOk>(event)) return TakeOk();
  if (const auto* status = std::get_if<GrblStatus>(&event)) return TakeStatus(*status);
  if (const auto* alarm = std::get_if<GrblAlarm>(&event)) {
    const bool limit = alarm->code == 1 || alarm->code == 2;
    return Halt(limit ? intaglio_MOTION_LIMIT : intaglio_MOTION_SAFE_STATE,
                TextOfGrblAlarm(alarm->code));
  }
  // What follows in its buffer goes on; a hold keeps it until the reset of ClearFault.
  line_.SendRealtime('!');
  Halt(intaglio_MOTION_SAFE_STATE, "the controller refused a line: " +
                                       TextOfGrblError(std::get<GrblError>(event).code) +
                                       "; check its version, then resume");
}

// Another power-up of the controller: its position is lost, and nothing of before counts.
void GrblDriver::TakePowerUp() {
  if (power_ups_ != 0) {
    Forget();
    identity_.power_up = DrawPowerUp();
    ticks_ = {};
    reports_.clear();
    positions_.clear();
    run_ = Run::kNone;
    ran_ = false;
    state_.run = 0;
    checks_place_ = false;
    executed_through_ = committed_tick_ = 0;
    lamp_on_ = false;
  }
  power_ups_ = line_.power_ups();
}

void GrblDriver::TakeUp() {
  const GrblTraits& traits = line_.traits();
  program_.SetController(traits.steps_per_mm, traits.max_power);
  program_.ForgetModes();
  identity_.serial_number = traits.serial_number;
  state_.refusal.clear();
  state_.fault = ran_ ? intaglio_MOTION_SAFE_STATE : intaglio_MOTION_OK;
  state_.message =
      ran_ ? "the line to the controller was lost in a run, and the controller has "
             "executed what it had: resume"
           : "";
  ran_ = false;
  halted_ = clearing_ = leaving_safe_ = checks_place_ = false;
  wanted_open_ = commanded_open_ = open_ = false;
  status_number_ = 0;
  disarms_sent_ = status_.disarms_taken = 0;
  pasts_.clear();
  reports_.clear();
}

void GrblDriver::TakeLost() {
  ran_ = ran_ || run_ != Run::kNone;
  safe_ = true;
  Forget();
  reports_.clear();
  pasts_.clear();
}

void GrblDriver::SetDown() {
  const bool refused = !line_.refusal().empty();
  if (state_.link_up || state_.message != line_.message()) ++state_.number;
  state_.link_up = false;
  state_.refusal = line_.refusal();
  state_.fault = refused ? intaglio_MOTION_WRONG_CONTROLLER : intaglio_MOTION_LINK_LOST;
  state_.message = refused ? line_.refusal() : "motion line: " + line_.message();
  passed_at_ = now();
}

void GrblDriver::TakeStatus(const GrblStatus& status) {
  const bool door = status.state == GrblState::kDoor;
  if (!halted_ && (door || status.state == GrblState::kHold)) {
    Halt(intaglio_MOTION_SAFE_STATE,
         door ? "the safety door opened: close it, check the block, then resume"
              : "the controller is on hold: release it, then resume");
  }
  if (status.state == GrblState::kAlarm && state_.fault == intaglio_MOTION_OK) {
    Halt(intaglio_MOTION_SAFE_STATE,
         "the controller is locked by an alarm: home it or check its zero, then resume");
  }
  const bool all_acknowledged = std::all_of(
      in_flight_.begin(), in_flight_.end(),
      [](const InFlight& one) { return one.acknowledged || !one.move.has_line; });
  if (status.state == GrblState::kIdle && all_acknowledged) {
    Executed(in_flight_.size());
  } else if (status.free_blocks >= 0) {
    const auto acknowledged = static_cast<int>(
        std::count_if(in_flight_.begin(), in_flight_.end(), [](const InFlight& one) {
          return one.acknowledged && one.what == InFlight::What::kMove &&
                 one.move.has_line;
        }));
    const int queued = line_.traits().planner_blocks - status.free_blocks;
    Executed(static_cast<std::size_t>(std::max(0, acknowledged - queued)));
  }
  grbl_ = status;
  state_.position_mm = *status.work_mm;
  UpdateReach();
  ++status_number_;
  ++state_.number;
  status_at_ = now();
}

// The controller counts its steps; another place than the program's is a lost line or
// another host.
void GrblDriver::CheckPlace() {
  if (!state_.at_rest || !std::exchange(checks_place_, false)) return;
  const Vec3 steps = line_.traits().steps_per_mm;
  const double off = ((state_.position_mm - program_.place_mm()).array() * steps.array())
                         .abs()
                         .maxCoeff();
  // A status has three decimals.
  state_.following_error_max_um =
      (state_.position_mm - program_.place_mm()).norm() * 1000;
  if (off <= 1 + 0.0006 * steps.maxCoeff()) return;
  SetFault(
      intaglio_MOTION_FOLLOWING_ERROR,
      fmt::format("the controller ended {:.3f} mm from where the run ends: check its "
                  "zero, then resume",
                  state_.following_error_max_um / 1000));
}

void GrblDriver::Report() {
  const bool is_set_up = line_.takes_lines() || line_.locked();
  state_.link_up = status_number_ > 0 && (state_.link_up || is_set_up);
  state_.tick = ticks_.tick();
  state_.covered_through_tick =
      run_ == Run::kNone ? executed_through_ : program_.covered_through_tick();
  if (jog_ && in_flight_.empty() && grbl_.state == GrblState::kIdle &&
      status_at_ > quiet_at_ && (jog_->cancelled || jog_->sent_mm >= jog_->length_mm)) {
    jog_.reset();
  }
  state_.at_rest = run_ == Run::kNone && !jog_ && in_flight_.empty() && !pending_ &&
                   grbl_.at_rest() && status_at_ > quiet_at_;
  CheckPlace();
  if (state_.at_rest) state_.velocity_mm_s.setZero();
  for (auto& report : ticks_.TakeReports()) reports_.push_back(std::move(report));
  const bool chain = !line_.door_is_open();
  status_.tick = ticks_.tick();
  status_.machine_us =
      static_cast<std::uint64_t>(std::max<std::int64_t>(0, now().count() / 1000));
  status_.rate_hz = rate_hz_;
  status_.warm_ratio = WarmRatio();
  status_.interlocks = static_cast<std::uint8_t>(
      (chain ? link::kKeyOn | link::kDoorClosed : 0) |
      (chain && !stop_ ? link::kStopReleased : 0) | (lamp_on_ ? link::kLampOn : 0) |
      (WarmRatio() >= 1 ? link::kLampWarm : 0) | (safe_ ? link::kSafeState : 0));
  status_.shutters_open = open_ && wanted_open_ ? 1 : 0;
  status_.pulse_count = ticks_.pulse_count();
  status_.last_fired_tick = ticks_.last_fired_tick();
  status_.decided_through = ticks_.decided_through();
  status_.openings = line_.door_openings();
  if (unsettled_.empty() && !pending_) status_.disarms_taken = disarms_sent_;
}

Status GrblDriver::Down() const {
  return Fail(ErrorCode::kLinkLost, line_.up() ? state_.message : line_.message());
}

std::vector<LatchedPositions> GrblDriver::TakePositions() {
  return std::exchange(positions_, {});
}

Status GrblDriver::BeginRun(std::uint32_t run, std::uint64_t start_tick, std::uint64_t) {
  if (!up()) return Down();
  if (state_.fault != intaglio_MOTION_OK) {
    return Fail(ErrorCode::kRefused, "the fault lasts: " + state_.message);
  }
  const bool busy = run_ != Run::kNone || jog_ || !in_flight_.empty();
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
  planned_end_ = {};
  program_.Begin(start_tick, state_.position_mm);
  return {};
}

std::size_t GrblDriver::Room() const {
  if (!up()) return 0;
  // A run that ended by a fault takes what still comes, and does nothing of it.
  if (run_ == Run::kNone || state_.fault != intaglio_MOTION_OK) return kQueuedPieces;
  return kQueuedPieces - std::min(kQueuedPieces, program_.piece_count());
}

Status GrblDriver::Append(std::span<const motion::Segment> segments,
                          std::span<const std::uint64_t>) {
  if (!up()) return Down();
  if (segments.size() > Room()) {
    return Fail(ErrorCode::kRefused, "the queue of segments is full");
  }
  if (run_ == Run::kNone || state_.fault != intaglio_MOTION_OK) return {};
  if (auto taken = program_.Append(segments, rate_hz_); !taken) {
    SetFault(intaglio_MOTION_LIMIT, taken.error().message);
  }
  return {};
}

Status GrblDriver::AbortRun() {
  if (!up()) return Down();
  program_.Drop();
  aborted_ = true;
  if (run_ == Run::kWaits) EndRun();
  return {};
}

Status GrblDriver::Jog(const Vec3& axes, double speed_mm_s) {
  if (!up()) return Down();
  if (!state_.at_rest || state_.fault != intaglio_MOTION_OK || !line_.takes_lines()) {
    return Fail(ErrorCode::kRefused,
                state_.message.empty() ? "the stage is not at rest" : state_.message);
  }
  if (auto good = program_.Check(axes); !good) return good;
  wanted_open_ = false;
  jog_ = JogWay{state_.position_mm, axes, std::max(0.01, speed_mm_s),
                (axes - state_.position_mm).norm()};
  state_.at_rest = false;
  quiet_at_ = now();
  return {};
}

Status GrblDriver::Hold() {
  if (!up()) return Down();
  if (!jog_) return AbortRun();
  jog_->cancelled = true;
  return {};
}

Status GrblDriver::ClearFault() {
  if (!up()) return Down();
  if (state_.fault == intaglio_MOTION_OK) return {};
  clearing_ = true;
  Recover();
  return {};
}

std::unique_ptr<MotionDriver> MakeGrblDriver(const MachineSpec& machine,
                                             link::StreamOpener open,
                                             link::SteadyClock clock) {
  return std::make_unique<GrblDriver>(machine, std::move(open), std::move(clock));
}

}  // namespace intaglio::drivers
