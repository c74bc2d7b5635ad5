#include "tests/services/drivers/laser_bench.h"

namespace intaglio::drivers {

using link::TickOutcome;

std::map<std::uint64_t, TickOutcome> LaserBench::Outcomes() {
  std::map<std::uint64_t, TickOutcome> outcomes;
  std::uint64_t newest = 0;
  for (const link::PulseReport& report : rig_->reports) {
    for (std::size_t i = 0; i < report.outcome.size(); ++i) {
      if (report.outcome[i] == TickOutcome::kTooLate) continue;
      const std::uint64_t at = report.first_tick + i;
      Expect(at > newest, fmt::format("L4: tick {} is reported after {}", at, newest));
      outcomes[newest = at] = report.outcome[i];
    }
  }
  return outcomes;
}

void LaserBench::ExpectRemembers(std::uint64_t first, std::uint16_t count) {
  rig_->pasts.clear();
  Expect(Until([&] { return driver().RequestPast(first, count); }),
         "L6: the past cannot be asked for");
  Expect(Until([&] { return !rig_->pasts.empty(); }), "L6: the past is not answered");
  const link::PastReport& past = rig_->pasts.front();
  Expect(past.first_tick == first && past.outcome.size() == count,
         "L6: other ticks are answered than asked for");
  const Ticks fired = rig_->FiredTicks();
  for (std::size_t i = 0; i < count; ++i) {
    const bool made = std::find(fired.begin(), fired.end(), first + i) != fired.end();
    const bool reported = past.outcome[i] == TickOutcome::kFiredSeen ||
                          past.outcome[i] == TickOutcome::kFiredUnseen;
    Expect(made == reported, fmt::format("L6: tick {} {}, and is remembered as {}",
                                         first + i, made ? "fired" : "did not fire",
                                         static_cast<int>(past.outcome[i])));
  }
}

void LaserBench::ExpectGoodWindow() {
  Prepare();
  Ticks expected = rig_->FiredTicks();
  const std::uint64_t count = driver().status().pulse_count;
  for (const std::uint64_t at : Arm(10, {true, false, true})) expected.push_back(at);
  PassTicks(20);
  ExpectFired(expected, "L2");
  StepFor(kReportTime);
  Expect(driver().status().pulse_count == count + 2, "L5: two pulses are not counted");
}

}  // namespace intaglio::drivers
