// The edges of the reference controller's outputs against what its host commanded.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/services/drivers/laser_bench.h"
#include "tests/services/reference_controller/reference_rig.h"

namespace intaglio::reference_controller {
namespace {

using namespace std::chrono_literals;
using drivers::LaserBench;
using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Ge;
using ::testing::Le;

class ControllerEdges : public ::testing::Test {
 protected:
  void Start(const SimulatedPinsOptions& pins, double delay_us = 5,
             double width_us = 120) {
    const ReferenceRigOptions options{pins, delay_us, width_us};
    bench = std::make_unique<LaserBench>([options](const std::string& serial_number) {
      return std::make_unique<ReferenceRig>(serial_number, options);
    });
  }
  ReferenceRig& rig() { return dynamic_cast<ReferenceRig&>(bench->rig()); }
  std::vector<Edge> EdgesOf(Output output) {
    std::vector<Edge> of;
    for (const Edge& edge : rig().edges())
      if (edge.output == output) of.push_back(edge);
    return of;
  }
  /// From each edge on to the next edge off, us.
  std::vector<double> WidthsOf(Output output) {
    std::vector<double> widths;
    const std::vector<Edge> edges = EdgesOf(output);
    for (std::size_t i = 0; i + 1 < edges.size(); i += 2)
      widths.push_back(1e-3 *
                       static_cast<double>((edges[i + 1].at - edges[i].at).count()));
    return widths;
  }
  /// From the lamp trigger to each trigger of the Q-switch behind it, us.
  std::vector<double> DelaysOfTheTrigger() {
    std::vector<double> delays;
    std::chrono::nanoseconds lamp{0};
    for (const Edge& edge : rig().edges()) {
      if (!edge.on) continue;
      if (edge.output == Output::kLampTrigger) lamp = edge.at;
      if (edge.output == Output::kQSwitch)
        delays.push_back(1e-3 * static_cast<double>((edge.at - lamp).count()));
    }
    return delays;
  }
  void Prepare(std::uint8_t shutters) {
    bench->Connect();
    ASSERT_TRUE(bench->driver().Lamp(true, 100).has_value());
    ASSERT_TRUE(bench->driver().OpenShutters(shutters).has_value());
    ASSERT_TRUE(bench->Until([&] {
      return bench->driver().Has(link::kLampWarm) &&
             bench->driver().status().shutters_open == shutters;
    }));
  }
  std::map<std::uint64_t, unsigned> MissedOfReports() {
    std::map<std::uint64_t, unsigned> missed;
    for (const link::PulseReport& report : rig().reports) {
      for (std::size_t i = 0; i < report.outcome.size(); ++i) {
        if (link::HasFired(report.outcome[i]))
          missed[report.first_tick + i] = report.missed.empty() ? 0 : report.missed[i];
      }
    }
    return missed;
  }

  std::unique_ptr<LaserBench> bench;
};

TEST_F(ControllerEdges, AreOffUntilAHostCommandsAndWhenTheControllerIsGone) {
  Start({4});
  bench->StepFor(100ms);
  EXPECT_TRUE(rig().edges().empty()) << "an output was on before any command";
  Prepare(0b1111);
  EXPECT_EQ(rig().shutters(), 0b1111);
  rig().SwitchOff();
  std::map<Output, bool> last;
  for (const Edge& edge : rig().edges()) last[edge.output] = edge.on;
  EXPECT_EQ(last.size(), 6u);  // shutters, lamp and its trigger
  for (const auto& [output, on] : last) EXPECT_FALSE(on) << static_cast<int>(output);
}

class ControllerAccessories : public ControllerEdges {
 protected:
  ControllerAccessories() {
    ReferenceRigOptions options;
    options.pins.output_count = 2;
    options.pins.input_count = 1;
    MachineOutput& air = *options.named.add_outputs();
    air.set_name("air");
    air.set_output(2);
    MachineInput& clamp = *options.named.add_inputs();
    clamp.set_name("clamp");
    clamp.set_input(1);
    clamp.set_remedy("close it");
    bench = std::make_unique<LaserBench>([options](const std::string& serial_number) {
      return std::make_unique<ReferenceRig>(serial_number, options);
    });
  }
  bool IsOn() { return rig().is_on(SpareOutput(1)); }
  bool SwitchOn() {
    EXPECT_TRUE(bench->driver().SwitchOutputs(0b10).has_value());
    return bench->Until(
        [&] { return IsOn() && bench->driver().accessories().on_names == "air"; });
  }
};

TEST_F(ControllerAccessories, AreLinesOfTheBoardThatEveryStopSwitchesOff) {
  bench->Connect();
  EXPECT_EQ(bench->driver().accessories().open_input, "");
  EXPECT_TRUE(SwitchOn());
  EXPECT_FALSE(rig().is_on(SpareOutput(0)));
  rig().Set(drivers::LaserRig::Interlock::kDoor, false);
  EXPECT_FALSE(IsOn());
  rig().Set(drivers::LaserRig::Interlock::kDoor, true);
  bench->StepFor(100ms);
  EXPECT_FALSE(IsOn()) << "nobody has commanded it";
  EXPECT_TRUE(SwitchOn());
  rig().CutLine(true);
  bench->StepFor(300ms);
  EXPECT_FALSE(IsOn()) << "the host is silent";
  rig().CutLine(false);
  bench->Connect();
  EXPECT_FALSE(IsOn());
  ASSERT_TRUE(bench->driver().Reset().has_value());
  EXPECT_TRUE(SwitchOn());
  rig().SwitchOff();
  std::map<Output, bool> last;
  for (const Edge& edge : rig().edges()) last[edge.output] = edge.on;
  EXPECT_FALSE(last.at(SpareOutput(1)));
}

TEST_F(ControllerAccessories, AnInputThatDropsLetsNothingFire) {
  Prepare(1);
  EXPECT_TRUE(SwitchOn());
  const std::uint32_t openings = bench->driver().status().openings;
  rig().SetInput(0, false);
  EXPECT_FALSE(IsOn());
  (void)bench->Arm(5, {true, true, true});
  bench->PassTicks(20);
  EXPECT_TRUE(rig().FiredTicks().empty());
  EXPECT_EQ(bench->driver().status().openings, openings + 1);
  EXPECT_EQ(bench->driver().accessories().open_input,
            "the input 'clamp' is off: close it");
  rig().SetInput(0, true);
  const auto armed = bench->Arm(5, {true, true, true});
  bench->PassTicks(20);
  EXPECT_EQ(rig().FiredTicks(), armed);
}

// The plan is the oracle: as many triggers, at its ticks, with its delay and width.
TEST_F(ControllerEdges, TriggerAtEachArmedTickWithTheCommandedDelayAndWidth) {
  Start({4}, 12, 150);
  Prepare(0b0001);
  const std::vector<bool> plan = {true, false, true, true, false, true};
  const auto armed = bench->Arm(5, plan);
  bench->PassTicks(20);
  EXPECT_EQ(rig().FiredTicks(), armed);
  // The clock of the test stops between two calls; an edge is exact.
  EXPECT_THAT(DelaysOfTheTrigger(), Each(12));
  EXPECT_THAT(WidthsOf(Output::kQSwitch), Each(150));
  EXPECT_EQ(EdgesOf(Output::kQSwitch).size(), 2 * armed.size());
  const std::vector<Edge> lamp = EdgesOf(Output::kLampTrigger);
  ASSERT_GE(lamp.size(), 40u);
  for (std::size_t i = 2; i < lamp.size(); i += 2)
    EXPECT_EQ(lamp[i].at - lamp[i - 2].at, 10ms) << i;
}

TEST_F(ControllerEdges, NothingIsTriggeredWithoutAWindow) {
  Start({4});
  Prepare(0b1111);
  bench->StepFor(1s);
  EXPECT_TRUE(EdgesOf(Output::kQSwitch).empty());
}

TEST_F(ControllerEdges, TheGateOfTheStageDecidesAtTheTick) {
  Start({1});
  Prepare(1);
  rig().HoldInPosition(true);
  const auto armed = bench->Arm(5, std::vector<bool>(20, true), true);
  bench->PassTicks(15);
  rig().HoldInPosition(false);
  const auto fired = rig().FiredTicks();
  bench->PassTicks(20);
  EXPECT_GE(fired.size(), 9u);
  EXPECT_LT(fired.size(), armed.size());
  EXPECT_EQ(rig().FiredTicks(), fired);
}

// A stage that hangs leaves its output on; the next points would come at the same place.
TEST_F(ControllerEdges, NothingPassesTheGateOfAStageThatHangs) {
  Start({1});
  Prepare(1);
  rig().HoldInPosition(true);
  const auto armed = bench->Arm(5, std::vector<bool>(20, true), true);
  bench->PassTicks(15);
  rig().StageHangs();
  const auto fired = rig().FiredTicks();
  bench->PassTicks(20);
  EXPECT_GE(fired.size(), 9u);
  EXPECT_LT(fired.size(), armed.size());
  EXPECT_EQ(rig().FiredTicks(), fired);
}

// The host has placed the ticks on the clock of the stage, which would be at the next
// point by now.
TEST_F(ControllerEdges, NothingPassesTheGateBehindALateTickBeforeTheNextRun) {
  Start({1});
  Prepare(1);
  rig().HoldInPosition(true);
  (void)bench->Arm(5, std::vector<bool>(250, true), true);
  bench->PassTicks(15);
  rig().Stall(15ms);
  const auto fired = rig().FiredTicks();
  EXPECT_GE(fired.size(), 9u);
  bench->PassTicks(20);
  // Its ticks are placed as the ones before were.
  rig().StageBeginsARun();
  bench->PassTicks(150);
  EXPECT_EQ(rig().FiredTicks(), fired);
  rig().StageBeginsARun();
  bench->PassTicks(10);
  EXPECT_GE(rig().FiredTicks().size(), fired.size() + 9);
}

TEST_F(ControllerEdges, EachPhotosensorSpeaksForItsChannel) {
  Start({.channels = 4, .blind_channels = 0b0100});
  Prepare(0b0110);
  const auto armed = bench->Arm(5, {true, true});
  bench->PassTicks(15);
  bench->StepFor(100ms);
  EXPECT_EQ(MissedOfReports(),
            (std::map<std::uint64_t, unsigned>{{armed[0], 0b0100}, {armed[1], 0b0100}}));
}

TEST_F(ControllerEdges, ATickBeginsWithTheLampSyncOfTheLaser) {
  Start({.channels = 1, .has_lamp_sync = true, .sync_after = 7us});
  Prepare(1);
  const auto armed = bench->Arm(5, {true, false, true});
  bench->PassTicks(15);
  EXPECT_EQ(rig().FiredTicks(), armed);
  // 7 us to the sync, 5 us from it, and up to 1 us until the sync is seen.
  EXPECT_THAT(DelaysOfTheTrigger(), Each(AllOf(Ge(12.0), Le(13.0))));
}

TEST_F(ControllerEdges, ALaserThatFlashesByItselfIsFollowed) {
  Start({.channels = 1, .flash_period = 10ms});
  Prepare(1);
  const auto armed = bench->Arm(5, {true, false, true, true});
  bench->PassTicks(15);
  EXPECT_EQ(rig().FiredTicks(), armed);
  EXPECT_TRUE(EdgesOf(Output::kLampTrigger).empty());
  std::vector<std::chrono::nanoseconds> fired;
  for (const Edge& edge : EdgesOf(Output::kQSwitch))
    if (edge.on) fired.push_back(edge.at);
  ASSERT_EQ(fired.size(), 3u);
  EXPECT_EQ(fired[1] - fired[0], 20ms);
  EXPECT_EQ(fired[2] - fired[1], 10ms);
  // A cold lamp has no sync, so no tick passes.
  ASSERT_TRUE(bench->driver().Lamp(false, 100).has_value());
  bench->StepFor(50ms);
  const std::uint64_t tick = bench->tick();
  bench->StepFor(200ms);
  EXPECT_EQ(bench->tick(), tick);
}

// A sync that came so late that the trigger would be outside of the laser's time.
TEST_F(ControllerEdges, ATriggerThatWouldBeTooLateIsWithheldAndReportedAsNoPulse) {
  Start({1}, 20);
  Prepare(1);
  bench->Arm(5, {true});
  bench->PassTicks(10);
  EXPECT_EQ(EdgesOf(Output::kQSwitch).size(), 2u) << "20 us are within the laser's time";
  rig().DelayWaits(1us);
  const std::uint64_t pulses = bench->driver().status().pulse_count;
  const auto armed = bench->Arm(5, {true});
  bench->PassTicks(10);
  bench->StepFor(100ms);
  EXPECT_EQ(EdgesOf(Output::kQSwitch).size(), 2u);
  EXPECT_EQ(bench->Outcomes()[armed[0]], link::TickOutcome::kTriggerOutside);
  EXPECT_EQ(bench->driver().status().pulse_count, pulses);
}

TEST_F(ControllerEdges, ABoardThatFailsSwitchesEverythingOff) {
  Start({2});
  Prepare(0b11);
  bench->Arm(5, std::vector<bool>(50, true));
  bench->PassTicks(10);
  rig().BreakBoard();
  bench->StepFor(20ms);
  EXPECT_EQ(rig().error(), "the board is broken");
  const auto fired = rig().FiredTicks();
  bench->StepFor(300ms);
  EXPECT_EQ(rig().FiredTicks(), fired);
  EXPECT_TRUE(rig().controller().laser().Report().interlocks & link::kSafeState);
}

// The retriggerable monostable of the gate has 50 ms.
TEST_F(ControllerEdges, AliveChangesWhileTheProgramTurnsAndNoLonger) {
  Start({1});
  const std::uint64_t before = rig().pins().alive_count();
  bench->StepFor(100ms);
  EXPECT_GE(rig().pins().alive_count(), before + 50);
}

}  // namespace
}  // namespace intaglio::reference_controller
