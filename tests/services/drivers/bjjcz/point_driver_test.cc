// The driver of points in glass at a BJJCZ board of the tests' own, which records each
// flash: what was planned is where it was made, and what nobody can know is of one list.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "services/drivers/bjjcz/board_profile.h"
#include "tests/services/drivers/bjjcz/point_rig.h"

namespace intaglio::drivers {
namespace {

using link::TickOutcome;
using ::testing::HasSubstr;

constexpr double kRate_hz = 4000;
// Neighbours with one energy.
constexpr std::size_t kEqualPoints = 7;

/// Points in layers, from the deepest up, all of them armed.
class Cell {
 public:
  explicit Cell(const MachineSpec& profile = Profile())
      : machine(false, true), driver(MakeBjjczPointDriverAt(machine, profile)) {}
  static MachineSpec Profile() { return BjjczPointProfile(); }

  LaserController& laser() { return *driver->laser(); }
  void Step() {
    machine.Advance();
    laser().Poll(
        [this](const link::PulseReport& report) {
          for (std::size_t i = 0; i < report.outcome.size(); ++i) {
            if (report.outcome[i] == TickOutcome::kNotArmed) continue;
            EXPECT_TRUE(outcomes.emplace(report.first_tick + i, report.outcome[i]).second)
                << "tick " << report.first_tick + i << " is reported twice";
          }
        },
        [this](const link::PastReport& report) {
          for (std::size_t i = 0; i < report.outcome.size(); ++i)
            past[report.first_tick + i] = report.outcome[i];
        });
    (void)driver->TakePositions();
    while (!segments.empty() && driver->Room() > 0 && laser().up()) {
      ASSERT_TRUE(driver->Append(std::span(segments).first(1), {}));
      segments.erase(segments.begin());
    }
  }
  bool Until(const std::function<bool()>& condition, int limit_ms = 60000) {
    for (int i = 0; i < limit_ms && !condition(); ++i) Step();
    return condition();
  }
  void StepFor(int ms) {
    for (int i = 0; i < ms; ++i) Step();
  }
  void Connect() {
    ASSERT_TRUE(Until([&] { return laser().up(); })) << laser().message();
  }
  void Prepare() {
    ASSERT_TRUE(laser().Reset() && laser().Lamp(true, kRate_hz) && driver->ClearFault());
    StepFor(50);
    ASSERT_TRUE(laser().OpenShutters(1));
    ASSERT_TRUE(Until([&] {
      return laser().Has(link::kLampWarm) && laser().status().shutters_open == 1 &&
             driver->state().at_rest;
    })) << driver->state().message;
  }
  /// `layers` of `count` points each, the energies of a row's points in turn, mJ.
  void Begin(int layers, int count, const std::vector<double>& turns_mj = {10},
             std::uint16_t pulses = 0) {
    const std::uint64_t start =
        std::max(laser().status().tick, laser().status().decided_through) + 3;
    ASSERT_TRUE(driver->BeginRun(++run, start, 0)) << driver->state().message;
    std::uint64_t tick = start;
    std::vector<bool> fire(2, false);
    std::vector<double> energies_mj(2, turns_mj.front());
    for (int layer = 0; layer < layers; ++layer) {
      for (int i = 0; i < count; ++i) {
        const std::uint32_t ticks = i == 0 ? 200 : 2;  // z moves before the first
        const Vec3 place(10.0123 + 0.2 * (i % 20),
                         -7.4567 + 0.2 * (i / 20) + 0.01 * layer, 0.066 * (layer + 1));
        tick += ticks;
        fire.resize(tick - start + 2, false);
        fire.back() = true;
        const double energy_mj = turns_mj[points.size() / kEqualPoints % turns_mj.size()];
        energies_mj.resize(fire.size(), energy_mj);
        points[tick] = place;
        segments.push_back({place, Vec3::Zero(), ticks * motion::kSubticksPerTick, true,
                            layer + 1 == layers && i + 1 == count});
      }
    }
    for (std::size_t at = 0, end = 0; at < fire.size(); at = end) {
      while (end < fire.size() && end < at + 4000 && energies_mj[end] == energies_mj[at])
        ++end;
      ASSERT_TRUE(laser().Arm({start - 1 + at,
                               true,
                               {fire.begin() + static_cast<std::ptrdiff_t>(at),
                                fire.begin() + static_cast<std::ptrdiff_t>(end)},
                               false,
                               energies_mj[at],
                               pulses}));
    }
  }
  const std::vector<bjjcz::Flash>& flashes() const { return machine.board.flashes(); }
  /// The point of each flash, in their order; each within half a place of the board.
  std::vector<std::uint64_t> MadeTicks() const {
    std::vector<std::uint64_t> made;
    auto point = points.begin();
    for (const bjjcz::Flash& flash : flashes()) {
      const auto is_here = [&](const auto& at) {
        const Vec3& place = at.second;
        return std::abs(flash.at[0] - 32768 - place.x() * kBoardPlacesPerMm) <= 0.5001 &&
               std::abs(flash.at[1] - 32768 - place.y() * kBoardPlacesPerMm) <= 0.5001 &&
               flash.axis == std::lround((place.z() + 51) * kBoardStepsPerMm);
      };
      point = std::find_if(point, points.end(), is_here);
      if (point == points.end()) {
        ADD_FAILURE() << "flash " << made.size()
                      << " is of no later point: " << flash.at[0] << ", " << flash.at[1]
                      << ", " << flash.axis;
        return made;
      }
      made.push_back(point->first);
      ++point;
    }
    return made;
  }

  BjjczMachine machine;
  std::unique_ptr<MotionDriver> driver;
  std::map<std::uint64_t, Vec3> points;
  std::map<std::uint64_t, TickOutcome> outcomes, past;
  std::vector<motion::Segment> segments;
  std::uint32_t run = 0;
};

TEST(BjjczPoints, EachIsMadeWithinHalfAPlaceOfTheBoard) {
  Cell cell;
  cell.Connect();
  cell.Prepare();
  cell.Begin(4, 300);
  ASSERT_TRUE(cell.Until([&] {
    return cell.segments.empty() && cell.driver->state().at_rest;
  })) << cell.driver->state().message;
  EXPECT_EQ(cell.MadeTicks().size(), 1200u);
  for (const auto& [tick, place] : cell.points)
    EXPECT_EQ(cell.outcomes[tick], TickOutcome::kFiredUnseen) << tick;
  for (const bjjcz::Flash& flash : cell.flashes()) EXPECT_NEAR(flash.lit_us, 500, 1);
  EXPECT_EQ(cell.machine.board.unknown_count(), 0u);
  // Full lists; z moves between lists alone.
  EXPECT_LE(cell.machine.board.lists_executed(), 4u * (300 / kBoardListPoints + 2));
}

// What the board's source was set to at each flash, by a calibration that is not linear.
TEST(BjjczPoints, EachHasThePowerOfItsEnergy) {
  MachineSpec profile = Cell::Profile();
  const std::map<double, double> settings = {{2, 0.1}, {5, 0.3}, {10, 1}};
  for (const auto& [energy_mj, setting] : settings) {
    EnergyPoint& point = *profile.mutable_laser()->add_energy_calibration();
    point.set_setting_ratio(setting);
    point.set_energy_mj(energy_mj);
  }
  Cell cell(profile);
  cell.Connect();
  cell.Prepare();
  cell.Begin(2, 100, {2, 5, 10, 5});
  ASSERT_TRUE(cell.Until([&] {
    return cell.segments.empty() && cell.driver->state().at_rest;
  })) << cell.driver->state().message;
  ASSERT_EQ(cell.MadeTicks().size(), 200u);
  const double turns_mj[] = {2, 5, 10, 5};
  // The pulse's width in counts of 20 MHz: the whole period at 30 kHz is full power.
  constexpr double kFullPower = 20e6 / 30e3;
  for (std::size_t i = 0; i < cell.flashes().size(); ++i) {
    const double expected = settings.at(turns_mj[i / kEqualPoints % 4]);
    EXPECT_NEAR(cell.flashes()[i].power_ratio, expected * kFullPower, 1) << "flash " << i;
  }
}

// 30 kHz: 0.5 ms are 15 pulses, as the profile has it, and a job may ask for others.
TEST(BjjczPoints, EachHasThePulsesThatWereAskedFor) {
  for (const std::uint16_t asked : {0, 3, 40}) {
    Cell cell;
    cell.Connect();
    cell.Prepare();
    cell.Begin(2, 60, {10}, asked);
    ASSERT_TRUE(cell.Until([&] {
      return cell.segments.empty() && cell.driver->state().at_rest;
    })) << cell.driver->state().message;
    ASSERT_EQ(cell.MadeTicks().size(), 120u);
    for (const bjjcz::Flash& flash : cell.flashes())
      EXPECT_EQ(flash.pulses, asked == 0 ? 15 : asked);
  }
}

// The board's driver refuses what its source was not measured for.
TEST(BjjczPoints, TheBoardRestsBehindSoManyPoints) {
  MachineSpec profile = Cell::Profile();
  JumpAndDwell& jumps = *profile.mutable_head_over_block()->mutable_jump_and_dwell();
  jumps.set_pause_after_points(10);
  jumps.set_pause_s(0.4);  // longer than a list may be
  Cell cell(profile);
  cell.Connect();
  cell.Prepare();
  cell.Begin(1, 35);
  ASSERT_TRUE(cell.Until([&] { return cell.outcomes.size() == cell.points.size(); }));
  EXPECT_EQ(cell.MadeTicks().size(), 35u);
  const auto& flashes = cell.flashes();
  for (std::size_t i = 1; i < flashes.size(); ++i) {
    const double dark_us =
        flashes[i].begin_us - flashes[i - 1].begin_us - flashes[i - 1].lit_us;
    if (i % 10 == 0)
      EXPECT_GE(dark_us, 0.4e6) << "before point " << i;
    else
      EXPECT_LT(dark_us, 0.2e6) << "before point " << i;
  }
}

TEST(BjjczPoints, AnEnergyOutsideTheCalibrationIsRefused) {
  MachineSpec profile = Cell::Profile();
  for (const double energy_mj : {4.0, 10.0}) {
    EnergyPoint& point = *profile.mutable_laser()->add_energy_calibration();
    point.set_setting_ratio(energy_mj / 10);
    point.set_energy_mj(energy_mj);
  }
  Cell cell(profile);
  cell.Connect();
  cell.Prepare();
  const auto refused = cell.laser().Arm({1000, true, {true}, false, 3});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("no pulses of 3 mJ but 4..10 mJ"));
}

// At ten instants; the board goes on with what it has and keeps its axis, so it is the
// same power-up, and all but the list in hand is known.
TEST(BjjczPoints, OnlyTheListInHandIsUncertainWhenTheLineIsCut) {
  std::size_t largest = 0;
  for (int instant = 1; instant <= 10; ++instant) {
    Cell cell;
    cell.Connect();
    cell.Prepare();
    cell.Begin(2, 300);
    cell.StepFor(80 * instant);
    const std::uint32_t power_up = cell.laser().identity().power_up;
    cell.machine.Cut(true);
    cell.StepFor(600);
    const std::size_t flash_count = cell.flashes().size();
    cell.segments.clear();
    cell.machine.Cut(false);
    cell.Connect();
    cell.StepFor(1000);
    EXPECT_EQ(cell.flashes().size(), flash_count) << "made behind the cut";
    EXPECT_EQ(cell.laser().identity().power_up, power_up);
    const std::uint64_t first = cell.points.begin()->first;
    for (std::uint64_t tick = first; tick <= cell.points.rbegin()->first; tick += 256)
      ASSERT_TRUE(cell.laser().RequestPast(tick, 256));
    cell.StepFor(10);
    std::size_t uncertain = 0;
    const auto made = cell.MadeTicks();
    for (const auto& [tick, place] : cell.points) {
      const bool was_made = std::ranges::count(made, tick) == 1;
      if (cell.past[tick] == TickOutcome::kNoLongerKnown)
        ++uncertain;
      else
        EXPECT_EQ(cell.past[tick] == TickOutcome::kFiredUnseen, was_made) << tick;
    }
    EXPECT_LE(uncertain, kBoardListPoints) << instant;
    largest = std::max(largest, uncertain);
  }
  EXPECT_GT(largest, 0u) << "no cut came into a list";
}

TEST(BjjczPoints, APowerCycleIsAnotherPowerUpAndHasToBeHomed) {
  Cell cell;
  cell.Connect();
  cell.Prepare();
  cell.Begin(1, 300);
  cell.StepFor(200);
  const std::uint32_t power_up = cell.laser().identity().power_up;
  cell.machine.SwitchOff();
  cell.StepFor(500);
  cell.segments.clear();
  cell.machine.SwitchOn();
  cell.Connect();
  EXPECT_NE(cell.laser().identity().power_up, power_up);
  EXPECT_FALSE(cell.driver->state().homed);
  const std::size_t flash_count = cell.flashes().size();
  cell.StepFor(1000);
  EXPECT_EQ(cell.flashes().size(), flash_count);
  ASSERT_TRUE(cell.laser().Reset() && cell.driver->ClearFault());
  cell.StepFor(50);
  ASSERT_TRUE(cell.driver->Home()) << cell.driver->state().message;
  EXPECT_TRUE(cell.Until([&] { return cell.driver->state().at_rest; }));
  EXPECT_TRUE(cell.driver->state().homed);
  EXPECT_NEAR(cell.driver->state().position_mm.z(), -50, 1e-9);
}

// A limit switch, or another host: the axis counts what nobody knows.
TEST(BjjczPoints, AnAxisThatIsNotWhereItWasSentHasToBeHomed) {
  Cell cell;
  cell.Connect();
  cell.Prepare();
  cell.Begin(2, 40);
  ASSERT_TRUE(cell.Until([&] { return cell.machine.board.moves(); }));
  const auto elsewhere = static_cast<std::int32_t>(cell.machine.board.axis()) - 7;
  ASSERT_TRUE(cell.Until([&] {
    if (cell.driver->state().fault == intaglio_MOTION_OK)
      cell.machine.board.SetAxis(elsewhere);
    return cell.driver->state().fault == intaglio_MOTION_FOLLOWING_ERROR;
  })) << cell.driver->state().message;
  EXPECT_FALSE(cell.driver->state().homed);
  ASSERT_TRUE(cell.driver->ClearFault());
  cell.StepFor(50);
  EXPECT_EQ(FindHindrance(cell.driver->state()).fault, intaglio_MOTION_PLACE_LOST);
  const std::size_t flash_count = cell.flashes().size();
  ASSERT_TRUE(cell.driver->BeginRun(++cell.run, cell.laser().status().tick + 50, 0));
  EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_SAFE_STATE);
  cell.StepFor(500);
  EXPECT_EQ(cell.flashes().size(), flash_count);
  ASSERT_TRUE(cell.driver->ClearFault());
  cell.StepFor(50);
  ASSERT_TRUE(cell.driver->Home()) << cell.driver->state().message;
  EXPECT_TRUE(cell.Until([&] { return cell.driver->state().at_rest; }));
  EXPECT_EQ(FindHindrance(cell.driver->state()), MotionHindrance());
}

// The door is read every 5 ms; the run ends, and nothing more is made.
TEST(BjjczPoints, AnOpenDoorEndsTheRunAndTheGate) {
  Cell cell;
  cell.Connect();
  cell.Prepare();
  cell.Begin(2, 300);
  cell.StepFor(200);
  cell.machine.board.SetInput(kBjjczDoorInput, false);
  cell.StepFor(20);
  const std::size_t flash_count = cell.flashes().size();
  EXPECT_EQ(cell.machine.board.outputs() & 1, 0);
  cell.StepFor(1000);
  EXPECT_EQ(cell.flashes().size(), flash_count);
  EXPECT_EQ(cell.laser().status().openings, 1u);
  EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_SAFE_STATE);
  EXPECT_THAT(cell.driver->state().message, HasSubstr("close them"));
}

TEST(BjjczPoints, WhatItNeedsOfAProfileIsNamed) {
  EXPECT_TRUE(CheckBjjczPointProfile(BjjczPointProfile()).empty());
  MachineSpec machine = BjjczPointProfile();
  machine.mutable_bjjcz_board()->clear_point_frequency_hz();
  machine.mutable_laser()->clear_max_unsettled_points();
  machine.mutable_z()->clear_steps_per_mm();
  machine.mutable_scan_head()->clear_field_mm();
  machine.mutable_head_over_block()->clear_jump_and_dwell();
  std::string all;
  for (const Error& error : CheckBjjczPointProfile(machine)) all += error.message + "\n";
  for (const char* field :
       {"bjjcz_board.point_frequency_hz", "z.steps_per_mm", "laser.max_unsettled_points",
        "scan_head.field_mm", "head_over_block.jump_and_dwell"})
    EXPECT_THAT(all, HasSubstr(field));
  machine = BjjczPointProfile();
  machine.mutable_head_over_block()->mutable_jump_and_dwell()->set_jump_mm_s(500);
  EXPECT_THAT(CheckBjjczPointProfile(machine).at(0).message, HasSubstr("0.14 s"));
}

}  // namespace
}  // namespace intaglio::drivers
