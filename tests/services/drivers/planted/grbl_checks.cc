#include "tests/services/drivers/planted/grbl_checks.h"

#include <algorithm>
#include <array>
#include <optional>

#include "tests/services/drivers/grbl/grbl_rig.h"
#include "tests/services/drivers/laser_bench.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;
using link::TickOutcome;

/// A bench whose rig shows the controller.
struct GrblBench {
  explicit GrblBench(const LaserPlant& plant)
      : bench([this, &plant](const std::string& serial_number) {
          auto made = std::make_unique<GrblLaserRig>(serial_number);
          if (plant) made->driver = plant(std::move(made->driver));
          rig = made.get();
          return made;
        }) {}
  GrblLaserRig* rig = nullptr;
  LaserBench bench;
};

/// The memory of ticks from `first` on is the truth or "not known", and the latter
/// at most for the window of uncertainty.
void ExpectMemoryWithUncertain(GrblBench& grbl, std::uint64_t first) {
  LaserBench& bench = grbl.bench;
  grbl.rig->pasts.clear();
  Expect(bench.driver().RequestPast(first, 200), "the past cannot be asked for");
  Expect(bench.Until([&] { return !grbl.rig->pasts.empty(); }), "no answer");
  const auto fired = grbl.rig->FiredTicks();
  std::size_t uncertain = 0, known = 0;
  for (std::size_t i = 0; i < 200; ++i) {
    const TickOutcome outcome = grbl.rig->pasts.front().outcome[i];
    const bool made = std::find(fired.begin(), fired.end(), first + i) != fired.end();
    uncertain += outcome == TickOutcome::kNoLongerKnown;
    known += outcome == TickOutcome::kFiredUnseen;
    Expect(outcome == TickOutcome::kNoLongerKnown ||
               made == (outcome == TickOutcome::kFiredUnseen),
           fmt::format("tick {} is remembered as {}, and {}", first + i,
                       static_cast<int>(outcome), made ? "fired" : "did not fire"));
  }
  Expect(uncertain <= GrblDriver::kMaxUnsettled,
         fmt::format("{} ticks are uncertain", uncertain));
  Expect(known <= fired.size() && known + uncertain >= fired.size(),
         "pulses are neither known nor uncertain");
}

/// There is no watchdog: it runs out what it has, and is dark at rest, always.
void ExpectDarkAfterACut(const LaserPlant& plant,
                         std::optional<std::uint64_t> after_bytes) {
  GrblBench grbl(plant);
  LaserBench& bench = grbl.bench;
  bench.ConnectAndPrepare();
  const std::uint64_t first = bench.tick() + 1, session = bench.driver().session();
  const Ticks armed = bench.Arm(5, std::vector<bool>(200, true));
  if (after_bytes) {
    grbl.rig->CutLineAfter(*after_bytes);
  } else {
    bench.PassTicks(20);
    grbl.rig->CutLine(true);
  }
  Expect(bench.Until([&] { return !bench.driver().up(); }), "L7: a cut line is up");
  bench.StepFor(1s);
  const Ticks fired = grbl.rig->FiredTicks();
  Expect(std::includes(armed.begin(), armed.end(), fired.begin(), fired.end()),
         "L2: a tick fires that nobody armed, or twice");
  Expect(!grbl.rig->grbl().motion().moving() && !grbl.rig->grbl().motion().lit() &&
             grbl.rig->grbl().motion().lit_at_rest_us() == 0,
         "it is lit at rest");
  const std::size_t count = fired.size();
  bench.StepFor(5s);
  Expect(grbl.rig->FiredTicks().size() == count, "L7: it fires on without a host");
  grbl.rig->CutLine(false);
  bench.Connect();
  Expect(bench.driver().session() > session, "L8: the session is the one before");
  bench.ExpectNoPulseFor(1s, "L8: pulses come back by themselves");
  Expect(grbl.rig->shutters() == 0, "L8: the shutters open by themselves");
  ExpectMemoryWithUncertain(grbl, first);
  bench.ExpectGoodWindow();
}

/// Openings without a host are seen as one: the door's state is latched.
void AnOpeningWithoutAHostIsSeen(const LaserPlant& plant) {
  GrblBench grbl(plant);
  LaserBench& bench = grbl.bench;
  bench.ConnectAndPrepare();
  const std::uint32_t openings = bench.driver().status().openings;
  grbl.rig->CutLine(true);
  bench.StepFor(100ms);
  for (const bool holds : {false, true, false, true}) {
    grbl.rig->Set(LaserRig::Interlock::kDoor, holds);
  }
  bench.StepFor(1s);
  grbl.rig->CutLine(false);
  bench.Connect();
  Expect(bench.driver().status().openings == openings + 1, "L9: it is not seen");
  bench.ExpectNoPulseFor(500ms, "L9: pulses come back by themselves");
  bench.ExpectGoodWindow();
}

void ACutLineLeavesItDark(const LaserPlant& plant) {
  ExpectDarkAfterACut(plant, std::nullopt);
}

void ALineCutAtAnyByteLeavesItDark(const LaserPlant& plant) {
  for (std::uint64_t bytes = 0; bytes < 300; bytes += 17) {
    ExpectDarkAfterACut(plant, bytes);
  }
}

constexpr std::array kChecks = {
    GrblCheck{"L7L8_cut", &ACutLineLeavesItDark},
    GrblCheck{"L7_cut_at_any_byte", &ALineCutAtAnyByteLeavesItDark},
    GrblCheck{"L9_openings", &AnOpeningWithoutAHostIsSeen},
};

}  // namespace

std::span<const GrblCheck> GrblChecks() { return kChecks; }

std::string ViolationOf(const GrblCheck& check, const LaserPlant& plant) {
  try {
    check.run(plant);
    return "";
  } catch (const std::runtime_error& violation) {
    return violation.what();
  }
}

}  // namespace intaglio::drivers
