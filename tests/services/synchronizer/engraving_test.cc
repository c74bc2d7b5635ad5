#include "services/synchronizer/engraving.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <map>
#include <set>

#include "tests/patience.h"
#include "tests/services/synchronizer/fake_cell.h"

namespace intaglio::synchronizer {
namespace {

using formats::JournalKind;
using formats::PointOutcome;
using testing::IsEmpty;
using namespace std::chrono_literals;
using Phase = Engraving::Phase;

class EngravingModes : public testing::TestWithParam<bool> {
 protected:
  FakeCell cell_{{.points = 60, .lockstep = GetParam()}};
};

INSTANTIATE_TEST_SUITE_P(Engraving, EngravingModes, testing::Bool(),
                         [](const auto& i) { return i.param ? "Lockstep" : "RealTime"; });

TEST_P(EngravingModes, MakesEveryPointOnceInOnePass) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilDone());
  EXPECT_EQ(cell_.made(), 60);
  EXPECT_EQ(cell_.laser.cracks().size(), 60);
  EXPECT_EQ(cell_.engraving->run_count(), 1);
  EXPECT_THAT(cell_.Disagreements(), IsEmpty());
  EXPECT_EQ(cell_.results.size(), 60);
  for (std::uint32_t i = 0; i < 60; ++i) EXPECT_EQ(cell_.results[i].point, i);
  // Off when it is over.
  cell_.StepFor(5ms);
  EXPECT_EQ(cell_.laser.shutters(), 0);
  EXPECT_FALSE(cell_.laser.lamp_on());
}

TEST_P(EngravingModes, HasTheIntentOnDiskBeforeTheControllerReceivesTheTick) {
  int armed = 0;
  cell_.laser.on_arm = [&](std::uint64_t tick) {
    ++armed;
    const auto journal = formats::ReadJournal(cell_.journal_file);
    EXPECT_TRUE(std::any_of(journal->records.begin(), journal->records.end(),
                            [&](const formats::JournalRecord& record) {
                              return record.kind == JournalKind::kIntent &&
                                     record.tick == tick;
                            }))
        << "tick " << tick;
  };
  // A disk that is done with its work every 20 ms only: the windows have to wait for it.
  cell_.Grant();
  for (int step = 0; step < 20000 && armed < 20; ++step) {
    cell_.wait_for_disk = step % 20 == 0;
    cell_.Step();
  }
  EXPECT_GE(armed, 20);
}

TEST_P(EngravingModes, PausesAndResumesAsOftenAsTheOperatorLikes) {
  cell_.lockstep_ticks_a_step = 1;
  // Before the first point of a run, in its middle, at once after a resume: none of them
  // is a reason to end the job.
  for (int i = 0; i < 12; ++i) {
    cell_.Grant();
    cell_.StepFor(std::chrono::milliseconds(100 + 97 * i));
    cell_.Withdraw();
    cell_.StepFor(i % 3 == 0 ? 5ms : 200ms);
    ASSERT_FALSE(cell_.done() && cell_.made() < 60) << "pause " << i;
    EXPECT_THAT(cell_.Disagreements(), IsEmpty()) << "pause " << i;
  }
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilDone());
  EXPECT_EQ(cell_.made(), 60);
  EXPECT_THAT(cell_.Disagreements(), IsEmpty());
}

TEST_P(EngravingModes, ChangesItsSpeedInMidJobWithoutALostOrDoubledPoint) {
  // In lockstep motion is planned 4096 ticks ahead.
  const std::uint32_t points = GetParam() ? 6000 : 500;
  FakeCell cell({.points = points, .lockstep = GetParam()});
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(points / 10)) << cell.Description();
  cell.speed_percent = 30;
  ASSERT_TRUE(cell.StepUntilMade(points / 3)) << cell.Description();
  cell.Withdraw();
  ASSERT_TRUE(cell.StepUntil([&] { return cell.phase() == Phase::kWaiting; }));
  cell.StepFor(50ms);
  cell.GrantAnew();
  ASSERT_TRUE(cell.StepUntilMade(points / 2)) << cell.Description();
  cell.speed_percent = 100;
  ASSERT_TRUE(cell.StepUntil([&] { return cell.done(); }, 200s)) << cell.Description();
  EXPECT_EQ(cell.made(), points);
  EXPECT_EQ(cell.laser.cracks().size(), points);
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
  EXPECT_EQ(cell.engraving->min_speed_percent(), 30u);
  EXPECT_EQ(cell.engraving->speed_changes(), 2u);
}

TEST_P(EngravingModes, StopsInAnyPhaseWithEveryPointAccountedFor) {
  for (int at_ms = 1; at_ms < 6000; at_ms += 139) {
    FakeCell cell({.points = 60, .lockstep = GetParam()});
    cell.lockstep_ticks_a_step = 1;
    cell.Grant();
    cell.StepFor(std::chrono::milliseconds(at_ms));
    if (cell.done()) break;
    cell.engraving->Stop("the job was cancelled");
    ASSERT_TRUE(cell.StepUntilDone()) << at_ms << " ms";
    cell.StepFor(5ms);
    EXPECT_EQ(cell.Count(PointState::kArmed), 0) << at_ms << " ms";
    EXPECT_EQ(cell.Count(PointState::kUncertain), 0) << at_ms << " ms";
    EXPECT_THAT(cell.Disagreements(), IsEmpty()) << at_ms << " ms";
    EXPECT_EQ(cell.laser.shutters(), 0) << at_ms << " ms";
    EXPECT_FALSE(cell.laser.lamp_on()) << at_ms << " ms";
  }
}

TEST_P(EngravingModes, FiresNothingIntoAnotherBlock) {
  FakeCell cell({.lockstep = GetParam(), .block_misfit = "another block"});
  cell.StepFor(500ms);
  EXPECT_EQ(cell.engraving->message(), "another block");
  EXPECT_FALSE(cell.engraving->waits()) << "nobody has armed it";
  cell.Grant();
  cell.StepFor(2s);
  EXPECT_TRUE(cell.laser.cracks().empty());
  EXPECT_FALSE(cell.laser.lamp_on());
  EXPECT_TRUE(cell.engraving->waits());
  EXPECT_FALSE(cell.engraving->faulted());
  EXPECT_EQ(cell.engraving->message(), "another block");
  cell.engraving->Stop("cancelled");
  EXPECT_TRUE(cell.StepUntilDone());
}

TEST_P(EngravingModes, GoesOnWhenItsBlockIsInTheMachineAgain) {
  constexpr std::uint32_t kPoints = 3000;  // more than a window of a lockstep machine
  FakeCell cell({.points = kPoints, .lockstep = GetParam()});
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(20));
  cell.ChangeBlock("another block");
  cell.DieAndTakeUp();
  cell.StepFor(500ms);
  const std::size_t made = cell.laser.cracks().size();
  cell.GrantAnew();
  cell.StepFor(3s);
  EXPECT_EQ(cell.laser.cracks().size(), made);
  EXPECT_TRUE(cell.engraving->waits());
  EXPECT_EQ(cell.engraving->message(), "another block");
  EXPECT_EQ(cell.Count(PointState::kArmed), 0) << "what was armed is settled";
  cell.ChangeBlock("");
  cell.DieAndTakeUp();
  ASSERT_TRUE(cell.StepUntil([&] { return cell.done(); }, 60s)) << cell.Description();
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
  EXPECT_EQ(cell.made(), kPoints);
}

/// Where each point was made: point by point in the order of time.
std::vector<std::uint64_t> TicksOfCracks(const FakeCell& cell) {
  std::vector<std::uint64_t> ticks;
  const std::uint64_t first = cell.laser.cracks().front().tick;
  for (const Crack& crack : cell.laser.cracks()) ticks.push_back(crack.tick - first);
  return ticks;
}

/// A process or a line that `stall` holds up for seconds, five times.
void ExpectNoTickLostWhile(void (*stall)(FakeCell& cell, bool stalls)) {
  const CellOptions options = {.points = 4000, .lockstep = true, .simulates_time = true};
  FakeCell undisturbed(options), busy(options);
  undisturbed.Grant();
  ASSERT_TRUE(undisturbed.StepUntilDone()) << undisturbed.Description();
  busy.Grant();
  for (int i = 1; i <= 5; ++i) {
    ASSERT_TRUE(busy.StepUntilMade(600 * i)) << busy.Description();
    stall(busy, true);
    // Its lease, and what is armed; then its time stops.
    busy.StepFor(1500ms);
    const std::uint64_t tick = busy.laser.tick();
    const auto armed_at = busy.laser.newest_arm_at();
    busy.StepFor(3s);
    EXPECT_EQ(busy.laser.tick(), tick);
    EXPECT_EQ(busy.laser.newest_arm_at(), armed_at);
    EXPECT_EQ(busy.phase(), Phase::kRunning);
    EXPECT_THAT(busy.engraving->message(), testing::HasSubstr("is late"));
    ASSERT_LT(busy.made(), options.points) << "the job is too short for this test";
    stall(busy, false);
  }
  ASSERT_TRUE(busy.StepUntilDone()) << busy.Description();
  EXPECT_EQ(busy.engraving->run_count(), 1u);
  EXPECT_EQ(TicksOfCracks(busy), TicksOfCracks(undisturbed));
  EXPECT_THAT(busy.Disagreements(), testing::IsEmpty());
}

// By wall time a permission that is late says nothing of a machine whose time waits.
TEST(EngravingInSimulatedTime, ALatePermissionCostsNoTick) {
  ExpectNoTickLostWhile(
      [](FakeCell& cell, bool stalls) { cell.permission_fresh = !stalls; });
}

TEST(EngravingInSimulatedTime, ALateStateOfTheStageCostsNoTick) {
  ExpectNoTickLostWhile([](FakeCell& cell, bool stalls) { cell.stage.silent = stalls; });
}

TEST(EngravingInSimulatedTime, ALateStateOfTheLaserCostsNoTick) {
  ExpectNoTickLostWhile([](FakeCell& cell, bool stalls) { cell.laser.mute = stalls; });
}

// The machine's process is stopped, or its line carries nothing.
TEST(EngravingInSimulatedTime, ASilentLineOfTheLaserCostsNoTick) {
  ExpectNoTickLostWhile([](FakeCell& cell, bool stalls) { cell.CutLine(stalls); });
}

TEST(EngravingInSimulatedTime, AnEndedBridgeIsNotWaitedFor) {
  FakeCell cell({.points = 4000, .lockstep = true, .simulates_time = true});
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(600));
  cell.stage.silent = cell.bridge_ended = true;
  ASSERT_TRUE(cell.StepUntil([&] { return cell.phase() != Phase::kRunning; }));
}

// A stop, an interlock and a withdrawn permission are none that is late.
TEST(EngravingInSimulatedTime, AStopEndsTheRunWhileItsPermissionIsLate) {
  FakeCell cell({.points = 4000, .lockstep = true, .simulates_time = true});
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(600));
  cell.permission_fresh = false;
  cell.StepFor(1s);
  ASSERT_EQ(cell.phase(), Phase::kRunning);
  cell.stop_pressed = true;
  cell.StepFor(50ms);
  EXPECT_NE(cell.phase(), Phase::kRunning);
  EXPECT_TRUE(cell.engraving->faulted());
}

class EngravingTest : public testing::Test {
 protected:
  FakeCell cell_{{.points = 60}};
};

TEST_F(EngravingTest, MakesLaterWhatAStageThatFellBehindSkipped) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(20));
  cell_.stage.behind = true;
  cell_.StepFor(30ms);
  cell_.stage.behind = false;
  ASSERT_TRUE(cell_.StepUntilDone());
  EXPECT_EQ(cell_.made(), 60);
  EXPECT_TRUE(std::any_of(
      cell_.results.begin(), cell_.results.end(),
      [](const PulseResult& r) { return r.reason == SkipReason::kPosition; }));
  EXPECT_THAT(cell_.Disagreements(), IsEmpty());
}

TEST_F(EngravingTest, PausesWhenAStageIsBehindForGood) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(20));
  cell_.stage.behind = true;
  ASSERT_TRUE(cell_.StepUntil([&] { return cell_.engraving->faulted(); }, 60s));
  cell_.StepFor(2s);
  EXPECT_TRUE(cell_.engraving->waits());
  EXPECT_FALSE(cell_.done());
  EXPECT_THAT(cell_.Disagreements(), IsEmpty());
  cell_.stage.behind = false;
  cell_.GrantAnew();
  ASSERT_TRUE(cell_.StepUntilDone());
  EXPECT_EQ(cell_.made(), 60);
  EXPECT_THAT(cell_.Disagreements(), IsEmpty());
}

// Not a run that starts again and again: the trigger is late for good.
TEST_F(EngravingTest, PausesWhenTheLaserDoesNotTakeTheTrigger) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(20));
  cell_.laser.trigger_late = true;
  ASSERT_TRUE(cell_.StepUntil([&] { return cell_.engraving->faulted(); }, 60s));
  EXPECT_THAT(cell_.engraving->message(), testing::HasSubstr("laser.timing"));
  EXPECT_TRUE(
      std::any_of(cell_.results.begin(), cell_.results.end(),
                  [](const PulseResult& r) { return r.reason == SkipReason::kTrigger; }));
  cell_.laser.trigger_late = false;
  cell_.GrantAnew();
  ASSERT_TRUE(cell_.StepUntilDone());
  EXPECT_EQ(cell_.made(), 60);
  EXPECT_THAT(cell_.Disagreements(), IsEmpty());
}

// As above: the laser has never this energy.
TEST_F(EngravingTest, PausesWhenTheLaserDoesNotMakeTheEnergy) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(20));
  cell_.laser.refuses_energy = true;
  ASSERT_TRUE(cell_.StepUntil([&] { return cell_.engraving->faulted(); }, 60s));
  EXPECT_THAT(cell_.engraving->message(), testing::HasSubstr("pulses of 12.5 mJ"));
  EXPECT_TRUE(
      std::any_of(cell_.results.begin(), cell_.results.end(),
                  [](const PulseResult& r) { return r.reason == SkipReason::kEnergy; }));
  cell_.laser.refuses_energy = false;
  cell_.GrantAnew();
  ASSERT_TRUE(cell_.StepUntilDone());
  EXPECT_EQ(cell_.made(), 60);
  EXPECT_THAT(cell_.Disagreements(), IsEmpty());
}

TEST_F(EngravingTest, EveryPulseHasTheJobsEnergyAndItsMeasurementIsKept) {
  cell_.laser.measured_mj = 12.25F;
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilDone());
  ASSERT_EQ(cell_.laser.cracks().size(), 60u);
  for (const Crack& crack : cell_.laser.cracks()) EXPECT_EQ(crack.energy_mj, 12.5);
  const auto journal = formats::ReadJournal(cell_.journal_file);
  ASSERT_TRUE(journal);
  for (const formats::PointHistory& point : formats::HistoryOf(*journal))
    EXPECT_EQ(point.measured_mj, 12.25F);
}

// In each window of the laser line there is one energy, so each change ends a window.
TEST_P(EngravingModes, EveryPulseHasTheEnergyOfItsPoint) {
  CellOptions options{.points = 60, .lockstep = GetParam()};
  options.energies.distinct_mj = {2.5, 12.5, 30};
  // Alternating, then in stretches.
  for (std::uint32_t i = 0; i < 60; ++i)
    options.energies.of_point.push_back(i < 20 ? i % 3 : i / 10 % 3);
  FakeCell cell(options);
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_EQ(cell.engraving->run_count(), 1);
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
  ASSERT_EQ(cell.results.size(), 60u);
  std::map<std::uint64_t, double> energy_of_tick;
  for (const Crack& crack : cell.laser.cracks())
    energy_of_tick[crack.tick] = crack.energy_mj;
  for (const PulseResult& result : cell.results) {
    const double expected_mj = std::array{
        2.5, 12.5, 30.0}[result.point < 20 ? result.point % 3 : result.point / 10 % 3];
    EXPECT_EQ(energy_of_tick.at(result.tick), expected_mj) << result.point;
  }
}

TEST_F(EngravingTest, StartsAgainWhenTheRunCameTooLate) {
  cell_.stage.deaf = true;
  cell_.Grant();
  cell_.StepFor(5s);
  EXPECT_TRUE(cell_.laser.cracks().empty());
  EXPECT_EQ(cell_.laser.newest_arm_at(), 0ns);
  cell_.stage.deaf = false;
  ASSERT_TRUE(cell_.StepUntilDone()) << cell_.engraving->message();
  EXPECT_EQ(cell_.made(), 60);
  EXPECT_GT(cell_.engraving->run_count(), 1);
  EXPECT_THAT(cell_.Disagreements(), IsEmpty());
}

// How long another process takes is no time of the machine.
TEST(EngravingInLockstep, NoTickPassesWhileTheStateOfTheStageIsAwaited) {
  FakeCell cell({.points = 60, .lockstep = true, .simulates_time = true});
  cell.stage.silent = true;
  cell.StepFor(1s);
  cell.Grant();
  ASSERT_TRUE(cell.StepUntil([&] { return cell.controller->Has(link::kLampWarm); }));
  cell.StepFor(1s);
  const std::uint64_t tick = cell.laser.tick();
  cell.StepFor(20s);
  EXPECT_EQ(cell.laser.tick(), tick);
  cell.stage.silent = false;
  ASSERT_TRUE(cell.StepUntilDone()) << cell.engraving->message();
  EXPECT_EQ(cell.made(), 60);
}

TEST_F(EngravingTest, PausesWhenNoRunReachesTheStage) {
  cell_.stage.deaf = true;
  cell_.Grant();
  // The lead doubles with every attempt: some 60 times the first one in all.
  ASSERT_TRUE(cell_.StepUntil([&] { return cell_.engraving->faulted(); }, 120s));
  EXPECT_FALSE(cell_.engraving->message().empty());
  cell_.stage.deaf = false;
  cell_.GrantAnew();
  ASSERT_TRUE(cell_.StepUntilDone());
  EXPECT_EQ(cell_.made(), 60);
}

TEST_F(EngravingTest, APulseThatNoSensorSawIsMissedAndNotRepeated) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(20));
  cell_.laser.blind = true;
  cell_.laser.missed_channels = 0b1001;
  ASSERT_TRUE(cell_.StepUntilMade(24));
  cell_.laser.blind = false;
  ASSERT_TRUE(cell_.StepUntilDone());
  EXPECT_EQ(cell_.Count(PointState::kMissed), 4);
  EXPECT_EQ(cell_.made(), 56);
  const auto journal = formats::ReadJournal(cell_.journal_file);
  ASSERT_TRUE(journal);
  for (const formats::PointHistory& point : formats::HistoryOf(*journal)) {
    EXPECT_EQ(point.missed_channels,
              point.outcome == formats::PointOutcome::kMissed ? 0b1001 : 0);
  }
  EXPECT_THAT(cell_.Disagreements(), IsEmpty());
}

TEST_F(EngravingTest, ALatePermissionIsNoNewOne) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(20));
  cell_.stop_pressed = true;
  cell_.StepFor(100ms);
  cell_.stop_pressed = false;
  cell_.permission_fresh = false;
  cell_.StepFor(400ms);
  cell_.permission_fresh = true;
  const auto armed_at = cell_.laser.newest_arm_at();
  cell_.StepFor(2s);
  EXPECT_EQ(cell_.laser.newest_arm_at(), armed_at);
  cell_.GrantAnew();
  ASSERT_TRUE(cell_.StepUntilDone());
  EXPECT_EQ(cell_.made(), 60);
}

// Power loss while it is paused: nothing of what is known may be lost.
TEST_F(EngravingTest, HasEveryOutcomeOnDiskWhilePaused) {
  cell_.wait_for_disk = false;
  cell_.Grant();
  while (cell_.laser.cracks().size() < 20) {
    cell_.wait_for_disk = !cell_.wait_for_disk;
    cell_.Step();
  }
  cell_.Withdraw();
  cell_.StepUntil([&] { return cell_.phase() == Phase::kWaiting; });
  cell_.StepFor(10ms);
  // Only the engraving itself writes to the journal.
  EXPECT_TRUE(test::Eventually(
      [&] { return cell_.journal->durable() == cell_.journal->appended(); }));
}

class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    old_handler_ = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &old_);
    const rlimit narrow{bytes, old_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &narrow);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, old_handler_);
  }

 private:
  rlimit old_{};
  void (*old_handler_)(int);
};

TEST_F(EngravingTest, AFullDiskPausesBeforeAnythingFiresWithoutIntent) {
  std::set<std::uint64_t> armed;
  cell_.laser.on_arm = [&](std::uint64_t tick) { armed.insert(tick); };
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(5));
  {
    const FileSizeLimit full(std::filesystem::file_size(cell_.journal_file) + 40);
    ASSERT_TRUE(cell_.StepUntil([&] { return cell_.engraving->faulted(); }));
    cell_.StepFor(1s);
  }
  EXPECT_THAT(cell_.engraving->message(), testing::HasSubstr("free space on the disk"));
  EXPECT_EQ(cell_.laser.shutters(), 0);
  std::set<std::uint64_t> meant;
  const auto on_disk = formats::ReadJournal(cell_.journal_file);
  for (const auto& record : on_disk->records) {
    if (record.kind == JournalKind::kIntent) meant.insert(record.tick);
  }
  for (const std::uint64_t tick : armed) EXPECT_TRUE(meant.contains(tick)) << tick;
}

// One session, a gap in the host's attention: the identity does not come a second time.
TEST_F(EngravingTest, FindsTheControllerAgainAfterAPauseOfPolling) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(5));
  cell_.now += 10s;
  cell_.StepFor(1s);
  cell_.GrantAnew();
  ASSERT_TRUE(cell_.StepUntilDone()) << cell_.engraving->message();
  EXPECT_EQ(cell_.made() + cell_.Count(PointState::kUncertain), 60);
  EXPECT_THAT(cell_.Disagreements(), IsEmpty());
}

}  // namespace
}  // namespace intaglio::synchronizer
