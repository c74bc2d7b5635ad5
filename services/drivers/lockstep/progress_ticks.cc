#include "services/drivers/lockstep/progress_ticks.h"

#include <algorithm>
#include <utility>

namespace intaglio::drivers {

void ProgressTicks::Remember(std::uint64_t tick, Outcome outcome) {
  memory_[tick % memory_.size()] = outcome;
}

void ProgressTicks::Decide(const link::ArmWindow& window) {
  const std::uint64_t open = std::max(decided_through_, tick_) + 1;
  for (std::size_t i = 0; i < window.fire.size(); ++i) {
    const std::uint64_t tick = window.first_tick + i;
    if (tick < open) {
      if (window.fire[i]) reports_.push_back({tick, {Outcome::kTooLate}});
      continue;
    }
    decided_through_ = tick;
    if (!window.fire[i]) continue;
    fire_.insert(tick);
    if (!window.gated) ungated_.insert(tick);
  }
}

void ProgressTicks::Refuse(std::uint64_t tick) {
  if (tick <= tick_ || tick > decided_through_ || fire_.count(tick) != 0) return;
  fire_.insert(tick);
  Settle(tick, Outcome::kInterlocked);
}

void ProgressTicks::UndecideAfter(std::uint64_t tick) {
  fire_.erase(fire_.upper_bound(tick), fire_.end());
  ungated_.erase(ungated_.upper_bound(tick), ungated_.end());
  decided_through_ = std::max(tick_, std::min(decided_through_, tick));
}

void ProgressTicks::Settle(std::uint64_t tick, Outcome outcome) {
  if (fire_.erase(tick) == 0) return;
  ungated_.erase(tick);
  settled_.insert(tick);
  Remember(tick, outcome);
  if (outcome != Outcome::kFiredUnseen) return;
  ++pulse_count_;
  last_fired_tick_ = std::max(last_fired_tick_, tick);
}

void ProgressTicks::PassThrough(std::uint64_t last) {
  link::PulseReport report{tick_ + 1, {}};
  const auto end_report = [&] {
    if (!report.outcome.empty()) reports_.push_back(std::move(report));
    report = {tick_ + 1, {}};
  };
  while (tick_ < last) {
    const std::uint64_t tick = ++tick_;
    if (fire_.count(tick) != 0) Settle(tick, Outcome::kNotInPosition);
    if (settled_.erase(tick) == 0) Remember(tick, Outcome::kNotArmed);
    const Outcome outcome = memory_[tick % memory_.size()];
    // Only an answer to RequestPast has what is not known.
    const bool reported = tick <= decided_through_ && outcome != Outcome::kNoLongerKnown;
    if (reported) report.outcome.push_back(outcome);
    if (!reported || report.outcome.size() == link::kMaxReportTicks) end_report();
  }
  end_report();
}

std::vector<link::PulseReport> ProgressTicks::TakeReports() {
  return std::exchange(reports_, {});
}

link::PastReport ProgressTicks::Past(std::uint64_t first_tick,
                                     std::uint16_t count) const {
  link::PastReport past{first_tick, {}};
  for (std::uint64_t tick = first_tick; tick < first_tick + count; ++tick) {
    if (tick > tick_ && settled_.count(tick) == 0) {
      past.outcome.push_back(Outcome::kNotArmed);
    } else if (tick + memory_.size() <= tick_) {
      past.outcome.push_back(Outcome::kNoLongerKnown);
    } else {
      past.outcome.push_back(memory_[tick % memory_.size()]);
    }
  }
  return past;
}

}  // namespace intaglio::drivers
