#include "services/virtual_engraver/machine.h"

#include "tests/services/virtual_engraver/machine_bench.h"
#include "tests/services/virtual_engraver/stage_path.h"

namespace intaglio::virtual_engraver {
namespace {

using link::LaserFrame;
using link::MotionFrame;
using link::TickOutcome;
using namespace std::chrono_literals;

/// A row of points along x, one every other tick at 10 mm/s, with a lead-in and a
/// lead-out: the point number i lies at (0.5 + 0.2 i, 5, 60) mm, machine frame.
class PointRow : public MachineBench {
 protected:
  static constexpr int kPoints = 60;
  static constexpr std::uint64_t kFirstPulse = 40;  // its tick

  static Vec3 PointMm(int i) { return {0.5 + 0.2 * i, 5, 60}; }

  /// Where the stage is to go before the row: z is high, the block is 100 mm.
  void SendMotionOfRow(bool with_pulses = true) {
    std::vector<Knot> knots = {{{200, 5000, 60000}, {0, 0, 0}, 30 * kTick},
                               {{500, 5000, 60000}, {10000, 0, 0}, 7 * kTick}};
    knots.back().pulse = with_pulses;
    for (int i = 1; i < kPoints; ++i) {
      knots.push_back({1000 * PointMm(i), {10000, 0, 0}, 2 * kTick, with_pulses});
    }
    knots.push_back(
        {1000 * PointMm(kPoints) + Vec3(100, 0, 0), {0, 0, 0}, 6 * kTick, false, true});
    SendMotion(MotionFrame::kBeginRun, Encode(link::BeginRun{1, kStartTick}));
    for (std::size_t at = 0; at < knots.size(); at += link::kMaxSegments) {
      const std::size_t end = std::min(at + link::kMaxSegments, knots.size());
      const std::vector<Knot> part(knots.begin() + static_cast<std::ptrdiff_t>(at),
                                   knots.begin() + static_cast<std::ptrdiff_t>(end));
      SendMotion(MotionFrame::kSegments, Encode(Frame(part, at)));
    }
  }
  static std::vector<bool> FirePattern() {
    std::vector<bool> fire(kFirstPulse + 2 * kPoints + 30, false);
    for (int i = 0; i < kPoints; ++i)
      fire[kFirstPulse - 1 + 2 * static_cast<std::size_t>(i)] = true;
    return fire;
  }
  /// Decides every tick from 1, in windows of uneven length.
  void SendWindows(const std::vector<bool>& fire, bool gated = true) {
    std::size_t length = 1;
    for (std::size_t at = 0; at < fire.size(); at += length) {
      length = std::min<std::size_t>(1 + at % 23, fire.size() - at);
      const auto from = fire.begin() + static_cast<std::ptrdiff_t>(at);
      SendLaser(LaserFrame::kArmWindow,
                Encode(link::ArmWindow{
                    at + 1, gated, {from, from + static_cast<std::ptrdiff_t>(length)}}));
    }
  }
};

TEST_F(PointRow, CracksAreAtTheirTicksAndPlaces) {
  for (const double lag_s : {0.0, 0.0005}) {
    MachineOptions options = PlainOptions(true);
    options.stage.mechanics.lag_s = lag_s;
    options.block.refractive_index = 1;  // the beam has a test of its own
    Start(options);
    Connect();
    OpenShutterAndLamp();
    SendMotionOfRow();
    SendWindows(FirePattern());
    Pass(300ms);
    const auto cracks = Cracks();
    ASSERT_EQ(cracks.size(), static_cast<std::size_t>(kPoints));
    for (int i = 0; i < kPoints; ++i) {
      const auto& crack = cracks[static_cast<std::size_t>(i)];
      EXPECT_EQ(crack.tick, kFirstPulse + 2 * static_cast<std::uint64_t>(i));
      // At 10 mm/s the stage is 10 mm/s * lag behind; at the first point it has just
      // sped up with 204 mm/s^2, which takes lag^2 of that away, 0.05 um.
      const Vec3 off = crack.position_mm - (PointMm(i) - Vec3(10 * lag_s, 0, 0));
      EXPECT_LT(off.norm(), i == 0 ? 6e-5 : 1e-8) << i;
      EXPECT_TRUE(crack.in_glass);
      EXPECT_EQ(crack.channel, 0);
    }
    EXPECT_EQ(machine->laser().Report().pulse_count, static_cast<std::uint64_t>(kPoints));
  }
}

TEST_F(PointRow, TheHostReceivesEveryTickAndPosition) {
  Start(PlainOptions(true));
  Connect();
  ASSERT_EQ(received.laser_identities.size(), 1u);
  ASSERT_EQ(received.motion_identities.size(), 1u);
  EXPECT_TRUE(received.laser_identities[0].lockstep);
  OpenShutterAndLamp();
  SendMotionOfRow();
  const auto fire = FirePattern();
  SendWindows(fire);
  Pass(300ms);
  std::uint64_t next = 1;
  for (const link::PulseReport& report : received.reports) {
    EXPECT_EQ(report.first_tick, next);
    for (const TickOutcome outcome : report.outcome) {
      EXPECT_EQ(outcome,
                fire[next - 1] ? TickOutcome::kFiredSeen : TickOutcome::kNotArmed)
          << next;
      ++next;
    }
  }
  EXPECT_EQ(next, fire.size() + 1);
  std::uint64_t latched = 0;
  for (const link::Positions& frame : received.positions)
    latched += frame.positions.size();
  EXPECT_EQ(latched, 30u + 7 + 2 * (kPoints - 1) + 6);
  ASSERT_FALSE(received.laser_statuses.empty());
  EXPECT_EQ(received.laser_statuses.back().tick, fire.size());
  EXPECT_EQ(received.laser_statuses.back().pulse_count,
            static_cast<std::uint64_t>(kPoints));
  EXPECT_TRUE(received.motion_statuses.back().at_rest);
}

TEST_F(PointRow, NothingFiresUnlessArmed) {
  Start(PlainOptions(true));
  Connect();
  OpenShutterAndLamp();
  SendMotionOfRow();
  SendWindows(std::vector<bool>(FirePattern().size(), false));
  Pass(300ms);
  EXPECT_EQ(machine->laser().tick(), FirePattern().size());
  EXPECT_TRUE(Cracks().empty());
  EXPECT_EQ(machine->laser().Report().pulse_count, 0u);
}

TEST_F(PointRow, NothingFiresUnlessTheStageAllowsIt) {
  Start(PlainOptions(true));
  Connect();
  OpenShutterAndLamp();
  SendMotionOfRow(false);
  SendWindows(FirePattern());
  Pass(300ms);
  EXPECT_EQ(machine->laser().tick(), FirePattern().size());
  EXPECT_TRUE(Cracks().empty());
}

TEST_F(PointRow, NothingFiresWithAClosedShutter) {
  Start(PlainOptions(true));
  Connect();
  SendLaser(LaserFrame::kLampCommand, Encode(link::LampCommand{true, 100}));
  SendMotionOfRow();
  SendWindows(FirePattern());
  Pass(300ms);
  EXPECT_EQ(machine->laser().tick(), FirePattern().size());
  EXPECT_TRUE(Cracks().empty());
}

TEST_F(PointRow, LockstepWaitsForDecisionsAndForMotion) {
  Start(PlainOptions(true));
  Connect();
  OpenShutterAndLamp();
  Pass(200ms);
  EXPECT_EQ(machine->laser().tick(), 0u) << "no tick is decided";
  SendWindows(std::vector<bool>(20, false));
  Pass(50ms);
  EXPECT_EQ(machine->laser().tick(), 20u) << "a stage without a run holds nothing up";
  SendMotion(MotionFrame::kBeginRun, Encode(link::BeginRun{1, 25}));
  Pass(10ms);
  SendLaser(LaserFrame::kArmWindow,
            Encode(link::ArmWindow{21, true, std::vector<bool>(20, false)}));
  Pass(50ms);
  EXPECT_EQ(machine->laser().tick(), 25u) << "a run without motion does";
  SendMotion(MotionFrame::kSegments,
             Encode(Frame({{{10, 0, 0}, {0, 0, 0}, 4 * kTick, false, true}})));
  Pass(50ms);
  EXPECT_EQ(machine->laser().tick(), 40u);
  EXPECT_EQ(machine->stage().Report().fault, link::StageFault::kNone);
}

// However many ticks are passed at once.
TEST_F(PointRow, StopsAtTheTickOfAPlannedFault) {
  Start(PlainOptions(true));
  Connect();
  machine->StopAt(700);
  SendLaser(link::LaserFrame::kArmWindow,
            Encode(link::ArmWindow{1, true, std::vector<bool>(1500, false)}));
  Pass(50ms);
  EXPECT_EQ(machine->laser().tick(), 700u);
  machine->StopAt(UINT64_MAX);
  Pass(50ms);
  EXPECT_EQ(machine->laser().tick(), 1500u);
}

TEST_F(PointRow, MissesAsManyPulsesAsCommanded) {
  MachineOptions options = PlainOptions(true);
  options.laser.channels = 2;
  options.block.refractive_index = 1;  // the stage's zero is in the glass
  Start(options);
  Connect();
  OpenShutterAndLamp();
  SendLaser(LaserFrame::kShutterCommand, Encode(link::ShutterCommand{3}));
  machine->MissPulses(2);
  machine->MissPulses(1);
  SendWindows(std::vector<bool>(5, true), false);
  Pass(50ms);
  // Both channels of a pulse are missed; the pulse counts all the same.
  const auto cracks = Cracks();
  ASSERT_EQ(cracks.size(), 4u);
  EXPECT_EQ(cracks[0].tick, 4u);
  EXPECT_EQ(cracks[0].channel, 0);
  EXPECT_EQ(cracks[1].channel, 1);
  EXPECT_EQ(cracks[3].tick, 5u);
  EXPECT_EQ(machine->laser().Report().pulse_count, 5u);
  std::vector<TickOutcome> outcomes;
  for (const auto& report : received.reports)
    outcomes.insert(outcomes.end(), report.outcome.begin(), report.outcome.end());
  const auto seen = TickOutcome::kFiredSeen, unseen = TickOutcome::kFiredUnseen;
  EXPECT_EQ(outcomes, (std::vector{unseen, unseen, unseen, seen, seen}));
}

TEST_F(PointRow, ABlindSensorSeesNothingOfCracksThatAreThere) {
  MachineOptions options = PlainOptions(true);
  options.block.refractive_index = 1;  // the stage's zero is in the glass
  Start(options);
  Connect();
  OpenShutterAndLamp();
  machine->BlindSensor(2);
  SendWindows(std::vector<bool>(4, true), false);
  Pass(50ms);
  EXPECT_EQ(Cracks().size(), 4u);
  std::vector<TickOutcome> outcomes;
  for (const auto& report : received.reports)
    outcomes.insert(outcomes.end(), report.outcome.begin(), report.outcome.end());
  const auto seen = TickOutcome::kFiredSeen, unseen = TickOutcome::kFiredUnseen;
  EXPECT_EQ(outcomes, (std::vector{unseen, unseen, seen, seen}));
}

// A sync that does not come is no tick: both controllers count what comes.
TEST_F(PointRow, ALateLampSyncMakesATickLongerAndCountsNone) {
  Start(PlainOptions(false));  // 100 Hz
  Connect();
  Pass(100ms);
  const std::uint64_t before = machine->laser().tick();
  const std::uint64_t clock_us = machine->laser().Report().machine_us;
  machine->DelaySync(0.055);
  Pass(200ms);
  const std::uint64_t passed = machine->laser().tick() - before;
  EXPECT_NEAR(static_cast<double>(passed), 14.5, 1);
  // The controller's own clock has not stopped.
  EXPECT_NEAR(static_cast<double>(machine->laser().Report().machine_us - clock_us),
              static_cast<double>(passed) * 10000 + 55000, 1.5)
      << "whole microseconds";
}

TEST_F(PointRow, APulseBesideTheBlockIsRecordedAndUnseen) {
  MachineOptions options = PlainOptions(true);
  options.block.origin_mm = Vec3(50, 50, 0);
  Start(options);
  Connect();
  OpenShutterAndLamp();
  SendWindows({true}, false);
  Pass(50ms);
  ASSERT_EQ(Cracks().size(), 1u);
  EXPECT_FALSE(Cracks()[0].in_glass);
  ASSERT_EQ(received.reports.size(), 1u);
  EXPECT_EQ(received.reports[0].outcome, std::vector{TickOutcome::kFiredUnseen});
}

TEST_F(PointRow, InRealTimeTicksFollowTheClock) {
  MachineOptions options = PlainOptions(false);
  options.speed = 2;
  Start(options);
  Pass(1000ms);
  // 100 Hz at twice the speed; the first tick falls on the start.
  EXPECT_NEAR(static_cast<double>(machine->laser().tick()), 200, 1);
}

// The heated volume grows with the energy: an eighth of it makes half the length.
TEST_F(PointRow, ACrackRecordsItsEnergyAndIsSmallerWithLess) {
  MachineOptions options = PlainOptions(true);
  options.block.refractive_index = 1;  // the stage's zero is in the glass
  options.crack_length_mm = 0.195;
  Start(options);
  Connect();
  OpenShutterAndLamp();
  const std::vector<bool> ten(10, true);
  SendLaser(LaserFrame::kArmWindow, Encode(link::ArmWindow{1, false, ten, false, 30}));
  SendLaser(LaserFrame::kArmWindow, Encode(link::ArmWindow{11, false, ten, false, 3.75}));
  SendLaser(LaserFrame::kArmWindow, Encode(link::ArmWindow{21, false, ten, false, 30.5}));
  Pass(200ms);
  const auto cracks = Cracks();
  ASSERT_EQ(cracks.size(), 20u) << "no pulse of 30.5 mJ";
  for (std::size_t i = 0; i < cracks.size(); ++i) {
    const double commanded_mj = i < 10 ? 30 : 3.75;
    EXPECT_NEAR(cracks[i].pulse_energy_mj, commanded_mj, 0.02 * commanded_mj) << i;
    // 2 % of energy are 0.7 % of length; whole um.
    EXPECT_NEAR(cracks[i].length_mm, i < 10 ? 0.195 : 0.0975, 0.002) << i;
  }
}

// Trochimczuk 2008, annex C, fig. 79: four beams of equal energy. A closed shutter takes
// up its share; the detectors measure the pulse before the splitter.
TEST_F(PointRow, EveryOpenChannelGetsItsFixedShareOfThePulse) {
  MachineOptions options = PlainOptions(true);
  options.laser.channels = 4;
  options.laser.energy_spread_ratio = 0;
  options.split_ratio = 0.25;
  options.crack_length_mm = 0.195;
  options.block.refractive_index = 1;
  Start(options);
  Connect();
  OpenShutterAndLamp();
  std::uint64_t tick = 1;
  for (const std::uint8_t open : {0b0001, 0b0110, 0b1111}) {
    SendLaser(LaserFrame::kShutterCommand, Encode(link::ShutterCommand{open}));
    SendLaser(LaserFrame::kArmWindow,
              Encode(link::ArmWindow{tick++, false, {true}, false, 30}));
    Pass(50ms);
  }
  const auto cracks = Cracks();
  ASSERT_EQ(cracks.size(), 1u + 2 + 4);
  for (const auto& crack : cracks) {
    EXPECT_DOUBLE_EQ(crack.pulse_energy_mj, 7.5);
    EXPECT_NEAR(crack.length_mm, 0.195, 1e-3) << "of the largest pulse, as it is split";
  }
  for (const link::PulseReport& report : received.reports) {
    for (const float measured_mj : report.measured_mj) EXPECT_EQ(measured_mj, 30);
  }
}

TEST_F(PointRow, ASensorThatIsBlindOrFiltersTheHeightNamesItsChannel) {
  MachineOptions options = PlainOptions(true);
  options.laser.channels = 2;
  options.block.refractive_index = 1;            // the flash is at the stage's height, 0
  options.channel_offset_mm[1] = Vec3(5, 5, 5);  // and 5 mm above it in channel 2
  Start(options);
  Connect();
  OpenShutterAndLamp();
  SendLaser(LaserFrame::kShutterCommand, Encode(link::ShutterCommand{3}));
  machine->BlindSensor(1, 0b01);
  SendWindows(std::vector<bool>(2, true), false);
  Pass(50ms);
  link::PulseTiming timing;
  timing.min_flash_height_mm = 0;
  timing.max_flash_height_mm = 4;
  SendLaser(LaserFrame::kPulseTiming, Encode(timing));
  SendLaser(LaserFrame::kArmWindow, Encode(link::ArmWindow{3, false, {true}}));
  Pass(50ms);
  EXPECT_EQ(Cracks().size(), 6u) << "what no sensor counts is in the glass all the same";
  std::vector<std::uint8_t> missed;
  for (const auto& report : received.reports)
    missed.insert(missed.end(), report.missed.begin(), report.missed.end());
  EXPECT_EQ(missed, (std::vector<std::uint8_t>{0b01, 0, 0b10}));
}

}  // namespace
}  // namespace intaglio::virtual_engraver
