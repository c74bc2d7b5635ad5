// The guarantees of pulse_trigger.h, numbered as there, by every trigger on the virtual
// machine, whose lines are in memory.

#include "services/synchronizer/pulses/pulse_trigger.h"

#include <gmock/gmock.h>

#include <map>
#include <set>

#include "engrave/drive/first_order.h"
#include "tests/services/virtual_engraver/machine_bench.h"
#include "tests/services/virtual_engraver/stage_path.h"

namespace intaglio::synchronizer {
namespace {

using link::LaserFrame;
using link::MotionFrame;
using link::TickOutcome;
using virtual_engraver::Frame;
using virtual_engraver::Knot;
using virtual_engraver::kTick;
using virtual_engraver::MachineBench;
using virtual_engraver::MachineOptions;
using namespace std::chrono_literals;

constexpr int kPoints = 40;
constexpr std::uint64_t kRunStart = 60;
constexpr std::uint64_t kFirstPoint = kRunStart + 37;  // then one every other tick
// At 10 mm/s it is 5 um late, half of the tolerance.
constexpr double kLagS = 0.0005;

Vec3 PointMm(int i) { return {0.5 + 0.2 * i, 5, 60}; }
std::uint64_t TickOf(int i) { return kFirstPoint + 2 * static_cast<std::uint64_t>(i); }

/// A row of points that is passed at 10 mm/s.
std::vector<Knot> KnotsOfRow() {
  std::vector<Knot> knots = {{{200, 5000, 60000}, {0, 0, 0}, 30 * kTick}};
  for (int i = 0; i < kPoints; ++i) {
    knots.push_back({1000 * PointMm(i), {10000, 0, 0}, (i == 0 ? 7 : 2) * kTick, true});
  }
  knots.push_back(
      {1000 * PointMm(kPoints) + Vec3(100, 0, 0), {0, 0, 0}, 6 * kTick, false, true});
  return knots;
}

class Trigger : public MachineBench,
                public ::testing::WithParamInterface<const PulseTrigger*> {
 protected:
  void StartMachine(double lag_s, bool lockstep) {
    MachineOptions options = PlainOptions(lockstep);
    options.stage.mechanics.lag_s = lag_s;
    options.block.refractive_index = 1;  // the beam has a test of its own
    Start(options);
    Connect();
    ASSERT_TRUE(GetParam()->CheckLaser(received.laser_identities.back()).has_value());
    OpenShutterAndLamp();
    const auto knots = KnotsOfRow();
    SendMotion(MotionFrame::kBeginRun, Encode(link::BeginRun{1, kRunStart}));
    for (std::size_t at = 0; at < knots.size(); at += link::kMaxSegments) {
      const auto from = knots.begin() + static_cast<std::ptrdiff_t>(at);
      const std::size_t end = std::min(at + link::kMaxSegments, knots.size());
      SendMotion(
          MotionFrame::kSegments,
          Encode(Frame({from, knots.begin() + static_cast<std::ptrdiff_t>(end)}, at)));
    }
  }
  /// Decides all ticks; every tick of `armed` is to fire.
  void Arm(const std::set<std::uint64_t>& armed) {
    link::ArmWindow window;
    window.first_tick = 1;
    window.fire.resize(kRunStart + 40 + 2 * kPoints + 60);
    for (const std::uint64_t tick : armed) window.fire[tick - 1] = true;
    GetParam()->Mark(window);
    SendLaser(LaserFrame::kArmWindow, Encode(window));
  }
  static std::set<std::uint64_t> AllPoints() {
    std::set<std::uint64_t> ticks;
    for (int i = 0; i < kPoints; ++i) ticks.insert(TickOf(i));
    return ticks;
  }
  std::multiset<std::uint64_t> TicksOfCracks() {
    std::multiset<std::uint64_t> ticks;
    for (const auto& crack : Cracks()) ticks.insert(crack.tick);
    return ticks;
  }
  /// The outcomes of the armed ticks; each is reported once.
  std::map<std::uint64_t, TickOutcome> Outcomes() const {
    std::map<std::uint64_t, TickOutcome> outcomes;
    for (const link::PulseReport& report : received.reports) {
      for (std::size_t i = 0; i < report.outcome.size(); ++i) {
        if (report.outcome[i] == TickOutcome::kNotArmed) continue;
        EXPECT_TRUE(outcomes.emplace(report.first_tick + i, report.outcome[i]).second)
            << "reported twice: " << report.first_tick + i;
      }
    }
    return outcomes;
  }
};

TEST_P(Trigger, FiresInArmedTicksAloneAndOnceForAKnot) {  // 1, 2, 5
  StartMachine(kLagS, true);
  std::set<std::uint64_t> armed;
  for (int i = 0; i < kPoints; i += 3) armed.insert(TickOf(i));
  Arm(armed);
  Pass(300ms);
  EXPECT_EQ(TicksOfCracks(), std::multiset<std::uint64_t>(armed.begin(), armed.end()));
  const auto outcomes = Outcomes();
  ASSERT_EQ(outcomes.size(), armed.size());
  for (const auto& [tick, outcome] : outcomes) {
    EXPECT_TRUE(armed.contains(tick));
    EXPECT_EQ(outcome, TickOutcome::kFiredSeen) << tick;
  }
}

TEST_P(Trigger, NothingFiresUnarmed) {  // 1
  StartMachine(kLagS, true);
  Arm({});
  Pass(300ms);
  EXPECT_THAT(TicksOfCracks(), ::testing::IsEmpty());
  EXPECT_EQ(machine->laser().Report().pulse_count, 0u);
}

// A tick between two knots has none: it is armed by mistake.
TEST_P(Trigger, AnArmedTickWithoutAKnotDoesNotFire) {  // 2, 3
  StartMachine(kLagS, true);
  std::set<std::uint64_t> armed = AllPoints();
  for (int i = 0; i + 1 < kPoints; ++i) armed.insert(TickOf(i) + 1);
  Arm(armed);
  Pass(300ms);
  EXPECT_EQ(TicksOfCracks().size(), static_cast<std::size_t>(kPoints));
  const auto outcomes = Outcomes();
  for (int i = 0; i + 1 < kPoints; ++i) {
    EXPECT_EQ(outcomes.at(TickOf(i)), TickOutcome::kFiredSeen) << i;
    EXPECT_EQ(outcomes.at(TickOf(i) + 1), TickOutcome::kNotInPosition) << i;
  }
}

TEST_P(Trigger, AStageThatIsNotThereDoesNotFire) {  // 3, 5
  StartMachine(kLagS, true);
  machine->stage().Stick(1);  // y: it passes the row 5 mm beside it
  Arm(AllPoints());
  Pass(300ms);
  EXPECT_THAT(TicksOfCracks(), ::testing::IsEmpty());
  for (const auto& [tick, outcome] : Outcomes())
    EXPECT_NE(outcome, TickOutcome::kFiredSeen) << tick;
}

TEST_P(Trigger, NothingFiresFromAnOpenInterlockOn) {  // 4
  StartMachine(kLagS, false);
  Arm(AllPoints());
  while (machine->laser().tick() < TickOf(kPoints / 2)) Pass(1ms);
  machine->laser().SetDoor(false);
  const std::uint64_t opened = machine->laser().tick();
  for (int i = 0; i < 120; ++i) Pass(10ms);
  const auto ticks = TicksOfCracks();
  EXPECT_GE(ticks.size(), static_cast<std::size_t>(kPoints / 2));
  for (const std::uint64_t tick : ticks) EXPECT_LE(tick, opened);
  const auto outcomes = Outcomes();
  EXPECT_EQ(outcomes.at(TickOf(kPoints - 1)), TickOutcome::kInterlocked);
}

TEST_P(Trigger, NothingFiresThroughClosedShutters) {  // 4
  StartMachine(kLagS, true);
  SendLaser(LaserFrame::kShutterCommand, Encode(link::ShutterCommand{0}));
  Arm(AllPoints());
  Pass(300ms);
  EXPECT_THAT(TicksOfCracks(), ::testing::IsEmpty());
  for (const auto& [tick, outcome] : Outcomes())
    EXPECT_EQ(outcome, TickOutcome::kShutterClosed) << tick;
}

INSTANTIATE_TEST_SUITE_P(Conformance, Trigger,
                         ::testing::ValuesIn(PulseTriggers().begin(),
                                             PulseTriggers().end()),
                         [](const auto& row) { return std::string(row.param->name()); });

class PlaceTrigger : public Trigger {};

TEST_P(PlaceTrigger, CracksLieNearerThanAtTheTick) {
  StartMachine(kLagS, true);
  Arm(AllPoints());
  Pass(300ms);
  const auto cracks = Cracks();
  ASSERT_EQ(cracks.size(), static_cast<std::size_t>(kPoints));
  double largest_mm = 0;
  for (int i = 0; i < kPoints; ++i) {
    const auto& crack = cracks[static_cast<std::size_t>(i)];
    largest_mm = std::max(largest_mm, (crack.position_mm - PointMm(i)).norm());
  }
  if (GetParam()->kind() == PULSE_TRIGGER_AT_TICK) {
    EXPECT_NEAR(largest_mm, 10 * kLagS, 1e-6) << "the way that the lag makes late";
  } else {
    // It samples every 20 us, which is 0.2 um of the way.
    EXPECT_LE(largest_mm, 0.0001 + 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Each, PlaceTrigger,
                         ::testing::ValuesIn(PulseTriggers().begin(),
                                             PulseTriggers().end()),
                         [](const auto& row) { return std::string(row.param->name()); });

TEST(PulseTriggers, AreFoundByTheValueOfTheProfile) {
  for (int number = PulseTriggerKind_MIN; number <= PulseTriggerKind_MAX; ++number) {
    const auto kind = static_cast<PulseTriggerKind>(number);
    ASSERT_NE(FindPulseTrigger(kind), nullptr) << number;
    EXPECT_EQ(FindPulseTrigger(kind)->kind(), kind);
  }
  EXPECT_EQ(FindPulseTrigger(static_cast<PulseTriggerKind>(99)), nullptr);
}

TEST(PulseTriggers, APlaceNeedsALaserThatOffersItAndNoCompensation) {
  link::LaserIdentity laser;
  EXPECT_TRUE(TriggerAtTick().CheckLaser(laser).has_value());
  const auto refused = TriggerAtPlace().CheckLaser(laser);
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message, ::testing::HasSubstr("PULSE_TRIGGER_AT_TICK"));
  laser.fires_at_place = true;
  EXPECT_TRUE(TriggerAtPlace().CheckLaser(laser).has_value());
  motion::PlanOptions plan;
  plan.drives = drive::AllAxes(std::make_shared<drive::FirstOrder>(0.001));
  TriggerAtTick().Adapt(plan);
  EXPECT_NE(plan.drives[0], nullptr);
  TriggerAtPlace().Adapt(plan);
  EXPECT_EQ(plan.drives[0], nullptr);
}

}  // namespace
}  // namespace intaglio::synchronizer
