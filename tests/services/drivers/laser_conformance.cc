#include "tests/services/drivers/laser_conformance.h"

#include <array>

#include "tests/services/drivers/laser_bench.h"

namespace intaglio::drivers {
namespace {

using link::TickOutcome;
using namespace std::chrono_literals;
using Interlock = LaserRig::Interlock;

const std::vector<bool> kPattern = {true,  false, true, true,  false,
                                    false, true,  true, false, true};
const std::vector<bool> kLong(200, true);

void WhatIsArmedFiresOnceAndIsReported(const LaserRigMaker& make) {
  LaserBench bench(make);
  Expect(!bench.driver().up() && !bench.driver().Arm({5, false, {true}}),
         "L1: commands are taken before the line is up");
  bench.ConnectAndPrepare();
  bench.ExpectNoPulseFor(500ms, "L2: a tick that nobody armed");
  const std::uint64_t first = bench.tick() + 10;
  const Ticks armed = bench.Arm(10, kPattern);
  bench.PassTicks(30);
  bench.StepFor(kReportTime);
  bench.ExpectFired(armed, "L2");
  const auto outcomes = bench.Outcomes();
  Expect(outcomes.size() == kPattern.size(), "L4: not every decided tick is reported");
  for (std::size_t i = 0; i < kPattern.size(); ++i) {
    const auto outcome = outcomes.find(first + i);
    Expect(outcome != outcomes.end(), "L4: a decided tick is not reported");
    Expect((outcome->second == bench.fired()) == kPattern[i],
           fmt::format("L4: tick {} is reported as {}", first + i,
                       static_cast<int>(outcome->second)));
  }
  Expect(bench.driver().status().pulse_count == armed.size(),
         fmt::format("L5: {} pulses are counted of {}",
                     bench.driver().status().pulse_count, armed.size()));
  bench.ExpectRemembers(first - 5, 20);
  bench.ExpectGoodWindow();
}

void NothingThatIsArmedAgainFiresAgain(const LaserRigMaker& make) {
  LaserBench bench(make);
  bench.ConnectAndPrepare();
  const std::uint64_t first = bench.tick() + 10;
  const link::ArmWindow window{first, false, kPattern, false, bench.energy_mj()};
  for (int i = 0; i < 3; ++i) Expect(bench.driver().Arm(window).has_value(), "Arm");
  bench.PassTicks(30);
  const Ticks fired = bench.rig().FiredTicks();
  Expect(fired.size() == 6,
         fmt::format("L2: {} pulses of 6 that were armed thrice", fired.size()));
  bench.rig().reports.clear();
  Expect(bench.driver().Arm(window).has_value(), "Arm");
  bench.ExpectNoPulseFor(500ms, "L2, L4: a window that came too late");
  std::size_t late = 0;
  for (const link::PulseReport& report : bench.rig().reports)
    late += static_cast<std::size_t>(
        std::count(report.outcome.begin(), report.outcome.end(), TickOutcome::kTooLate));
  Expect(late == 6, fmt::format("L4: {} of 6 late ticks are reported", late));
}

void WithoutTheGateNothingFires(const LaserRigMaker& make) {
  LaserBench bench(make);
  bench.ConnectAndPrepare();
  bench.Arm(10, kPattern, true);
  bench.ExpectNoPulseFor(500ms, "L2: a gated tick, the stage not being in position");
}

void DisarmLeavesNothing(const LaserRigMaker& make) {
  LaserBench bench(make);
  bench.ConnectAndPrepare();
  bench.Arm(5, kLong);
  bench.PassTicks(20);
  Expect(bench.driver().Disarm().has_value(), "Disarm is refused");
  Expect(!bench.driver().disarmed(),
         "L3: disarmed before the controller has reported it");
  Expect(
      bench.Until([&] { return bench.driver().disarmed(); }, bench.rig().disarm_time()),
      "L3: a Disarm is not confirmed");
  bench.ExpectNoPulseFor(500ms, "L3: pulses after a confirmed Disarm");
  Expect(bench.rig().shutters() == 1, "L3: Disarm is no fault");
  bench.ExpectGoodWindow();
}

void StopHoldsUntilReset(const LaserRigMaker& make) {
  LaserBench bench(make);
  bench.ConnectAndPrepare();
  bench.Arm(5, kLong);
  bench.PassTicks(20);
  Expect(bench.driver().Stop().has_value(), "Stop is refused");
  bench.StepFor(10ms);
  bench.ExpectNoPulseFor(500ms, "L3: pulses after Stop");
  Expect(bench.rig().shutters() == 0 && !bench.driver().Has(link::kStopReleased),
         "L3: a stop is not held");
  (void)bench.driver().OpenShutters(1);
  bench.Arm(5, kPattern);
  bench.ExpectNoPulseFor(500ms, "L3: pulses before Reset");
  bench.ExpectGoodWindow();
}

void AnInterlockLetsNoPulsePass(const LaserRigMaker& make) {
  for (const auto& [interlock, bit] :
       {std::pair(Interlock::kKey, link::kKeyOn),
        std::pair(Interlock::kDoor, link::kDoorClosed),
        std::pair(Interlock::kStopButton, link::kStopReleased)}) {
    LaserBench bench(make);
    bench.ConnectAndPrepare();
    const std::uint32_t openings = bench.driver().status().openings;
    bench.Arm(5, kLong);
    bench.PassTicks(20);
    bench.rig().Set(interlock, false);
    bench.ExpectNoPulseFor(500ms, "L9: pulses while an interlock is open");
    Expect(!bench.driver().Has(bit), "L9: an open interlock is not reported");
    bench.rig().CutLine(true);
    bench.rig().Set(interlock, true);
    bench.rig().Set(interlock, false);
    bench.rig().Set(interlock, true);
    bench.StepFor(1s);
    bench.rig().CutLine(false);
    bench.Connect();
    Expect(bench.driver().status().openings == openings + 2,
           "L9: lettings go are not counted");
    bench.ExpectNoPulseFor(500ms, "L9: pulses come back by themselves");
    bench.ExpectGoodWindow();
  }
}

void LampAndShutterAreNeeded(const LaserRigMaker& make) {
  LaserBench bench(make);
  bench.ConnectAndPrepare();
  Expect(bench.driver().OpenShutters(0).has_value(), "OpenShutters is refused");
  bench.Arm(5, kPattern);
  bench.ExpectNoPulseFor(300ms, "L10: pulses behind a closed shutter");
  Expect(bench.driver().status().shutters_open == 0, "L10: a closed shutter is open");
  Expect(bench.driver().OpenShutters(1).has_value() &&
             bench.driver().Lamp(false, bench.rig().rate_hz()).has_value(),
         "Lamp is refused");
  bench.Arm(5, kPattern);
  bench.ExpectNoPulseFor(300ms, "L10: pulses without a lamp");
  Expect(!bench.driver().Has(link::kLampOn) && !bench.driver().Has(link::kLampWarm),
         "L10: a lamp that is off is reported on");
  bench.ExpectGoodWindow();
}

/// After a cut of the line that is over.
void ExpectRecovery(LaserBench& bench, std::uint64_t session, std::uint64_t first_armed) {
  bench.rig().CutLine(false);
  bench.Connect();
  Expect(bench.driver().session() > session, "L8: the session is the one before");
  bench.ExpectNoPulseFor(1s, "L8: pulses come back by themselves");
  Expect(bench.rig().shutters() == 0, "L8: the shutters open by themselves");
  bench.ExpectRemembers(first_armed, 200);
  const std::uint64_t count = bench.driver().status().pulse_count;
  Expect(count == bench.rig().FiredTicks().size(),
         fmt::format("L5: {} pulses are counted of {}", count,
                     bench.rig().FiredTicks().size()));
  bench.ExpectGoodWindow();
}

void ACutLineClosesTheLaser(const LaserRigMaker& make) {
  LaserBench bench(make);
  bench.ConnectAndPrepare();
  const std::uint64_t session = bench.driver().session();
  const Ticks armed = bench.Arm(5, kLong);
  bench.PassTicks(20);
  bench.rig().CutLine(true);
  const std::uint64_t cut_tick = bench.tick();
  Expect(bench.Until([&] { return !bench.driver().up(); }, 300ms),
         "L7: a cut line is up");
  Expect(!bench.driver().Arm({bench.tick() + 50, false, kPattern}) &&
             !bench.driver().OpenShutters(1) && !bench.driver().RequestPast(1, 1),
         "L1: a lost line takes commands");
  Expect(!bench.driver().message().empty(), "L7: a lost line has no message");
  bench.StepFor(1s);
  const Ticks fired = bench.rig().FiredTicks();
  const auto allowed = static_cast<std::uint64_t>(0.25 * bench.rig().rate_hz()) + 1;
  Expect(!fired.empty() && fired.back() <= cut_tick + allowed,
         "L7: the laser fires on without a host");
  Expect(bench.rig().shutters() == 0, "L7: the shutters are open without a host");
  ExpectRecovery(bench, session, armed.front());
}

// In the middle of a window, too.
void ALineCutAtAnyByteClosesTheLaser(const LaserRigMaker& make) {
  for (std::uint64_t bytes = 0; bytes < 300; bytes += 17) {
    LaserBench bench(make);
    bench.ConnectAndPrepare();
    const std::uint64_t session = bench.driver().session(), cut_tick = bench.tick();
    bench.rig().CutLineAfter(bytes);
    Ticks armed;
    for (const std::uint64_t ahead : {5, 15, 25}) {
      for (const std::uint64_t at : bench.Arm(ahead, kPattern)) armed.push_back(at);
    }
    bench.StepFor(1s);
    const Ticks fired = bench.rig().FiredTicks();
    Expect(std::includes(armed.begin(), armed.end(), fired.begin(), fired.end()),
           "L2: a tick fires that nobody armed, or twice");
    Expect(bench.rig().shutters() == 0, "L7: the shutters are open without a host");
    ExpectRecovery(bench, session, cut_tick + 1);
  }
}

void TheNewestTicksAreRemembered(const LaserRigMaker& make) {
  LaserBench bench(make);
  bench.ConnectAndPrepare();
  const Ticks armed = bench.Arm(10, kPattern);
  bench.PassTicks(30);
  Expect(bench.driver().Lamp(true, bench.rig().fast_rate_hz()).has_value(), "Lamp");
  bench.PassTicks(link::kRememberedTicks - 200);
  bench.ExpectRemembers(armed.front(), 20);
}

void NoEnergyOutsideTheRangeFires(const LaserRigMaker& make) {
  LaserBench bench(make);
  bench.ConnectAndPrepare();
  const double max_mj = bench.energy_mj(),
               min_mj = bench.driver().identity().min_energy_mj;
  Expect(max_mj > 0, "L13: the identity has no energy");
  for (const double mj : {0.0, min_mj / 2, max_mj * 1.01}) {
    const Status armed =
        bench.driver().Arm({bench.tick() + 10, false, kPattern, false, mj});
    Expect(armed || armed.error().code == ErrorCode::kUnsupported,
           fmt::format("L13: {} mJ is refused otherwise", mj));
    bench.ExpectNoPulseFor(500ms, fmt::format("L13: a pulse of {} mJ", mj));
    // They may come early, as late ones do: the window was not taken.
    for (const link::PulseReport& report : bench.rig().reports)
      for (const TickOutcome outcome : report.outcome)
        Expect(
            outcome == TickOutcome::kEnergyOutside || outcome == TickOutcome::kNotArmed,
            fmt::format("L13: a pulse of {} mJ is reported as {}", mj,
                        static_cast<int>(outcome)));
    bench.rig().reports.clear();
  }
  bench.ExpectGoodWindow();
}

void APowerCycleIsAnotherClock(const LaserRigMaker& make) {
  LaserBench bench(make);
  bench.ConnectAndPrepare();
  bench.Arm(5, kLong);
  bench.PassTicks(20);
  const std::uint32_t power_up = bench.driver().identity().power_up;
  bench.rig().PowerCycle();
  Expect(!bench.driver().up(), "L7: a controller without power is up");
  bench.Connect();
  Expect(bench.driver().identity().power_up != power_up,
         "L11: the power-up is the one before");
  Expect(bench.driver().status().pulse_count == 0, "L11: pulses of before are counted");
  bench.ExpectNoPulseFor(1s, "L11: what was armed before fires");
  bench.ExpectGoodWindow();
}

void AnotherControllerIsClosed(const LaserRigMaker& make) {
  LaserBench bench(make, "another");
  Expect(bench.Until([&] { return !bench.driver().refusal().empty(); }),
         "L12: it is not refused");
  bench.StepFor(kReportTime);
  Expect(!bench.driver().up() && !bench.driver().CanSend(), "L12: it is up");
  Expect(!bench.driver().Arm({bench.tick() + 5, false, kPattern}) &&
             !bench.driver().OpenShutters(1) &&
             !bench.driver().Lamp(true, bench.rig().rate_hz()),
         "L12: it takes commands");
  bench.ExpectNoPulseFor(500ms, "L12: it fires");
  Expect(bench.rig().shutters() == 0 && !bench.rig().lamp_on(), "L12: it is not closed");
}

std::vector<LaserCheck> AllLaserChecks() {
  std::vector<LaserCheck> all = {
      {"L1L2L4L5_armed", &WhatIsArmedFiresOnceAndIsReported},
      {"L2L4_armed_again", &NothingThatIsArmedAgainFiresAgain},
      {"L2_gate", &WithoutTheGateNothingFires},
      {"L3_disarm", &DisarmLeavesNothing},
      {"L3_stop", &StopHoldsUntilReset},
      {"L9_interlocks", &AnInterlockLetsNoPulsePass},
      {"L10_lamp_and_shutter", &LampAndShutterAreNeeded},
      {"L7L8_cut", &ACutLineClosesTheLaser},
      {"L7_cut_at_any_byte", &ALineCutAtAnyByteClosesTheLaser},
      {"L6_memory", &TheNewestTicksAreRemembered},
      {"L11_power_cycle", &APowerCycleIsAnotherClock},
      {"L13_energy", &NoEnergyOutsideTheRangeFires},
      {"L12_another_controller", &AnotherControllerIsClosed},
  };
  for (const LaserCheck& check : LaserFaultChecks()) all.push_back(check);
  return all;
}

}  // namespace

std::span<const LaserCheck> LaserChecks() {
  static const std::vector<LaserCheck> checks = AllLaserChecks();
  return checks;
}

std::string ViolationOf(const LaserCheck& check, const LaserRigMaker& make) {
  try {
    check.run(make);
    return "";
  } catch (const std::runtime_error& violation) {
    return violation.what();
  }
}

}  // namespace intaglio::drivers
