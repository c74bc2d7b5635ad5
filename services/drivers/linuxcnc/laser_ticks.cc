#include "services/drivers/linuxcnc/laser_ticks.h"

namespace intaglio::drivers {
namespace {

using link::TickOutcome;
// When nobody takes the reports: a host asks for the past then.
constexpr std::size_t kMaxReports = 4096;

}  // namespace

void LaserTicks::Begin(const std::vector<std::uint32_t>& fired) {
  decided_.clear();
  decided_through_ = 0;
  reports_.clear();
  requests_.clear();
  fired_ = {fired.begin(), fired.end()};
}

void LaserTicks::Arm(const link::ArmWindow& window, std::uint64_t sent_through) {
  const std::uint64_t too_late = std::max(decided_through_, sent_through);
  for (std::size_t i = 0; i < window.fire.size(); ++i) {
    const std::uint64_t tick = window.first_tick + i;
    if (tick > too_late) {
      decided_[tick] = {true, window.fire[i], window.gated};
      decided_through_ = tick;
    } else if (window.fire[i]) {
      reports_.push_back({tick, {TickOutcome::kTooLate}});
    }
  }
}

LaserTicks::Decision LaserTicks::TakeDecision(std::uint64_t tick) {
  decided_.erase(decided_.begin(), decided_.lower_bound(tick));
  decided_through_ = std::max(decided_through_, tick);
  if (decided_.empty() || decided_.begin()->first != tick) return {};
  const Decision decision = decided_.begin()->second;
  decided_.erase(decided_.begin());
  return decision;
}

void LaserTicks::Disarm(std::uint64_t sent_through) {
  decided_.clear();
  decided_through_ = sent_through;
}

void LaserTicks::Interlock() {
  for (auto& [tick, decision] : decided_) decision.interlocked = true;
}

void LaserTicks::Report(std::uint64_t tick, TickOutcome outcome) {
  if (outcome == TickOutcome::kFiredSeen || outcome == TickOutcome::kFiredUnseen)
    fired_.insert(tick);
  const bool follows =
      !reports_.empty() && reports_.back().outcome.size() < link::kMaxReportTicks &&
      reports_.back().outcome.back() != TickOutcome::kTooLate &&
      reports_.back().first_tick + reports_.back().outcome.size() == tick;
  if (follows)
    reports_.back().outcome.push_back(outcome);
  else
    reports_.push_back({tick, {outcome}});
  if (reports_.size() > kMaxReports) reports_.pop_front();
}

void LaserTicks::RequestPast(std::uint64_t first_tick, std::uint16_t count) {
  requests_.push_back({first_tick, count});
}

link::PastReport LaserTicks::PastOf(const link::PastRequest& request,
                                    std::uint64_t newest) const {
  link::PastReport report{request.first_tick, {}};
  for (std::uint64_t i = 0; i < request.count; ++i) {
    const std::uint64_t tick = request.first_tick + i;
    const bool known = tick + link::kRememberedTicks > newest;
    report.outcome.push_back(fired_.contains(tick) ? TickOutcome::kFiredSeen
                             : known               ? TickOutcome::kNotArmed
                                                   : TickOutcome::kNoLongerKnown);
  }
  return report;
}

void LaserTicks::Deliver(std::uint64_t newest, const LaserController::ReportSink& sink,
                         const LaserController::PastSink& past) {
  for (const link::PulseReport& report : std::exchange(reports_, {}))
    if (sink) sink(report);
  for (const link::PastRequest& request : std::exchange(requests_, {}))
    if (past) past(PastOf(request, newest));
  if (newest > 2 * link::kRememberedTicks)
    fired_.erase(fired_.begin(), fired_.lower_bound(newest - 2 * link::kRememberedTicks));
}

}  // namespace intaglio::drivers
