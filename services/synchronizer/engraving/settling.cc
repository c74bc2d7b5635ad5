#include "services/synchronizer/engraving/settling.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "engrave/core/counted.h"

namespace intaglio::synchronizer {
namespace {

using formats::PointOutcome;
using namespace std::chrono_literals;

constexpr auto kPastRequestPeriod = 20ms;  // until it is answered
constexpr auto kAbortPeriod = 200ms;

}  // namespace

void Settling::Begin(SkipReason reason, std::chrono::nanoseconds now) {
  // A full window of the line is no reason to wait: the next turns ask again.
  (void)RequestDisarm();
  (void)feed_.Abort();
  reason_ = reason;
  // What was never sent can never fire.
  SettleAs(ticks_.DropUnsent(), PointOutcome::kSkipped);
  began_at_ = now;
  uncertain_before_ = record_.ledger().count(PointState::kUncertain);
}

void Settling::BeginTakenUp(const EarlierWork& earlier) {
  taken_up_ = true;
  reason_ = SkipReason::kLink;
  for (PulseResult& one : record_.TakeUp(earlier)) {
    const bool askable = record_.power_up() != 0 &&
                         earlier.points[one.point].power_up == record_.power_up();
    if (askable && ticks_.schedule().AddArmed(one.tick, one.point)) continue;
    one.outcome = PointOutcome::kUncertain;
    record_.Resolve(one);
  }
  uncertain_before_ = record_.ledger().count(PointState::kUncertain);
}

bool Settling::RequestDisarm() {
  disarm_session_ = laser_.session();
  disarm_seen_ = false;
  disarm_sent_ = laser_.CanSend() && laser_.OpenShutters(0) && laser_.Disarm() &&
                 laser_.RequestStatus();
  return disarm_sent_;
}

bool Settling::AwaitsDisarm() {
  if (disarm_session_ != laser_.session() || disarm_seen_) return false;
  if (!disarm_sent_) (void)RequestDisarm();
  return true;
}

// What was decided before it has to be decided anew, also when its answer comes late.
void Settling::TakeDisarmed() {
  if (disarm_seen_ || !disarm_sent_ || disarm_session_ != laser_.session() ||
      !laser_.disarmed()) {
    return;
  }
  ticks_.TakeDisarmed();
  disarm_seen_ = true;
}

std::optional<std::string> Settling::Turn(std::chrono::nanoseconds now, bool grant_known,
                                          bool no_run_yet) {
  if (!began_at_) began_at_ = now;
  if (!disarm_sent_ || disarm_session_ != laser_.session()) (void)RequestDisarm();
  // The stage has not reported where it was at those ticks, and will not.
  if (is_late(now)) ticks_.LosePlaces();
  if (!disarmed()) return std::nullopt;
  return SettleByMemory(now, grant_known, no_run_yet);
}

void Settling::AbortEarlierRun(const MotionView& motion, std::chrono::nanoseconds now) {
  if (!motion.fresh || motion.at_rest || now < next_abort_) return;
  next_abort_ = now + kAbortPeriod;
  record_.SkipRuns(motion.highest_run);
  (void)feed_.Abort(record_.run());
}

// In the session that armed them, ticks behind the last decided one never fire, and the
// reports of the others were sent before that status.
std::optional<std::string> Settling::SettleByMemory(std::chrono::nanoseconds now,
                                                    bool grant_known, bool no_run_yet) {
  PulseSchedule& schedule = ticks_.schedule();
  if (laser_.identity().power_up != record_.power_up()) {
    SettleAs(schedule.ArmedWithin(0, UINT64_MAX), PointOutcome::kUncertain);
    ticks_.LosePlaces();
    record_.TakeCounters(laser_);
    return std::nullopt;
  }
  const bool lost = ticks_.session_lost();
  if (!lost) {
    SettleAs(schedule.ArmedWithin(laser_.status().decided_through + 1, UINT64_MAX),
             PointOutcome::kSkipped);
  }
  if (schedule.armed_count() > 0) {
    if (lost || is_late(now)) RequestPast(now);
    return std::nullopt;
  }
  // What it finds spends a grant: there is none before one was received.
  if (!lost || !grant_known || ticks_.awaits_places()) return std::nullopt;
  return CompareCounters(no_run_yet);
}

void Settling::RequestPast(std::chrono::nanoseconds now) {
  if (now < next_past_ || !laser_.CanSend()) return;
  next_past_ = now + kPastRequestPeriod;
  const std::uint64_t first = ticks_.schedule().front_tick();
  const auto asked =
      ticks_.schedule().ArmedWithin(first, first + link::kMaxPastTicks - 1);
  if (asked.empty()) return;
  (void)laser_.RequestPast(first,
                           static_cast<std::uint16_t>(asked.back().tick - first + 1));
}

void Settling::Receive(const link::PastReport& report) {
  if (!disarm_seen_) return;
  const std::uint64_t before = record_.fired_point_count();
  ticks_.Receive(report);
  settled_by_memory_count_ += record_.fired_point_count() - before;
}

// A pulse that the controller counted and that was not requested is in the glass
// somewhere. If the end of the journal is missing, these pulses made the next points, as
// they are fired in the order.
std::optional<std::string> Settling::CompareCounters(bool no_run_yet) {
  const auto counted = static_cast<std::uint32_t>(laser_.status().pulse_count);
  const std::uint32_t known = record_.known_pulse_count();
  const PointLedger& ledger = record_.ledger();
  const bool explained = ledger.count(PointState::kUncertain) > uncertain_before_;
  std::optional<std::string> finding;
  if (counted != known && !explained && unmarked_count_ == 0) {
    const std::uint32_t more = counted - known;
    if (taken_up_ && no_run_yet && more <= ledger.size()) unmarked_count_ = more;
    finding = fmt::format(
        "the laser controller counts {} where {} {} known{}: "
        "check the block, then resume or cancel",
        Counted(counted, "pulse"), known, IsOrAre(known),
        unmarked_count_ == 0
            ? ""
            : fmt::format(", so the next {} {} uncertain",
                          Counted(unmarked_count_, "point"), IsOrAre(unmarked_count_)));
  }
  if (MarkNextPoints()) record_.TakeCounters(laser_);
  return finding;
}

// They may be more than the journal's ring takes at once; false: the next turns go on.
bool Settling::MarkNextPoints() {
  const PointLedger& ledger = record_.ledger();
  for (auto point = ledger.NextOpen(0); unmarked_count_ > 0 && point;
       point = ledger.NextOpen(*point)) {
    if (!record_.MarkUncertain(*point)) return false;
    --unmarked_count_;
  }
  unmarked_count_ = 0;
  return true;
}

void Settling::SettleAs(std::vector<PulseResult> points, PointOutcome outcome) {
  for (PulseResult& point : points) {
    point.outcome = outcome;
    point.reason = outcome == PointOutcome::kSkipped ? reason_ : SkipReason::kNone;
  }
  ticks_.schedule().Settle(points, [this](const PulseResult& r) { record_.Resolve(r); });
}

}  // namespace intaglio::synchronizer
