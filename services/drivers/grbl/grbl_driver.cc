#include "services/drivers/grbl/grbl_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "services/job/machine/laser_setting.h"

namespace intaglio::drivers {
namespace {

link::ExpectedDevice ExpectedOf(const MachineSpec& machine) {
  const SerialLine& line = machine.motion_line();
  return {line.serial_number(), "controller", machine.name(), line.device(),
          "motion_line"};
}

}  // namespace

GrblDriver::GrblDriver(const MachineSpec& machine, link::StreamOpener open,
                       link::SteadyClock clock)
    : LockstepDriver(machine, clock, "grbl"),
      line_(std::move(open), std::move(clock), ExpectedOf(machine)),
      laser_(machine.laser()) {
  pieces().SetTravel(TravelOf(machine));
  if (const auto energies = EnergiesOf(laser_)) {
    identity_.min_energy_mj = energies->min_mj;
    identity_.max_energy_mj = energies->max_mj;
  }
}

void GrblDriver::TakeAnswers() {
  std::vector<GrblLine::Event> events;
  line_.Poll(events);
  TakePowerUps();
  for (const GrblLine::Event& event : events) Receive(event);
}

void GrblDriver::Receive(const GrblLine::Event& event) {
  if (std::holds_alternative<GrblUp>(event)) return TakeUp();
  if (std::holds_alternative<GrblLost>(event)) return TakeLost();
  if (std::holds_alternative<GrblOk>(event)) return TakeOk();
  if (const auto* status = std::get_if<GrblStatus>(&event)) return TakeStatus(*status);
  if (const auto* alarm = std::get_if<GrblAlarm>(&event)) return TakeAlarm(*alarm);
  if (std::holds_alternative<GrblHomed>(event)) return TakeHomed();
  if (std::holds_alternative<GrblHeld>(event)) {
    return Halt(intaglio_MOTION_SAFE_STATE,
                "the controller was on hold: check the block, then resume");
  }
  if (const auto* refused = std::get_if<GrblNotSetUp>(&event)) {
    return Halt(intaglio_MOTION_SAFE_STATE, WhyGrblIsNotSetUp(refused->code));
  }
  // What follows in its buffer goes on; a hold keeps it until the reset of ClearFault.
  if (!homing_) line_.SendRealtime('!');
  Halt(intaglio_MOTION_SAFE_STATE, "the controller refused a line: " +
                                       TextOfGrblError(std::get<GrblError>(event).code) +
                                       "; check its version, then resume");
}

void GrblDriver::TakeAlarm(const GrblAlarm& alarm) {
  constexpr int kHomeReset = 6;
  if (std::exchange(stopped_home_, false) && alarm.code == kHomeReset) return;
  if (line_.traits().homing) state_.homed = false;
  const bool limit = alarm.code == 1 || alarm.code == 2;
  Halt(limit ? intaglio_MOTION_LIMIT : intaglio_MOTION_SAFE_STATE,
       TextOfGrblAlarm(alarm.code));
}

void GrblDriver::TakeHomed() {
  homing_ = home_sent_ = false;
  state_.homed = true;
  program_.ForgetModes();
  quiet_at_ = now();
}

void GrblDriver::StopHoming() {
  line_.Reset();
  homing_ = home_sent_ = false;
  stopped_home_ = true;
  quiet_at_ = now();
}

void GrblDriver::TakeUp() {
  const GrblTraits& traits = line_.traits();
  program_.SetController(traits.steps_per_mm, traits.max_power);
  program_.ForgetModes();
  identity_.serial_number = traits.serial_number;
  BeginSession(
      "the line to the controller was lost in a run, and the controller has "
      "executed what it had: resume");
  commanded_open_ = open_ = stopped_home_ = false;
  state_.homed = !(line_.traits().homing && line_.place_is_lost());
}

bool GrblDriver::IsIdentified() const {
  return status_number_ > 0 && (state_.link_up || IsSetUp());
}

bool GrblDriver::IsGivenOut() const {
  return LockstepDriver::IsGivenOut() && program_.pulse_tick() == 0;
}

bool GrblDriver::HasRecovered() const {
  const bool waits_for_home = line_.locked() && line_.traits().homing;
  return (line_.takes_lines() && grbl_.state == GrblState::kIdle) || waits_for_home;
}

void GrblDriver::BeginProgram(std::uint64_t start_tick) {
  program_.Begin(start_tick, state_.position_mm);
}

void GrblDriver::TakeStatus(const GrblStatus& status) {
  const bool door = status.state == GrblState::kDoor;
  if (!halted_ && (door || status.state == GrblState::kHold)) {
    Halt(intaglio_MOTION_SAFE_STATE,
         door ? "the safety door opened: close it, check the block, then resume"
              : "the controller is on hold: check the block, then resume",
         door ? StoppedBy::kChain : StoppedBy::kController);
  }
  // Locked at the beginning of a session: since its power-up, or an alarm of before.
  const bool locked = status.state == GrblState::kAlarm;
  const bool homes = line_.traits().homing;
  if (locked && homes && status_number_ == 0) state_.homed = false;
  if (locked && state_.homed && state_.fault == intaglio_MOTION_OK) {
    Halt(intaglio_MOTION_SAFE_STATE,
         "the controller is locked by an alarm: home it or check its zero, then resume");
  }
  state_.homed = state_.homed && !(locked && homes);
  grbl_ = status;
  TakeProgress();
  state_.position_mm = *status.work_mm;
  UpdateReach();
  WatchJog();
  ++status_number_;
  ++state_.number;
  status_at_ = now();
}

// What left the planner has been executed.
void GrblDriver::TakeProgress() {
  const bool all_acknowledged = std::all_of(
      in_flight_.begin(), in_flight_.end(),
      [](const InFlight& one) { return one.acknowledged || !one.move.has_line; });
  if (grbl_.state == GrblState::kIdle && all_acknowledged) {
    Executed(in_flight_.size());
  } else if (grbl_.free_blocks >= 0) {
    const auto acknowledged = static_cast<int>(
        std::count_if(in_flight_.begin(), in_flight_.end(), [](const InFlight& one) {
          return one.acknowledged && one.what == InFlight::What::kMove &&
                 one.move.has_line;
        }));
    const int queued = line_.traits().planner_blocks - grbl_.free_blocks;
    Executed(static_cast<std::size_t>(std::max(0, acknowledged - queued)));
  }
}

void GrblDriver::WatchJog() {
  if (!jog_ || jog_->cancelled) return;
  std::size_t left = 0, unanswered = 0;
  for (const InFlight& one : in_flight_) {
    if (one.what != InFlight::What::kMove) continue;
    ++left;
    if (!one.acknowledged) ++unanswered;
  }
  jog_moves_.TakeStatus(grbl_, left, unanswered);
  if (jog_moves_.was_cut()) Halt(intaglio_MOTION_SAFE_STATE, WhyGrblJogWasCut());
}

// The controller counts its steps; another place than the program's is a lost line or
// another host.
void GrblDriver::CheckPlace() {
  if (!state_.at_rest || !std::exchange(checks_place_, false)) return;
  state_.following_error_max_um =
      (state_.position_mm - program_.place_mm()).norm() * 1000;
  if (IsSameGrblPlace(state_.position_mm, program_.place_mm(),
                      line_.traits().steps_per_mm))
    return;
  SetFault(
      intaglio_MOTION_FOLLOWING_ERROR,
      fmt::format("the controller ended {:.3f} mm from where the run ends: check its "
                  "zero, then resume",
                  state_.following_error_max_um / 1000));
}

void GrblDriver::Report() {
  LockstepDriver::Report();
  state_.place_lost =
      line_.place_is_lost() && !line_.traits().homing
          ? WhyGrblPlaceIsLost(
                "drive the focus to the block's corner and say so (`intaglio teach "
                "zero`)")
          : "";
  CheckPlace();
}

// The S of the window's pulses, by their ticks.
Status GrblDriver::SetEnergy(const link::ArmWindow& window) {
  if (auto energy = CheckEnergy(identity_, window); !energy) return energy;
  if (std::ranges::find(window.fire, true) == window.fire.end()) return {};
  const double power_ratio = LaserSettingFor(laser_, window.pulse_energy_mj).value_or(1);
  program_.SetPowerRatio(window.first_tick, power_ratio);
  return {};
}

Status GrblDriver::Jog(const Vec3& axes, double speed_mm_s) {
  if (up() && state_.fault == intaglio_MOTION_OK && !line_.takes_lines())
    return Fail(ErrorCode::kRefused, "the stage is not at rest");
  auto begun = LockstepDriver::Jog(axes, speed_mm_s);
  if (!begun) return begun;
  is_dark_ = false;
  jog_moves_.Begin(jog_->from_mm, line_.traits().steps_per_mm);
  quiet_at_ = now();
  return {};
}

Status GrblDriver::Home() {
  if (up() && !line_.traits().homing) {
    return Fail(ErrorCode::kRefused,
                "the controller does not home: $22 is 0; set $22=1 if its axes have "
                "switches");
  }
  auto begun = LockstepDriver::Home();
  if (begun) is_dark_ = false;
  return begun;
}

Status GrblDriver::SetZero(const Vec3& here_mm, const std::array<bool, 3>& sets) {
  if (!up()) return Down();
  if (!here_mm.allFinite() || std::ranges::find(sets, true) == sets.end()) {
    return Fail(ErrorCode::kInvalidValue,
                "a zero needs numbers, and one of the axes x, y and z at least");
  }
  if (!state_.at_rest || state_.fault != intaglio_MOTION_OK || !line_.takes_lines()) {
    return Fail(ErrorCode::kRefused,
                state_.message.empty() ? "the stage is not at rest" : state_.message);
  }
  zero_ = {here_mm, sets};
  wanted_open_ = is_dark_ = false;
  state_.at_rest = false;
  return {};
}

std::unique_ptr<MotionDriver> MakeGrblDriver(const MachineSpec& machine,
                                             link::StreamOpener open,
                                             link::SteadyClock clock) {
  return std::make_unique<GrblDriver>(machine, std::move(open), std::move(clock));
}

}  // namespace intaglio::drivers
