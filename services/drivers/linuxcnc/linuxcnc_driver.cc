#include "services/drivers/linuxcnc/linuxcnc_driver.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/try.h"
#include "services/job/beams/laser_wavelength.h"

namespace intaglio::drivers {
namespace {

constexpr std::size_t kQueue = 512;  // segments
// Rest: the axes do not move for so many reports.
constexpr int kStillSamples = 12;
constexpr double kStill_mm = 0.0005;
// The number of the first row of a session is far above any that may still be on its way.
constexpr std::uint64_t kRowGap = 1'000'000;
constexpr char kHowToHome[] = ", until the axes' file sets axes-homed";

}  // namespace

LinuxcncDriver::LinuxcncDriver(const MachineSpec& machine, HalOpener open,
                               link::SteadyClock clock, double lead_s)
    : session_(std::move(open), machine.motion_line().device(),
               link::ExpectedDevice{machine.motion_line().serial_number(),
                                    "LinuxCNC machine", machine.name(),
                                    machine.motion_line().device(), "motion_line"},
               clock),
      clock_(std::move(clock)),
      travel_(TravelOf(machine)),
      max_speed_mm_s_(machine.x().max_speed_mm_s(), machine.y().max_speed_mm_s(),
                      machine.z().max_speed_mm_s()),
      max_acceleration_mm_s2_(machine.x().max_acceleration_mm_s2(),
                              machine.y().max_acceleration_mm_s2(),
                              machine.z().max_acceleration_mm_s2()),
      lead_s_(lead_s),
      energies_(FullEnergiesOf(machine.laser())),
      profile_rates_hz_(machine.laser().rates_hz().begin(),
                        machine.laser().rates_hz().end()) {
  state_.message = session_.message();
  state_.how_to_home = kHowToHome;
}

void LinuxcncDriver::Poll() { Turn(); }

void LinuxcncDriver::Turn() {
  const std::vector<HalSample>& samples = session_.Poll();
  if (!session_.up()) return SetDown();
  if (session_.sessions() != begun_sessions_) BeginSession();
  for (const HalSample& sample : samples) {
    Receive(sample);
    if (!session_.up()) return SetDown();
  }
  if (!samples.empty()) {
    UpdateStatus(samples.back());
    UpdateState(samples.back());
  }
  SendRows();
  if (!session_.up()) SetDown();
}

void LinuxcncDriver::BeginSession() {
  const HalSample& now = session_.newest();
  begun_sessions_ = session_.sessions();
  if (identity_.power_up != session_.identity().power_up) {
    run_lost_ = false;
    state_.run = 0;
    positions_.clear();
  }
  identity_ = {session_.identity().power_up,     false, 1, {}, "LinuxCNC HAL",
               session_.identity().serial_number};
  identity_.min_energy_mj = energies_.min_mj;
  identity_.max_energy_mj = energies_.max_mj;
  for (const double rate_hz : profile_rates_hz_)
    if (PeriodsOf(rate_hz) != 0) identity_.rates_hz.push_back(rate_hz);
  const bool kept = now.periods >= 2 && now.periods <= kMaxPeriods;
  if (kept)
    periods_ = static_cast<std::uint32_t>(now.periods);
  else if (!identity_.rates_hz.empty())
    periods_ = PeriodsOf(identity_.rates_hz.front());
  wanted_periods_ = periods_;
  sent_.clear();
  next_row_ = now.row + kRowGap;
  next_tick_ = std::uint64_t{now.tick} + 1;
  next_period_ = 0;
  ticks_.Begin(session_.record());
  ticks_.Disarm(now.tick);
  status_number_ = 0;
  disarms_ = 0;
  disarm_number_ = session_.arm();
  reset_number_ = 0;
  shutter_open_ = false;
  jog_.End();
  settled_ = run_in_flight_ = jog_in_flight_ = clearing_ = false;
  still_samples_ = 0;
  state_.fault = run_lost_ ? intaglio_MOTION_STARVED : intaglio_MOTION_OK;
  state_.message =
      run_lost_ ? "the run was lost with the line, and the axes stopped" : "";
  // What has been idle may be used at once; after power-up every latch is open.
  if (!run_lost_ && !now.Has(kHalMotionOk)) (void)ClearFault();
}

void LinuxcncDriver::SetDown() {
  if (state_.link_up || state_.message != session_.message()) ++state_.number;
  if (state_.link_up && (course_.active() || run_in_flight_)) run_lost_ = true;
  course_.End();
  jog_.End();
  sent_.clear();
  run_in_flight_ = jog_in_flight_ = false;
  status_number_ = 0;
  state_.link_up = false;
  state_.taken_over = session_.fenced();
  state_.refusal = session_.refusal();
  state_.fault = session_.refusal().empty() ? intaglio_MOTION_LINK_LOST
                                            : intaglio_MOTION_WRONG_CONTROLLER;
  state_.message = session_.message();
}

void LinuxcncDriver::Receive(const HalSample& sample) {
  if (sample.Has(kHalFresh))
    TakeRow(sample);
  else if ((run_in_flight_ || jog_in_flight_) && !sent_.empty() &&
           (sent_.front().run != 0 || sent_.front().by_hand))
    SetFault(intaglio_MOTION_STARVED,
             "the rows of positions did not reach LinuxCNC in time: the computer is too "
             "busy, or its services do not run in real time");
  TakeRest(sample);
  TakeLatches(sample);
}

void LinuxcncDriver::TakeRow(const HalSample& sample) {
  if (sent_.empty() || sample.row < sent_.front().number) return;
  if (sample.row > sent_.front().number)
    return session_.Lose("reports of rows are missing");
  const SentRow row = sent_.front();
  sent_.pop_front();
  if (row.sync) TakeSync(row, sample);
  const bool moves = row.run != 0 || row.by_hand;
  const bool followed = moves && row.motion == sample.motion;
  if (followed && sample.Has(kHalMotionOk)) {
    const double error_um =
        (sample.actual_mm - row.position_mm).cwiseAbs().maxCoeff() * 1e3;
    state_.following_error_max_um = std::max(state_.following_error_max_um, error_um);
  }
  if (followed && row.last) run_in_flight_ = jog_in_flight_ = false;
}

void LinuxcncDriver::TakeSync(const SentRow& row, const HalSample& sample) {
  status_.tick = state_.tick = row.tick;
  status_.machine_us = static_cast<std::uint64_t>(static_cast<double>(row.number) *
                                                  session_.identity().period_ns / 1e3);
  // Fenced off by a Disarm of the host: it is not decided any more.
  const bool fenced = sample.arm != row.arm;
  if (row.decision.decided && !(fenced && row.arm < disarm_number_))
    ticks_.Report(row.tick, OutcomeOf(row, sample));
  if (row.run == 0 || row.motion != sample.motion || row.tick <= course_.start_tick())
    return;
  positions_.push_back({row.run, row.tick, {sample.actual_mm}, {}});
}

// Rest, after the axes have braked: the place that HAL holds is where rows go on.
void LinuxcncDriver::TakeRest(const HalSample& sample) {
  state_.velocity_mm_s = (sample.actual_mm - last_actual_mm_) / period_s();
  const bool still =
      (sample.actual_mm - last_actual_mm_).cwiseAbs().maxCoeff() < kStill_mm;
  last_actual_mm_ = sample.actual_mm;
  if (settled_ || sample.motion != session_.motion()) return;
  still_samples_ = still ? still_samples_ + 1 : 0;
  if (still_samples_ < kStillSamples) return;
  settled_ = true;
  place_mm_ = sample.target_mm;
}

void LinuxcncDriver::TakeLatches(const HalSample& sample) {
  if (sample.Has(kHalMotionOk)) {
    if (clearing_) state_.fault = intaglio_MOTION_OK, state_.message.clear();
    clearing_ = false;
  } else if (state_.fault == intaglio_MOTION_OK && !clearing_) {
    SetFault(intaglio_MOTION_SAFE_STATE,
             "LinuxCNC has stopped the axes: the stop button, the drives, or a host that "
             "was silent for 200 ms");
  }
  const bool before_reset = sample.command < reset_number_;
  if (before_reset || sample.Has(kHalLaserOk) || !shutter_open_) return;
  shutter_open_ = false;
  ticks_.Disarm(sent_through());
  (void)session_.SetShutter(false);
  (void)session_.NextArm();
}

void LinuxcncDriver::UpdateState(const HalSample& sample) {
  // Not before it is known where the axes rest: no run could begin.
  state_.link_up = state_.link_up || settled_;
  state_.refusal.clear();
  state_.position_mm = sample.actual_mm;
  // It spends a grant as an opening does, also between two runs.
  if (state_.homed && !sample.Has(kHalHomed)) ++lost_places_;
  state_.homed = sample.Has(kHalHomed);
  if (!state_.homed && (run_in_flight_ || jog_in_flight_))
    SetFault(intaglio_MOTION_SAFE_STATE, WhyPlaceIsUnknown(state_) + ", then resume");
  state_.covered_through_tick = course_.active() ? course_.covered_through_tick() : 0;
  state_.at_rest = settled_ && !course_.active() && !run_in_flight_ && !jog_in_flight_;
  ++state_.number;
}

void LinuxcncDriver::SendRows() {
  const auto lead = static_cast<std::size_t>(lead_s_ / period_s());
  std::string text;
  while (sent_.size() < lead) {
    const SentRow row = NextRow();
    AppendText(
        HalRow{static_cast<std::uint32_t>(row.tick), row.number, row.arm, row.motion,
               row.sync && row.decision.fire && !row.decision.interlocked &&
                   (row.knot || !row.decision.gated),
               row.decision.gated, row.position_mm},
        text);
    sent_.push_back(row);
  }
  if (!text.empty()) (void)session_.WriteRows(text);
}

LinuxcncDriver::SentRow LinuxcncDriver::NextRow() {
  SentRow row;
  if (next_period_ == 0 && !course_.active()) periods_ = wanted_periods_;
  row.number = next_row_++;
  row.tick = next_tick_;
  row.sync = next_period_ == 0;
  if (row.sync) row.decision = ticks_.TakeDecision(row.tick);
  if (course_.active()) FollowCourse(row);
  if (jog_.active()) FollowJog(row);
  row.position_mm = place_mm_;
  row.arm = session_.arm();
  row.motion = settled_ ? session_.motion() : 0;
  if (++next_period_ >= periods_) next_period_ = 0, ++next_tick_;
  return row;
}

void LinuxcncDriver::FollowCourse(SentRow& row) {
  const auto place = course_.At(row.tick, next_period_, periods_);
  if (!place)
    return SetFault(
        intaglio_MOTION_STARVED,
        "the motion of the run ended before its end: the host or its line was "
        "too slow");
  if (!Inside(place->position_mm))
    return SetFault(
        intaglio_MOTION_LIMIT,
        "the path leaves the axes' travel: check block_origin_mm and the block");
  place_mm_ = place->position_mm;
  row.knot = place->pulse;
  row.run = course_.run();
  row.last = place->ended;
  if (place->ended) course_.End();
}

void LinuxcncDriver::FollowJog(SentRow& row) {
  place_mm_ = jog_.Next(period_s());
  row.by_hand = true;
  row.last = !jog_.active();
  row.decision.interlocked = true;
}

bool LinuxcncDriver::Inside(const Vec3& place_mm) const {
  // A NaN is outside.
  return (place_mm.array() >= travel_.min_mm.array()).all() &&
         (place_mm.array() <= travel_.max_mm.array()).all();
}

void LinuxcncDriver::SetFault(intaglio_MotionFault fault, std::string message) {
  state_.fault = fault;
  state_.message = std::move(message);
  ++state_.number;
  Brake();
}

// HAL brakes, from where the axes are; rows of the run that wait there are not followed.
void LinuxcncDriver::Brake() {
  course_.End();
  jog_.End();
  run_in_flight_ = jog_in_flight_ = false;
  settled_ = false;
  still_samples_ = 0;
  (void)session_.NextMotion();
}

Status LinuxcncDriver::BeginRun(std::uint32_t run, std::uint64_t start_tick,
                                std::uint64_t) {
  if (!state_.link_up) return LinkLost();
  if (state_.fault != intaglio_MOTION_OK)
    return Fail(ErrorCode::kRefused, "a fault is not cleared: " + state_.message);
  if (!state_.homed) {
    // With its number: else it would be taken for a fault of before (M18).
    state_.run = run;
    SetFault(intaglio_MOTION_SAFE_STATE, WhyPlaceIsUnknown(state_) + ", then resume");
  } else if (course_.active() || run_in_flight_ || jog_in_flight_ || !settled_) {
    SetFault(intaglio_MOTION_LATE,
             "the axes were not at rest at the beginning of the run");
  } else if (start_tick < next_tick_ || (start_tick == next_tick_ && next_period_ != 0)) {
    SetFault(intaglio_MOTION_LATE, "the run reached LinuxCNC after its start tick");
  } else {
    course_.Begin(run, start_tick, place_mm_, tick_s());
    run_in_flight_ = true;
    state_.run = run;
    state_.at_rest = false;
  }
  return {};
}

std::size_t LinuxcncDriver::Room() const {
  if (!state_.link_up || course_.waiting() >= kQueue) return 0;
  return kQueue - course_.waiting();
}

Status LinuxcncDriver::Append(std::span<const motion::Segment> segments,
                              std::span<const std::uint64_t>) {
  if (!state_.link_up) return LinkLost();
  if (segments.size() > Room()) return Fail(ErrorCode::kTooLarge, "the queue is full");
  if (!course_.active()) return {};
  for (const motion::Segment& segment : segments) {
    if (Inside(segment.end_position_mm)) continue;
    SetFault(
        intaglio_MOTION_LIMIT,
        "a target lies outside the axes' travel: check block_origin_mm and the block");
    return {};
  }
  course_.Append(segments);
  return {};
}

Status LinuxcncDriver::AbortRun() {
  if (!state_.link_up) return LinkLost();
  if (course_.active() || run_in_flight_ || jog_in_flight_) Brake();
  return {};
}

Status LinuxcncDriver::Jog(const Vec3& axes, double speed_mm_s) {
  if (!state_.link_up) return LinkLost();
  if (state_.fault != intaglio_MOTION_OK)
    return Fail(ErrorCode::kRefused, "a fault is not cleared: " + state_.message);
  if (!state_.homed) return Fail(ErrorCode::kRefused, WhyPlaceIsUnknown(state_));
  if (course_.active() || run_in_flight_ || jog_in_flight_ || !settled_)
    return Fail(ErrorCode::kRefused, "the axes are not at rest");
  if (!Inside(axes))
    return Fail(ErrorCode::kInvalidValue, "the place lies outside the axes' travel");
  if (!(max_speed_mm_s_.minCoeff() > 0) || !(max_acceleration_mm_s2_.minCoeff() > 0))
    return Fail(ErrorCode::kMissing,
                "the machine profile has no max_speed_mm_s or max_acceleration_mm_s2 of "
                "an axis: give them");
  shutter_open_ = false;
  ticks_.Disarm(sent_through());
  INTAGLIO_TRY(session_.NextArm());
  INTAGLIO_TRY(session_.SetShutter(false));
  jog_.Begin(place_mm_, axes, std::max(0.01, speed_mm_s), max_speed_mm_s_,
             max_acceleration_mm_s2_);
  jog_in_flight_ = true;
  state_.at_rest = false;
  return {};
}

Status LinuxcncDriver::ClearFault() {
  if (!session_.up()) return LinkLost();
  run_lost_ = false;
  if (session_.newest().Has(kHalMotionOk)) {
    state_.fault = intaglio_MOTION_OK;
    state_.message.clear();
    return {};
  }
  state_.fault = intaglio_MOTION_SAFE_STATE;
  clearing_ = true;
  return session_.ResetMotion();
}

std::unique_ptr<MotionDriver> MakeLinuxcncDriver(const MachineSpec& machine,
                                                 link::StreamOpener,
                                                 link::SteadyClock clock) {
  return std::make_unique<LinuxcncDriver>(machine, &OpenHalLine, std::move(clock));
}

}  // namespace intaglio::drivers
