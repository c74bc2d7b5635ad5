// The driver of the grbl family in a run, against the virtual grbl: where pulses are,
// what is sent when, and what a door, an alarm and a lost line leave.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <set>

#include "tests/services/drivers/grbl/grbl_cell.h"

namespace intaglio::drivers {
namespace {

using Cell = GrblCell;
using link::TickOutcome;

/// Every flash begins within a step of its point, one a point, in order.
void ExpectFlashesAtPoints(const Cell& cell, double steps_per_mm,
                           const grbl::Steps& zero = {}) {
  const auto& flashes = cell.machine.grbl.motion().flashes();
  ASSERT_EQ(flashes.size(), cell.points.size());
  std::size_t i = 0;
  for (const auto& [tick, place] : cell.points) {
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LE(std::abs(static_cast<double>(flashes[i].on_at[axis] - zero[axis]) -
                         place[axis] * steps_per_mm),
                1.0)
          << "point " << i << ", axis " << axis;
    }
    EXPECT_EQ(flashes[i].line, static_cast<std::int64_t>(tick % 1000 + 1));
    EXPECT_EQ(flashes[i].at_rest_us, 0) << i;
    ++i;
  }
  EXPECT_EQ(cell.machine.grbl.motion().lit_at_rest_us(), 0);
  EXPECT_EQ(cell.machine.grbl.lost_bytes(), 0U);
}

// $30 of the virtual grbl is 1000.
TEST(GrblDriver, TheEnergyIsAnSByTheCalibration) {
  // 7 mJ are half way between the measurements: 0.75 of the setting.
  for (const auto& [mj, s] : {std::pair(4.0, 500.0), std::pair(7.0, 750.0)}) {
    Cell cell;
    cell.Calibrate();
    cell.energy_mj = mj;
    cell.Prepare();
    EXPECT_EQ(cell.driver->identity().min_energy_mj, 4);
    EXPECT_EQ(cell.driver->identity().max_energy_mj, 10);
    cell.Begin(20, 0.3, false);
    ASSERT_TRUE(cell.Until([&] { return cell.RunIsOver(); }));
    EXPECT_EQ(cell.machine.grbl.motion().flashes().size(), 20u);
    EXPECT_EQ(cell.machine.grbl.powers(), std::set<double>{s});
  }
}

TEST(GrblDriver, AnEnergyThatItCannotSetIsRefused) {
  const auto code_of = [](Cell& cell, std::uint64_t ahead, double mj) {
    const auto armed =
        cell.driver->Arm({cell.driver->status().tick + ahead, true, {true}, false, mj});
    return armed ? std::optional<ErrorCode>() : armed.error().code;
  };
  Cell fixed;
  fixed.Prepare();
  EXPECT_EQ(code_of(fixed, 50, 4), ErrorCode::kUnsupported);
  EXPECT_EQ(code_of(fixed, 50, 0), ErrorCode::kUnsupported);
  EXPECT_EQ(code_of(fixed, 50, 10), std::nullopt);
  Cell calibrated;
  calibrated.Calibrate();
  calibrated.Prepare();
  EXPECT_EQ(code_of(calibrated, 50, 3.9), ErrorCode::kUnsupported);
  EXPECT_EQ(code_of(calibrated, 50, 4), std::nullopt);
  EXPECT_EQ(code_of(calibrated, 60, 10.1), ErrorCode::kUnsupported);
}

TEST(GrblDriver, PulsesOfSeveralEnergiesAreArmedTogetherAndEachHasItsOwn) {
  for (const bool stops : {false, true}) {
    Cell cell;
    cell.Calibrate();
    cell.energies_mj = {4, 7, 7, 10};
    cell.Prepare();
    cell.Begin(24, 0.3, stops);
    ASSERT_TRUE(cell.Until([&] { return cell.RunIsOver(); }));
    EXPECT_EQ(cell.machine.grbl.motion().flashes().size(), 24u);
    const auto& powers = cell.machine.grbl.motion_powers();
    ASSERT_EQ(powers.size(), 24u);
    for (std::size_t i = 0; i < powers.size(); ++i)
      EXPECT_EQ(powers[i], (std::array{500.0, 750.0, 750.0, 1000.0}[i % 4])) << i;
    for (const auto& [tick, outcome] : cell.outcomes)
      EXPECT_EQ(outcome, TickOutcome::kFiredUnseen) << tick;
  }
}

TEST(GrblDriver, PulsesLieWithinAStepOfTheirPoints) {
  for (const auto& options : {grbl::Grbl11(), grbl::GrblHal()}) {
    for (const bool stops : {false, true}) {
      for (const double pitch_mm : {0.02, 0.3}) {
        Cell cell(options);
        cell.Prepare();
        cell.Begin(100, pitch_mm, stops);
        ASSERT_TRUE(cell.Until([&] { return cell.RunIsOver(); }))
            << cell.driver->state().message;
        ExpectFlashesAtPoints(cell, options.motion.steps_per_mm);
        ASSERT_EQ(cell.outcomes.size(), 100U);
        for (const auto& [tick, outcome] : cell.outcomes) {
          EXPECT_EQ(outcome, TickOutcome::kFiredUnseen) << tick;
        }
        EXPECT_EQ(cell.driver->status().pulse_count, 100U);
        EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_OK);
      }
    }
  }
}

TEST(GrblDriver, AnUnarmedPointIsPassedDark) {
  Cell cell;
  cell.Prepare();
  cell.feeds = false;
  cell.Begin(10, 0.3, false);
  ASSERT_TRUE(
      cell.driver->Arm({cell.armed_through + 1, true, std::vector<bool>(40, false)}));
  cell.armed_through = cell.last_tick;
  ASSERT_TRUE(cell.Until([&] { return cell.RunIsOver(); }));
  EXPECT_TRUE(cell.machine.grbl.motion().flashes().empty());
}

TEST(GrblDriver, UndecidedTicksHoldTheRun) {
  Cell cell;
  cell.Prepare();
  cell.feeds = false;
  cell.Begin(10, 0.3, false);
  cell.Until([] { return false; }, 1000);
  EXPECT_FALSE(cell.driver->state().at_rest);
  EXPECT_EQ(cell.driver->status().tick, cell.armed_through);
  EXPECT_LE(cell.machine.grbl.WorkPosition_mm().norm(), 0.301)
      << "a piece ahead of the decisions, at most";
}

TEST(GrblDriver, ALostLineLeavesAtMost16UncertainAndNoneLit) {
  for (int after_ms = 100; after_ms < 1500; after_ms += 37) {
    Cell cell;
    cell.Prepare();
    cell.Begin(200, 0.1, false);
    cell.Until([] { return false; }, after_ms);
    cell.machine.Cut(true);
    cell.Until([] { return false; }, 2000);
    EXPECT_EQ(cell.machine.grbl.motion().lit_at_rest_us(), 0);
    const std::size_t fired = cell.machine.grbl.motion().flashes().size();
    cell.feeds = false;
    cell.segments.clear();
    cell.machine.Cut(false);
    ASSERT_TRUE(cell.Until([&] { return cell.driver->up(); }));
    std::size_t known = 0, uncertain = 0;
    ASSERT_TRUE(cell.driver->RequestPast(cell.points.begin()->first, 512));
    cell.driver->Poll([](const auto&) {},
                      [&](const link::PastReport& past) {
                        for (const TickOutcome outcome : past.outcome) {
                          known += outcome == TickOutcome::kFiredUnseen;
                          uncertain += outcome == TickOutcome::kNoLongerKnown;
                        }
                      });
    EXPECT_LE(uncertain, GrblDriver::kMaxUnsettled);
    EXPECT_LE(known, fired);
    EXPECT_GE(known + uncertain, fired) << "a pulse that nobody knows of";
  }
}

TEST(GrblDriver, AfterADoorNothingMovesOrFiresBeforeReset) {
  Cell cell;
  cell.Prepare();
  cell.Begin(200, 0.1, false);
  cell.Until([] { return false; }, 600);
  cell.machine.grbl.SetDoor(true);
  cell.Until([] { return false; }, 500);
  const std::uint64_t lines = cell.machine.grbl.lines_taken();
  const std::size_t flashes = cell.machine.grbl.motion().flashes().size();
  EXPECT_GT(flashes, 0U);
  cell.machine.grbl.SetDoor(false);
  cell.Until([] { return false; }, 2000);
  EXPECT_EQ(cell.machine.grbl.state(), grbl::VirtualGrbl::State::kDoor)
      << "neither '~' nor a reset";
  EXPECT_EQ(cell.machine.grbl.lines_taken(), lines);
  EXPECT_EQ(cell.machine.grbl.motion().flashes().size(), flashes);
  EXPECT_NE(cell.driver->state().fault, intaglio_MOTION_OK);
  EXPECT_FALSE(cell.driver->Has(link::kStopReleased) &&
               cell.driver->status().shutters_open);
  EXPECT_EQ(cell.driver->status().openings, 1U);
  // A new arm: Reset of the laser, ClearFault of the stage.
  ASSERT_TRUE(cell.driver->ClearFault());
  cell.feeds = false;
  cell.segments.clear();
  cell.Prepare();
  EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_OK);
  EXPECT_EQ(cell.machine.grbl.motion().flashes().size(), flashes);
}

TEST(GrblDriver, ALimitIsAFaultAndTheControllerAnswersAgain) {
  Cell cell;
  cell.Prepare();
  cell.Begin(200, 0.1, false);
  cell.Until([] { return false; }, 600);
  cell.machine.grbl.HitLimit();
  ASSERT_TRUE(cell.Until(
      [&] { return cell.driver->state().fault == intaglio_MOTION_LIMIT; }, 200));
  cell.feeds = false;
  cell.segments.clear();
  cell.Until([] { return false; }, 1000);
  EXPECT_TRUE(cell.driver->state().link_up);
  EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_LIMIT);
  ASSERT_TRUE(cell.driver->ClearFault());
  cell.Prepare();
  EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_OK);
}

TEST(GrblDriver, WithoutLaserModeItIsRefused) {
  grbl::VirtualGrblOptions options = grbl::Grbl11();
  options.laser_mode = false;
  Cell cell(options);
  ASSERT_TRUE(cell.Until([&] { return !cell.driver->refusal().empty(); }, 1000));
  EXPECT_NE(cell.driver->refusal().find("$32=1"), std::string::npos);
  EXPECT_FALSE(cell.driver->up());
}

TEST(GrblDriver, AJogIsDarkWhateverWasSetBefore) {
  Cell cell;
  cell.Prepare();
  ASSERT_TRUE(cell.driver->Jog(Vec3(5, 0, 0), 50));
  ASSERT_TRUE(cell.Until([&] { return cell.driver->state().at_rest; }));
  EXPECT_EQ(cell.machine.grbl.WorkPosition_mm(), Vec3(5, 0, 0));
  EXPECT_TRUE(cell.machine.grbl.motion().flashes().empty());
  EXPECT_FALSE(cell.machine.grbl.spindle_on());
  EXPECT_FALSE(cell.driver->Jog(Vec3(500, 0, 0), 50)) << "checked before it is sent";
  EXPECT_FALSE(cell.driver->Jog(Vec3(std::nan(""), 0, 0), 50));
}

/// 20 mm from its switches, which take 0.8 s.
grbl::VirtualGrblOptions WithSwitches() {
  grbl::VirtualGrblOptions options = grbl::Grbl11();
  options.homing = true;
  options.home_steps = {-5000, 1000, 0};
  return options;
}

TEST(GrblDriver, WithoutAReferenceOnlyHomeMovesIt) {
  Cell cell(WithSwitches());
  ASSERT_TRUE(cell.Until([&] { return cell.driver->up(); })) << cell.driver->message();
  EXPECT_FALSE(cell.driver->state().homed);
  EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_OK);
  EXPECT_FALSE(cell.driver->Jog(Vec3(1, 0, 0), 5));
  ASSERT_TRUE(cell.driver->BeginRun(1, cell.driver->status().tick + 50, 0));
  EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_SAFE_STATE);
  EXPECT_EQ(cell.driver->state().run, 1U) << "else it is a fault of before";
  EXPECT_NE(cell.driver->state().message.find("teach home"), std::string::npos);
  ASSERT_TRUE(cell.driver->ClearFault());
  ASSERT_TRUE(cell.Until([&] {
    return cell.driver->state().fault == intaglio_MOTION_OK &&
           cell.driver->state().at_rest;
  }));
  ASSERT_TRUE(cell.driver->Home());
  EXPECT_FALSE(cell.driver->state().at_rest);
  for (int i = 0; i < 700; ++i) {
    cell.Step();
    ASSERT_TRUE(cell.driver->up()) << "silence is not a lost line while it homes";
    ASSERT_TRUE(cell.driver->status().shutters_open == 0);
  }
  ASSERT_TRUE(cell.Until([&] { return cell.driver->state().at_rest; }));
  EXPECT_TRUE(cell.driver->state().homed);
  EXPECT_EQ(cell.machine.grbl.TrueSteps(), WithSwitches().home_steps);
  cell.Prepare();
  cell.run = 1;
  cell.Begin(5, 0.3, false);
  ASSERT_TRUE(cell.Until([&] { return cell.RunIsOver(); }));
  ExpectFlashesAtPoints(cell, 250, WithSwitches().home_steps);
}

TEST(GrblDriver, HoldEndsHomingWithoutAFaultAndWithoutAReference) {
  Cell cell(WithSwitches());
  ASSERT_TRUE(cell.Until([&] { return cell.driver->up(); }));
  ASSERT_TRUE(cell.Until([&] { return cell.driver->state().at_rest; }));
  ASSERT_TRUE(cell.driver->Home());
  for (int i = 0; i < 400; ++i) cell.Step();
  ASSERT_EQ(cell.machine.grbl.state(), grbl::VirtualGrbl::State::kHome);
  ASSERT_TRUE(cell.driver->Hold());
  ASSERT_TRUE(cell.Until([&] { return cell.driver->state().at_rest; }, 1000));
  EXPECT_EQ(cell.machine.grbl.state(), grbl::VirtualGrbl::State::kAlarm);
  EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_OK);
  EXPECT_FALSE(cell.driver->state().homed);
  EXPECT_FALSE(cell.driver->Jog(Vec3(1, 0, 0), 5));
  ASSERT_TRUE(cell.driver->Home());
  ASSERT_TRUE(cell.Until([&] { return cell.driver->state().at_rest; }));
  EXPECT_TRUE(cell.driver->state().homed);
  EXPECT_TRUE(cell.driver->Jog(Vec3(1, 0, 0), 5));
}

TEST(GrblDriver, TheDoorEndsHomingWithAFault) {
  Cell cell(WithSwitches());
  ASSERT_TRUE(cell.Until([&] { return cell.driver->up(); }));
  ASSERT_TRUE(cell.Until([&] { return cell.driver->state().at_rest; }));
  ASSERT_TRUE(cell.driver->Home());
  for (int i = 0; i < 400; ++i) cell.Step();
  cell.machine.grbl.SetDoor(true);
  for (int i = 0; i < 100; ++i) cell.Step();
  EXPECT_TRUE(cell.driver->up());
  EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_SAFE_STATE);
  EXPECT_NE(cell.driver->state().message.find("door"), std::string::npos);
  EXPECT_FALSE(cell.driver->state().homed);
  cell.machine.grbl.SetDoor(false);
  ASSERT_TRUE(cell.driver->ClearFault());
  ASSERT_TRUE(cell.Until([&] {
    return cell.driver->state().fault == intaglio_MOTION_OK &&
           cell.driver->state().at_rest;
  }));
  ASSERT_TRUE(cell.driver->Home());
  ASSERT_TRUE(cell.Until([&] { return cell.driver->state().homed; }));
}

/// Until a controller that was switched on again, or reset, takes commands.
void Recover(Cell& cell) {
  ASSERT_TRUE(cell.Until([&] { return cell.driver->up(); })) << cell.driver->message();
  ASSERT_TRUE(cell.Until([&] {
    if (cell.driver->state().fault != intaglio_MOTION_OK) (void)cell.driver->ClearFault();
    return cell.driver->state().fault == intaglio_MOTION_OK &&
           cell.driver->state().at_rest;
  })) << cell.driver->state().message;
}

TEST(GrblDriver, WithoutSwitchesALostPlaceRefusesRunsUntilTheZeroIsStated) {
  Cell cell;
  cell.Prepare();
  EXPECT_EQ(cell.driver->state().place_lost, "");
  ASSERT_TRUE(cell.driver->Jog(Vec3(5, 6, 7), 50));
  ASSERT_TRUE(cell.Until([&] { return cell.driver->state().at_rest; }));
  const grbl::Steps before = cell.machine.grbl.TrueSteps();
  cell.machine.grbl.PowerCycle();
  for (int i = 0; i < 500; ++i) cell.Step();
  Recover(cell);
  EXPECT_NE(cell.driver->state().place_lost.find("teach zero"), std::string::npos);
  ASSERT_TRUE(cell.driver->BeginRun(1, cell.driver->status().tick + 50, 0));
  EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_SAFE_STATE);
  EXPECT_NE(cell.driver->state().message.find("teach zero"), std::string::npos);
  for (int i = 0; i < 500; ++i) cell.Step();
  EXPECT_EQ(cell.machine.grbl.TrueSteps(), before) << "nothing moves for a job";
  Recover(cell);
  // Beyond the travel as the controller counts it now, and not in truth.
  ASSERT_TRUE(cell.driver->Jog(Vec3(-5, -6, -7), 50));
  ASSERT_TRUE(cell.Until([&] { return cell.driver->state().at_rest; }));
  EXPECT_EQ(cell.machine.grbl.TrueSteps(), grbl::Steps{});
  EXPECT_FALSE(cell.driver->SetZero(Vec3(std::nan(""), 0, 0), {true, true, true}));
  ASSERT_TRUE(cell.driver->SetZero(Vec3(1, 2, 3), {true, true, false}));
  EXPECT_FALSE(cell.driver->state().at_rest);
  ASSERT_TRUE(cell.Until([&] { return cell.driver->state().at_rest; }));
  EXPECT_NE(cell.driver->state().place_lost, "") << "z is not stated yet";
  ASSERT_TRUE(cell.driver->SetZero(Vec3(0, 0, 3), {false, false, true}));
  ASSERT_TRUE(cell.Until([&] { return cell.driver->state().at_rest; }));
  EXPECT_EQ(cell.driver->state().place_lost, "");
  EXPECT_LT((cell.driver->state().position_mm - Vec3(1, 2, 3)).norm(), 1e-3);
  cell.Prepare();
  cell.run = 1;
  cell.Begin(5, 0.3, false);
  ASSERT_TRUE(cell.Until([&] { return cell.RunIsOver(); }));
  ExpectFlashesAtPoints(cell, 250, {-250, -500, -750});
}

// At the zero of the axes, where a controller is that was switched on just now.
TEST(GrblDriver, AHostThatWasTooBusyToAskHasLostNeitherLineNorPlace) {
  Cell cell;
  cell.Prepare();
  const std::uint64_t session = cell.driver->session();
  for (int trial = 0; trial < 40; ++trial) {
    for (int i = 0; i < trial; ++i) cell.Step();
    // Nothing turns this process.
    for (int i = 0; i < 400; ++i) cell.machine.Advance();
    cell.Step();
    ASSERT_TRUE(cell.driver->up()) << trial;
  }
  EXPECT_EQ(cell.driver->session(), session);
  EXPECT_EQ(cell.driver->state().place_lost, "");
  EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_OK);
}

TEST(GrblDriver, WithoutSwitchesHomeIsRefusedByTheSetting) {
  Cell cell;
  cell.Prepare();
  const auto homed = cell.driver->Home();
  ASSERT_FALSE(homed);
  EXPECT_NE(homed.error().message.find("$22=1"), std::string::npos);
  EXPECT_TRUE(cell.driver->state().at_rest);
}

}  // namespace
}  // namespace intaglio::drivers
