// L14: what happens at a laser controller.

#include "tests/services/drivers/laser_bench.h"
#include "tests/services/drivers/laser_conformance.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

struct KnownOfLaser {
  std::uint32_t power_up = 0, openings = 0;
  bool operator==(const KnownOfLaser&) const = default;
};
KnownOfLaser KnownOf(LaserBench& bench) {
  return {bench.driver().identity().power_up, bench.driver().status().openings};
}

void AFaultIsCountedAndNothingFires(const LaserRigMaker& make, ControllerFault fault,
                                    FaultInstant instant) {
  constexpr std::uint64_t kPassed = 20;
  LaserBench bench(make);
  bench.ConnectAndPrepare();
  if (instant == FaultInstant::kInTheRun) {
    bench.Arm(5, std::vector<bool>(200, true));
    bench.PassTicks(kPassed);
  }
  if (instant == FaultInstant::kBehindTheRun) bench.ExpectGoodWindow();
  const KnownOfLaser known = KnownOf(bench);
  if (!bench.rig().Inflict(fault)) return;
  bench.StepFor(1s);
  bench.rig().Relieve(fault);
  Expect(bench.Until([&] { return bench.driver().up(); }, 5s),
         "L14: the line does not come back: " + bench.driver().message());
  bench.StepFor(500ms);
  bench.ExpectNoPulseFor(2s, "L14: it goes on by itself");
  // A grbl stays enabled (M4) in a hold, dark: its shutter is what it is commanded to be.
  Expect(bench.driver().status().shutters_open == 0, "L14: a shutter is open");
  const bool of_line = fault == ControllerFault::kUnplug;
  Expect((KnownOf(bench) == known) == of_line,
         of_line ? "L14: a lost line is reported as a stop of the controller"
                 : "L14: a stop of the controller is not counted");
  bench.ExpectGoodWindow();
}

}  // namespace

std::vector<LaserCheck> LaserFaultChecks() {
  std::vector<LaserCheck> all;
  for (const ControllerFault fault : kControllerFaults) {
    for (const FaultInstant instant : kFaultInstants) {
      all.push_back({fmt::format("L14_{}_{}", NameOf(fault), NameOf(instant)),
                     [fault, instant](const LaserRigMaker& make) {
                       AFaultIsCountedAndNothingFires(make, fault, instant);
                     }});
    }
  }
  return all;
}

}  // namespace intaglio::drivers
