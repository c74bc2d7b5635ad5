// The driver of isel's controllers in a run, against the virtual isel: where pulses are,
// and what a cover, a stop, a reset and a lost line leave.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/services/drivers/isel/isel_rig.h"

namespace intaglio::drivers {
namespace {

using link::TickOutcome;
using ::testing::HasSubstr;
constexpr double kStepsPerMm = 400;

/// A run along points on a winding way, all of them armed.
class Cell {
 public:
  explicit Cell(bool homed = true) : machine(Options()) {
    if (!homed) machine.SwitchOn(false);
    driver = machine.MakeDriver(Profile());
  }
  static isel::VirtualIselOptions Options() {
    isel::VirtualIselOptions options;
    options.travel_min.fill(-20000);
    options.travel_max.fill(20000);
    return options;
  }
  static MachineSpec Profile() {
    MachineSpec profile = IselProfile();
    for (AxisLimits* axis :
         {profile.mutable_x(), profile.mutable_y(), profile.mutable_z()}) {
      axis->set_steps_per_mm(kStepsPerMm);
    }
    return profile;
  }

  void Step() {
    machine.Advance();
    driver->Poll(
        [this](const link::PulseReport& report) {
          for (std::size_t i = 0; i < report.outcome.size(); ++i) {
            if (report.outcome[i] == TickOutcome::kNotArmed) continue;
            EXPECT_TRUE(outcomes.emplace(report.first_tick + i, report.outcome[i]).second)
                << "tick " << report.first_tick + i << " is reported twice";
          }
        },
        [this](const link::PastReport& report) { past = report; });
    (void)driver->TakePositions();
    while (!segments.empty() && driver->Room() > 0 && driver->up()) {
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
    ASSERT_TRUE(Until([&] { return driver->up(); })) << driver->message();
  }
  void Prepare() {
    ASSERT_TRUE(driver->Reset() && driver->Lamp(true, kIselRateHz) &&
                driver->ClearFault());
    StepFor(5);
    ASSERT_TRUE(driver->OpenShutters(1));
    ASSERT_TRUE(Until([&] {
      return driver->Has(link::kLampWarm) && driver->status().shutters_open == 1 &&
             driver->state().at_rest;
    })) << driver->state().message;
  }
  /// 4 ticks from each point to the next; all are armed.
  void Begin(int count) {
    const std::uint64_t start =
        std::max(driver->status().tick, driver->status().decided_through) + 3;
    ASSERT_TRUE(driver->BeginRun(++run, start, 0)) << driver->state().message;
    Vec3 place = driver->state().position_mm;
    for (int i = 1; i <= count; ++i) {
      motion::Segment segment;
      place += Vec3(0.3 * std::cos(0.1 * i), 0.3 * std::sin(0.1 * i), 0.02);
      segment.end_position_mm = place;
      segment.duration_subticks = 4 * motion::kSubticksPerTick;
      segment.pulse = true;
      segment.program_end = i == count;
      points[start + 4 * static_cast<std::uint64_t>(i)] = place;
      segments.push_back(segment);
    }
    std::vector<bool> fire;
    for (std::uint64_t tick = start - 2; tick <= points.rbegin()->first; ++tick)
      fire.push_back(points.count(tick) != 0);
    ASSERT_TRUE(driver->Arm({start - 2, true, fire, false, 10}));
  }
  bool AwaitEnd() {
    return Until([&] { return segments.empty() && driver->state().at_rest; });
  }
  /// Each flash is at rest, at the step of a point, and no point has two.
  std::size_t FlashesAtTheirPoints() const {
    std::map<std::uint64_t, int> made;
    for (const isel::Flash& flash : machine.isel.flashes()) {
      EXPECT_FALSE(flash.moved);
      bool found = false;
      for (const auto& [tick, place] : points) {
        bool here = true;
        for (int i = 0; i < 3; ++i) {
          here = here && flash.place[static_cast<std::size_t>(i)] ==
                             std::lround(place[i] * kStepsPerMm);
        }
        if (here) ++made[tick];
        found = found || here;
      }
      EXPECT_TRUE(found) << "a flash is at no point";
    }
    for (const auto& [tick, count] : made) EXPECT_EQ(count, 1) << tick;
    return made.size();
  }

  IselMachine machine;
  std::unique_ptr<IselDriver> driver;
  std::map<std::uint64_t, Vec3> points;
  std::map<std::uint64_t, TickOutcome> outcomes;
  link::PastReport past;
  std::vector<motion::Segment> segments;
  std::uint32_t run = 0;
};

TEST(IselDriver, EveryPulseIsAtRestAtTheStepOfItsPoint) {
  Cell cell;
  cell.Connect();
  cell.Prepare();
  cell.Begin(40);
  ASSERT_TRUE(cell.AwaitEnd()) << cell.driver->state().message;
  EXPECT_EQ(cell.FlashesAtTheirPoints(), 40u);
  for (const auto& [tick, place] : cell.points)
    EXPECT_EQ(cell.outcomes[tick], TickOutcome::kFiredUnseen) << tick;
  EXPECT_EQ(cell.driver->status().pulse_count, 40u);
  EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_OK);
  for (const isel::Flash& flash : cell.machine.isel.flashes())
    EXPECT_NEAR(flash.off_us - flash.on_us, 7 * 10e6 / 19200, 400) << "one write";
}

// The line is cut at any byte: of a move, of a question, between on and off.
TEST(IselDriver, ALostLineLeavesOnePointUncertainAndDoublesNone) {
  int lit = 0;
  for (std::uint64_t bytes = 0; bytes < 400; bytes += 3) {
    Cell cell;
    cell.Connect();
    cell.Prepare();
    cell.Begin(12);
    const std::uint64_t first = cell.points.begin()->first;
    cell.machine.CutAfter(bytes);
    ASSERT_TRUE(cell.Until([&] { return !cell.driver->up(); }, 3000));
    cell.StepFor(1000);
    const auto flashes = cell.machine.isel.flashes().size();
    lit += cell.machine.isel.output();
    cell.machine.Cut(false);
    cell.Connect();
    EXPECT_FALSE(cell.machine.isel.output()) << "what comes first is off";
    cell.StepFor(1000);
    EXPECT_EQ(cell.machine.isel.flashes().size(), flashes) << "nothing fires by itself";
    EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_STARVED);
    const std::size_t made = cell.FlashesAtTheirPoints();
    ASSERT_TRUE(cell.driver->RequestPast(first, 50));
    cell.StepFor(2);
    std::size_t known = 0, uncertain = 0;
    for (const TickOutcome outcome : cell.past.outcome) {
      known += outcome == TickOutcome::kFiredUnseen;
      uncertain += outcome == TickOutcome::kNoLongerKnown;
    }
    EXPECT_LE(uncertain, 1u) << bytes;
    EXPECT_LE(known, made) << bytes;
    EXPECT_GE(known + uncertain, made) << bytes;
  }
  EXPECT_GT(lit, 0) << "no cut was between on and off";
}

TEST(IselDriver, AnOpenChainEndsTheRunAndNothingFollowsByItself) {
  Cell cell;
  cell.Connect();
  cell.Prepare();
  cell.Begin(30);
  ASSERT_TRUE(cell.Until([&] { return cell.machine.isel.flashes().size() > 5; }));
  cell.machine.isel.SetCover(true);
  cell.StepFor(100);
  const auto flashes = cell.machine.isel.flashes().size();
  EXPECT_FALSE(cell.driver->Has(link::kDoorClosed));
  EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_SAFE_STATE);
  EXPECT_THAT(cell.driver->state().message, HasSubstr("chain of door and stop"));
  cell.machine.isel.SetCover(false);
  cell.StepFor(1000);
  EXPECT_EQ(cell.machine.isel.flashes().size(), flashes);
  EXPECT_TRUE(cell.driver->Has(link::kDoorClosed));
  EXPECT_EQ(cell.driver->status().openings, 1u);
  cell.segments.clear();
  cell.Prepare();
  cell.points.clear();
  cell.Begin(5);
  ASSERT_TRUE(cell.AwaitEnd());
  EXPECT_EQ(cell.machine.isel.flashes().size(), flashes + 5);
}

TEST(IselDriver, WithoutAReferenceOnlyHomeMovesIt) {
  Cell cell(false);
  cell.Connect();
  EXPECT_FALSE(cell.driver->state().homed);
  EXPECT_FALSE(cell.driver->Jog(Vec3(1, 0, 0), 5));
  cell.Prepare();
  ASSERT_TRUE(cell.driver->BeginRun(1, cell.driver->status().tick + 5, 0));
  EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_SAFE_STATE);
  EXPECT_THAT(cell.driver->state().message, HasSubstr("home"));
  ASSERT_TRUE(cell.driver->ClearFault());
  cell.StepFor(5);
  ASSERT_TRUE(cell.driver->Home());
  EXPECT_FALSE(cell.driver->state().at_rest);
  ASSERT_TRUE(cell.Until([&] { return cell.driver->state().at_rest; }));
  EXPECT_TRUE(cell.driver->state().homed);
  EXPECT_TRUE(cell.driver->Jog(Vec3(1, 0, 0), 5));
}

TEST(IselDriver, HoldEndsHoming) {
  Cell cell;
  cell.Connect();
  ASSERT_TRUE(cell.driver->Jog(Vec3(20, 0, 0), 20));
  ASSERT_TRUE(cell.Until([&] { return cell.driver->state().at_rest; }));
  ASSERT_TRUE(cell.driver->Home());
  cell.StepFor(500);
  ASSERT_TRUE(cell.machine.isel.moves());
  EXPECT_TRUE(cell.driver->up()) << "silence is not a lost line while it homes";
  ASSERT_TRUE(cell.driver->Hold());
  cell.StepFor(20);
  EXPECT_FALSE(cell.machine.isel.moves());
  ASSERT_TRUE(cell.Until([&] { return cell.driver->state().at_rest; }, 100));
  EXPECT_EQ(cell.driver->state().fault, intaglio_MOTION_OK);
}

// A host of before died between on and off.
TEST(IselDriver, AnOutputThatWasLeftOnGoesOffFirst) {
  Cell cell;
  cell.machine.isel.Write("@07\r@0B1,1\r@0M100");
  for (int i = 0; i < 50; ++i) cell.machine.Advance();
  ASSERT_TRUE(cell.machine.isel.output());
  cell.Connect();
  EXPECT_FALSE(cell.machine.isel.output());
  EXPECT_EQ(cell.machine.isel.place(), (isel::Steps{0, 0, 0})) << "half a command moves";
}

TEST(IselDriver, AProfileThatItCannotServeIsRefused) {
  MachineSpec profile = Cell::Profile();
  profile.mutable_y()->clear_steps_per_mm();
  IselMachine machine(Cell::Options());
  const auto without_steps = machine.MakeDriver(profile);
  without_steps->Poll();
  EXPECT_EQ(without_steps->state().fault, intaglio_MOTION_WRONG_CONTROLLER);
  EXPECT_THAT(without_steps->state().message, HasSubstr("y.steps_per_mm"));
  profile = Cell::Profile();
  profile.mutable_motion_line()->set_serial_number("I-07");
  const auto named = machine.MakeDriver(profile);
  named->Poll();
  EXPECT_THAT(named->state().message, HasSubstr("motion_line.serial_number"));
}

// Another program, or a hand, has moved it since its last move.
TEST(IselDriver, AtAnotherPlaceThanItsPointNothingFires) {
  Cell cell;
  cell.Connect();
  cell.Prepare();
  cell.Begin(30);
  ASSERT_TRUE(cell.Until([&] { return cell.machine.isel.flashes().size() == 5; }));
  // Behind the end of a move, before the place is read.
  ASSERT_TRUE(cell.Until([&] { return cell.machine.isel.moves(); }));
  ASSERT_TRUE(cell.Until([&] { return !cell.machine.isel.moves(); }));
  cell.machine.isel.MoveAtPanel(0, 3);
  ASSERT_TRUE(cell.Until([&] {
    return cell.driver->state().fault == intaglio_MOTION_FOLLOWING_ERROR;
  })) << cell.driver->state().message;
  EXPECT_EQ(cell.machine.isel.flashes().size(), 5u);
}

}  // namespace
}  // namespace intaglio::drivers
