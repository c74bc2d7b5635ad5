#include "tests/services/drivers/laser_bench.h"

namespace intaglio::drivers {

using link::TickOutcome;

namespace {
constexpr std::uint64_t kIdlePatienceSteps = 100;
}  // namespace

void LaserBench::DecideIdleUpTo(std::uint64_t last) {
  const bool lockstep = driver().up() && driver().identity().lockstep;
  if (!lockstep || !driver().Has(link::kLampOn)) return;
  const link::LaserStatus& status = driver().status();
  // What is on its way is not repeated, unless it was lost.
  if (driver().session() != idle_session_ || steps_ > idle_until_) idle_through_ = 0;
  const std::uint64_t first =
      std::max({status.tick, status.decided_through, idle_through_}) + 1;
  last = std::min(last, first + link::kMaxArmTicks - 1);
  if (first > last || !driver().Arm({first, true, std::vector(last - first + 1, false)}))
    return;
  idle_session_ = driver().session();
  idle_through_ = last;
  idle_until_ = steps_ + kIdlePatienceSteps;
  for (std::uint64_t at = first; at <= last; ++at) idle_.insert(at);
}

void LaserBench::Step() {
  rig_->Step();
  ++steps_;
  if (driver().status().decided_through <= driver().status().tick) {
    DecideIdleUpTo(driver().status().tick + 1);
  }
}

std::map<std::uint64_t, TickOutcome> LaserBench::Outcomes() {
  std::map<std::uint64_t, TickOutcome> outcomes;
  std::uint64_t newest = 0;
  for (const link::PulseReport& report : rig_->reports) {
    for (std::size_t i = 0; i < report.outcome.size(); ++i) {
      if (report.outcome[i] == TickOutcome::kTooLate) continue;
      const std::uint64_t at = report.first_tick + i;
      Expect(at > newest, fmt::format("L4: tick {} is reported after {}", at, newest));
      newest = at;
      if (idle_.count(at) == 0) outcomes[at] = report.outcome[i];
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
