#include "services/drivers/lockstep/lockstep_driver.h"

#include <algorithm>
#include <utility>

#include "services/drivers/interface/power_up.h"
#include "services/job/beams/laser_wavelength.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

// With the lamp on it is the host that is awaited; without one, the plan's time counts.
constexpr auto kStarvedPatience = 1s;

}  // namespace

LockstepDriver::LockstepDriver(const MachineSpec& machine, link::SteadyClock clock,
                               std::string model)
    : clock_(std::move(clock)),
      rate_hz_(machine.laser().rates_hz_size() > 0 ? machine.laser().rates_hz(0) : 100),
      warm_up_s_(machine.laser().warm_up_s()),
      rates_hz_(machine.laser().rates_hz().begin(), machine.laser().rates_hz().end()) {
  identity_.power_up = DrawPowerUp();
  identity_.lockstep = true;
  identity_.rates_hz = rates_hz_;
  identity_.model = std::move(model);
  const EnergyRange energies = FullEnergiesOf(machine.laser());
  identity_.min_energy_mj = energies.min_mj;
  identity_.max_energy_mj = energies.max_mj;
  passed_at_ = now();
}

void LockstepDriver::Turn() {
  TakeAnswers();
  if (!line().up()) return SetDown();
  TakeRecovery();
  PassTicks();
  Feed();
  PassTicks();
  CheckStarved();
  Report();
}

// Another power-up of the controller: nothing of before counts.
void LockstepDriver::TakePowerUps() {
  if (line().power_ups() == power_ups_) return;
  if (power_ups_ != 0) {
    Forget();
    identity_.power_up = DrawPowerUp();
    ticks_ = {};
    reports_.clear();
    positions_.clear();
    ran_ = false;
    state_.run = 0;
    executed_through_ = committed_tick_ = 0;
    lamp_on_ = false;
  }
  power_ups_ = line().power_ups();
}

void LockstepDriver::BeginSession(const std::string& lost_run) {
  state_.refusal.clear();
  state_.fault = ran_ ? intaglio_MOTION_STARVED : intaglio_MOTION_OK;
  state_.message = ran_ ? lost_run : "";
  ran_ = false;
  halted_ = clearing_ = leaving_safe_ = checks_place_ = false;
  wanted_open_ = false;
  status_number_ = 0;
  disarms_sent_ = status_.disarms_taken = 0;
  pasts_.clear();
  reports_.clear();
}

void LockstepDriver::TakeLost() {
  ran_ = ran_ || run_ != Run::kNone;
  safe_ = true;
  Forget();
  reports_.clear();
  pasts_.clear();
}

void LockstepDriver::SetDown() {
  const bool refused = !line().refusal().empty();
  if (state_.link_up || state_.message != line().message()) ++state_.number;
  state_.link_up = false;
  state_.refusal = line().refusal();
  state_.fault = refused ? intaglio_MOTION_WRONG_CONTROLLER : intaglio_MOTION_LINK_LOST;
  state_.message = refused ? line().refusal() : "motion line: " + line().message();
  status_.shutters_open = 0;
  passed_at_ = now();
}

void LockstepDriver::SetFault(intaglio_MotionFault fault, std::string why) {
  state_.fault = fault;
  state_.message = std::move(why);
  clearing_ = false;
  DropProgram();
  if (run_ == Run::kWaits) EndRun();
  ++state_.number;
}

void LockstepDriver::Halt(intaglio_MotionFault fault, std::string why, StoppedBy by) {
  // What comes while it recovers is another stop: a person has to look again.
  if (halted_ && !leaving_safe_ && !clearing_) return;
  if (by == StoppedBy::kController) ++own_stops_;
  halted_ = safe_ = true;
  leaving_safe_ = false;
  Forget();
  wanted_open_ = false;
  SetFault(fault, std::move(why));
}

void LockstepDriver::Forget() {
  jog_.reset();
  homing_ = home_sent_ = false;
  const std::uint64_t last = std::max(ForgetSent(), ticks_.tick());
  ticks_.UndecideAfter(last);
  PassThrough(last);
  DropProgram();
  run_ = Run::kNone;
  checks_place_ = false;
  committed_tick_ = std::min(committed_tick_, ticks_.tick());
}

void LockstepDriver::TakeRecovery() {
  if (!clearing_ && !leaving_safe_) return;
  if (!HasRecovered()) return Recover();
  halted_ = false;
  if (std::exchange(leaving_safe_, false)) safe_ = false;
  if (!std::exchange(clearing_, false)) return;
  state_.fault = intaglio_MOTION_OK;
  state_.message.clear();
  ++state_.number;
}

void LockstepDriver::Report() {
  state_.link_up = IsIdentified();
  state_.tick = ticks_.tick();
  state_.covered_through_tick =
      run_ == Run::kNone ? executed_through_ : pieces().covered_through_tick();
  const bool is_quiet = !IsBusy() && IsQuiet();
  if (jog_ && is_quiet && jog_->is_sent()) jog_.reset();
  state_.at_rest = run_ == Run::kNone && !jog_ && is_quiet && IsSettled();
  if (state_.at_rest) state_.velocity_mm_s.setZero();
  ReportLaser();
}

Status LockstepDriver::Down() const {
  return Fail(ErrorCode::kLinkLost, line().up() ? state_.message : line().message());
}

std::vector<LatchedPositions> LockstepDriver::TakePositions() {
  return std::exchange(positions_, {});
}

Status LockstepDriver::BeginRun(std::uint32_t run, std::uint64_t start_tick,
                                std::uint64_t) {
  if (!up()) return Down();
  if (state_.fault != intaglio_MOTION_OK)
    return Fail(ErrorCode::kRefused, "the fault lasts: " + state_.message);
  const std::string unplaced = WhyPlaceIsUnknown(state_);
  if (!unplaced.empty()) {
    // With the number of this run: else it would be taken for a fault of before, which
    // this run clears.
    state_.run = run;
    SetFault(intaglio_MOTION_SAFE_STATE, unplaced + ", then resume");
    return {};
  }
  const bool busy = run_ != Run::kNone || jog_ || IsBusy();
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
  BeginProgram(start_tick);
  return {};
}

std::size_t LockstepDriver::Room() const {
  if (!up()) return 0;
  // A run that ended by a fault takes what still comes, and does nothing of it.
  if (run_ == Run::kNone || state_.fault != intaglio_MOTION_OK) return kQueuedPieces;
  return kQueuedPieces - std::min(kQueuedPieces, pieces().size());
}

Status LockstepDriver::Append(std::span<const motion::Segment> segments,
                              std::span<const std::uint64_t>) {
  if (!up()) return Down();
  if (segments.size() > Room())
    return Fail(ErrorCode::kRefused, "the queue of segments is full");
  if (run_ == Run::kNone || state_.fault != intaglio_MOTION_OK) return {};
  if (auto taken = pieces().Append(segments, rate_hz_); !taken)
    SetFault(intaglio_MOTION_LIMIT, taken.error().message);
  return {};
}

Status LockstepDriver::AbortRun() {
  if (!up()) return Down();
  DropProgram();
  aborted_ = true;
  if (run_ == Run::kWaits) EndRun();
  return {};
}

Status LockstepDriver::CheckByHand() const {
  if (!up()) return Down();
  if (state_.at_rest && state_.fault == intaglio_MOTION_OK && state_.homed) return {};
  return Fail(ErrorCode::kRefused, !state_.homed            ? WhyPlaceIsUnknown(state_)
                                   : state_.message.empty() ? "the stage is not at rest"
                                                            : state_.message);
}

Status LockstepDriver::Jog(const Vec3& axes, double speed_mm_s) {
  if (auto may = CheckByHand(); !may) return may;
  // What it counts is no place on the axes: a person watches how far it goes.
  const bool is_known = state_.place_lost.empty();
  if (auto good = pieces().Check(axes); is_known ? !good : !axes.allFinite()) return good;
  wanted_open_ = false;
  jog_ = JogWay{state_.position_mm, axes, std::max(0.01, speed_mm_s),
                (axes - state_.position_mm).norm()};
  state_.at_rest = false;
  return {};
}

std::optional<LockstepDriver::JogPiece> LockstepDriver::NextJogPiece() const {
  if (jog_->is_sent()) return std::nullopt;
  JogPiece piece;
  piece.end_mm = std::min(jog_->length_mm,
                          jog_->sent_mm + jog_->speed_mm_s * PieceQueue::kMaxPiece_s);
  piece.seconds = (piece.end_mm - jog_->sent_mm) / jog_->speed_mm_s;
  piece.to_mm =
      jog_->from_mm + (jog_->to_mm - jog_->from_mm) * (piece.end_mm / jog_->length_mm);
  return piece;
}

Status LockstepDriver::Home() {
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

Status LockstepDriver::Hold() {
  if (!up()) return Down();
  if (homing_ && home_sent_) {
    StopHoming();
    return {};
  }
  homing_ = false;
  if (!jog_) return AbortRun();
  jog_->cancelled = true;
  return {};
}

Status LockstepDriver::ClearFault() {
  if (!up()) return Down();
  if (state_.fault == intaglio_MOTION_OK) return {};
  clearing_ = true;
  Recover();
  return {};
}

void LockstepDriver::EndRun() {
  checks_place_ = run_ == Run::kRuns;
  run_ = Run::kNone;
}

void LockstepDriver::Plan(double seconds) {
  planned_end_ = std::max(planned_end_, now()) +
                 std::chrono::nanoseconds(static_cast<std::int64_t>(seconds * 1e9));
}

void LockstepDriver::PassThrough(std::uint64_t tick) {
  if (tick > ticks_.tick()) ticks_.PassThrough(tick);
}

// Without a run: through which tick time has come.
std::uint64_t LockstepDriver::IdleTarget() {
  std::uint64_t target = ticks_.tick();
  if (lamp_on_) {
    target = std::max(target, ticks_.decided_through());
    // A pulse that is not sent yet.
    const std::uint64_t next = ticks_.next_fire_after(ticks_.tick());
    if (!halted_) target = std::min(target, next - 1);
  } else {
    const double passed =
        std::chrono::duration<double>(now() - passed_at_).count() * rate_hz_ +
        passed_part_;
    target += static_cast<std::uint64_t>(passed);
    passed_part_ = passed - static_cast<double>(target - ticks_.tick());
    for (std::uint64_t tick = ticks_.next_fire_after(ticks_.tick()); tick <= target;
         tick = ticks_.next_fire_after(tick)) {
      ticks_.Settle(tick, WhyDark().value_or(link::TickOutcome::kLampNotReady));
    }
  }
  return run_ == Run::kWaits ? std::min(target, start_tick_) : target;
}

void LockstepDriver::PassTicks() {
  if (run_ != Run::kRuns) {
    PassThrough(LimitedByPulses(IdleTarget()));
    if (run_ == Run::kWaits && ticks_.tick() >= start_tick_ && !halted_ && !IsBusy() &&
        IsSettled()) {
      run_ = Run::kRuns;
      planned_end_ = now();
    }
  }
  passed_at_ = now();
  if (run_ != Run::kRuns) return;
  PassThrough(std::min(LimitedByPulses(executed_through_), DecidedThrough()));
  if (!pieces().has_end() || !IsGivenOut() || IsBusy() || !IsSettled()) return;
  if (aborted_ || !lamp_on_ || ticks_.tick() >= executed_through_ ||
      state_.fault != intaglio_MOTION_OK)
    EndRun();
}

void LockstepDriver::CheckStarved() {
  if (run_ != Run::kRuns || pieces().has_end() || state_.fault != intaglio_MOTION_OK)
    return;
  if (!pieces().empty() || HasPending()) {
    planned_end_ = std::max(planned_end_, now());
    return;
  }
  if (now() < planned_end_ + (lamp_on_ ? kStarvedPatience : 0s)) return;
  SetFault(intaglio_MOTION_STARVED,
           "the segments of the run ended before the run: the host was too slow");
}

}  // namespace intaglio::drivers
