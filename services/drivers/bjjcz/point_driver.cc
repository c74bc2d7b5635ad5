#include "services/drivers/bjjcz/point_driver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "services/drivers/bjjcz/board_profile.h"
#include "services/job/machine/laser_setting.h"

namespace intaglio::drivers {
namespace {

// From the axis' origin to the travel of z, so that an axis in its travel never reads
// what a fresh one does.
constexpr double kHomedMm = 1;
constexpr double kMinRamp_s = 0.001;

link::ExpectedDevice ExpectedPointBoard(const MachineSpec& machine) {
  const SerialLine& line = machine.motion_line();
  return {line.serial_number(), "board", machine.name(), line.device(), "motion_line"};
}

}  // namespace

BjjczPointDriver::BjjczPointDriver(const MachineSpec& machine,
                                   std::vector<LmcCommand> set_up, std::string broken,
                                   link::StreamOpener open, link::SteadyClock clock)
    : LockstepDriver(machine, clock, "bjjcz"),
      board_(machine.bjjcz_board()),
      steps_per_mm_(std::max(1e-3, machine.z().steps_per_mm())),
      z_mm_s_(machine.z().max_speed_mm_s()),
      z_ramp_s_(
          std::max(kMinRamp_s, machine.z().max_speed_mm_s() /
                                   std::max(1.0, machine.z().max_acceleration_mm_s2()))),
      z_settle_s_(machine.head_over_block().jump_and_dwell().z_settle_s()),
      z_origin_mm_(machine.z().travel_min_mm() - kHomedMm),
      broken_(std::move(broken)),
      line_(std::move(open), std::move(clock), ExpectedPointBoard(machine),
            std::move(set_up)),
      lists_(machine),
      laser_(machine.laser()) {
  if (const auto energies = EnergiesOf(laser_)) {
    identity_.min_energy_mj = energies->min_mj;
    identity_.max_energy_mj = energies->max_mj;
  }
  pieces_.SetTravel(TravelOf(machine));
  pieces_.SetStepsPerMm(Vec3(lists_.field().places_per_mm(),
                             lists_.field().places_per_mm(), steps_per_mm_));
}

std::int32_t BjjczPointDriver::StepsOf(double z_mm) const {
  constexpr double kMaxAxisSteps = 2e9;
  return static_cast<std::int32_t>(std::clamp(
      std::round((z_mm - z_origin_mm_) * steps_per_mm_), -kMaxAxisSteps, kMaxAxisSteps));
}

void BjjczPointDriver::TakeAnswers() {
  if (!broken_.empty()) return;
  std::vector<LmcAnswer> answers;
  const bool lost = line_.Poll(answers);
  if (lost) TakeLost();
  if (line_.sessions() != session_ && line_.up()) TakeUp();
  for (const LmcAnswer& answer : answers) Receive(answer);
}

void BjjczPointDriver::TakeUp() {
  session_ = line_.sessions();
  // The set-up of the session has ended what the board had.
  playing_.reset();
  axis_.reset();
  stopping_ = knows_inputs_ = knows_axis_ = closed_ = busy_ = moving_ = false;
  oscillates_ = false;
  asked_outputs_.reset();
  outputs_.reset();
  line_.Send({LmcOperation::kAxisPlace, {}});
}

void BjjczPointDriver::Receive(const LmcAnswer& answer) {
  busy_ = answer.reply.is_busy();
  moving_ = answer.reply.is_moving();
  if (playing_) playing_->Receive(answer, now());
  switch (answer.operation) {
    case LmcOperation::kReadPort:
      if (stopping_ && std::exchange(seen_since_stop_, true) && !busy_ && !moving_) {
        stopping_ = false;
        line_.Send({LmcOperation::kAxisPlace, {}});
      }
      return TakeInputs(answer.reply.numbers[1]);
    case LmcOperation::kWritePort:
      outputs_ = asked_outputs_;
      break;
    case LmcOperation::kAxisTo:
    case LmcOperation::kAxisOrigin:
      if (axis_) axis_->was_asked = true;
      break;
    case LmcOperation::kAxisPlace:
      return TakeAxisPlace(
          StepsOfAxisNumber(static_cast<std::uint32_t>(answer.reply.numbers[1]) << 16 |
                            answer.reply.numbers[2]));
    default:
      break;
  }
}

void BjjczPointDriver::TakeInputs(std::uint16_t inputs) {
  if (!knows_axis_) return;
  const bool was_closed =
      std::exchange(closed_, (inputs >> board_.door_input() & 1) != 0);
  const bool knew = std::exchange(knows_inputs_, true);
  ++state_.number;
  ++status_number_;
  status_at_ = now();
  CheckPlace();
  if (closed_ || (knew && !was_closed)) return;
  ++openings_;
  StopController();
  Halt(intaglio_MOTION_SAFE_STATE,
       "key, door or stop button is open: close them, check the block, then resume",
       StoppedBy::kChain);
}

void BjjczPointDriver::TakeAxisPlace(std::int32_t steps) {
  const std::int32_t before = std::exchange(axis_steps_, steps);
  state_.position_mm.z() = HeightOf(steps);
  if (!knows_axis_) TakeFirstAxisPlace(before);
  listed_mm_.z() = state_.position_mm.z();
  if (axis_ && axis_->asks_place) TakeEndOfMove(*std::exchange(axis_, std::nullopt));
}

void BjjczPointDriver::TakeEndOfMove(const AxisMove& move) {
  if (axis_steps_ != move.to_steps) {
    homing_ = home_sent_ = false;
    state_.homed = false;
    return SetFault(intaglio_MOTION_FOLLOWING_ERROR,
                    "the axis z of the board is not where it was sent: check "
                    "z.steps_per_mm and its limit switch, home it, then resume");
  }
  if (!move.is_to_origin) {
    homing_ = home_sent_ = false;
    return;
  }
  state_.homed = true;
  MoveAxis(StepsOf(pieces_.travel().min_mm.z()), z_mm_s_);
}

// Who lets go of it does not want the axis to go on. Where the search for the origin was
// ended nobody knows (FeedHome).
void BjjczPointDriver::StopHoming() {
  homing_ = home_sent_ = false;
  StopController();
  axis_.reset();
}

// A power cycle sets the axis to 0. It may have been on its way when the line was lost.
void BjjczPointDriver::TakeFirstAxisPlace(std::int32_t before) {
  const auto [low, high] = std::minmax(before, axis_to_steps_);
  const bool is_on_its_way = axis_steps_ >= low && axis_steps_ <= high;
  if (axis_steps_ == 0 || !is_on_its_way || session_ == 1) {
    TakePowerUps();
    lists_.SetCentred();
  }
  axis_to_steps_ = axis_steps_;
  BeginSession("the line to the board was lost in a run: check the block, then resume");
  knows_axis_ = true;
  state_.homed = axis_steps_ != 0 && (session_ == 1 || state_.homed);
  lists_.Drop();
  const Vec2 at_mm = lists_.at_mm();
  state_.position_mm.head<2>() = at_mm;
  listed_mm_ = state_.position_mm;
}

void BjjczPointDriver::CheckPlace() {
  if (!std::exchange(checks_place_, false)) return;
  state_.following_error_max_um = (state_.position_mm - end_mm_).norm() * 1000;
}

bool BjjczPointDriver::shutter_is_open() const {
  const auto bit = 1U << board_.gate_output();
  return wanted_open_ && outputs_ && (*outputs_ & WantedOutputs() & bit) != 0;
}

std::optional<std::uint64_t> BjjczPointDriver::FirstPulse() const {
  for (const Step& step : steps_) {
    if (step.pulse_tick != 0) return step.pulse_tick;
  }
  return std::nullopt;
}

std::uint64_t BjjczPointDriver::LimitedByPulses(std::uint64_t tick) const {
  const auto pulse = FirstPulse();
  if (pulse) tick = std::min(tick, *pulse - 1);
  if (held_ && held_->pulse && ticks_.fires(TickOf(held_->end_subticks)))
    tick = std::min(tick, TickOf(held_->end_subticks) - 1);
  return tick;
}

// The power of the window's pulses, by their ticks.
Status BjjczPointDriver::SetEnergy(const link::ArmWindow& window) {
  if (auto energy = CheckEnergy(identity_, window); !energy) return energy;
  if (std::ranges::find(window.fire, true) == window.fire.end()) return {};
  powers_.Set(window.first_tick,
              LaserSettingFor(laser_, window.pulse_energy_mj).value_or(1));
  pulses_.Set(window.first_tick, window.pulses_per_point);
  return {};
}

void BjjczPointDriver::BeginProgram(std::uint64_t start_tick) {
  lists_.BeginRun();
  LockstepDriver::BeginProgram(start_tick);
}

// A list that the board has not begun is not played any more.
void BjjczPointDriver::DropProgram() {
  LockstepDriver::DropProgram();
  held_.reset();
  if (playing_ && playing_->was_sent()) return;
  if (playing_) line_.DropWaiting();
  playing_.reset();
  lists_.Drop();
  steps_.clear();
  listed_mm_.head<2>() = state_.position_mm.head<2>();
}

void BjjczPointDriver::EndRun() {
  end_mm_ = state_.position_mm;
  LockstepDriver::EndRun();
}

// Its pulses are uncertain: the board may be playing it.
std::uint64_t BjjczPointDriver::ForgetSent() {
  std::uint64_t last = 0;
  const bool was_sent = playing_ && playing_->was_sent();
  for (const Step& step : steps_) {
    if (!was_sent || step.pulse_tick == 0) continue;
    ticks_.Settle(step.pulse_tick, link::TickOutcome::kNoLongerKnown);
    last = std::max(last, step.pulse_tick);
  }
  if (was_sent) {
    // It was played to its end, or stopped; the next list begins with a jump.
    lists_.SetPlayed();
    const Vec2 at_mm = lists_.at_mm();
    state_.position_mm.head<2>() = at_mm;
  }
  playing_.reset();
  steps_.clear();
  held_.reset();
  lists_.Drop();
  axis_.reset();
  outline_.reset();
  listed_mm_ = state_.position_mm;
  return last;
}

void BjjczPointDriver::StopController() {
  outline_.reset();
  if (!line_.up()) return;
  asked_outputs_ =
      static_cast<std::uint16_t>(WantedOutputs() & ~(1U << board_.gate_output()));
  SendStop(*asked_outputs_, line_);
  oscillates_ = false;
  stopping_ = true;
  seen_since_stop_ = false;
  if (axis_) line_.Send({LmcOperation::kAxisPlace, {}});
}

std::unique_ptr<MotionDriver> MakeBjjczPointDriver(const MachineSpec& machine,
                                                   link::StreamOpener open,
                                                   link::SteadyClock clock) {
  auto set_up = BoardSetUp(machine);
  std::string broken = set_up ? "" : set_up.error().message;
  return std::make_unique<BjjczPointDriver>(
      machine, set_up ? std::move(*set_up) : std::vector<LmcCommand>(), std::move(broken),
      std::move(open), std::move(clock));
}

}  // namespace intaglio::drivers
