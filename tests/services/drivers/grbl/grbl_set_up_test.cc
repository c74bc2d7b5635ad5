// What a grbl is asked and told when its line comes up, by both of its drivers: a refused
// line of the set-up, and a reset that nobody saw because the line was down.

#include <gtest/gtest.h>

#include <functional>

#include "tests/services/drivers/grbl/course_rig.h"
#include "tests/services/drivers/grbl/grbl_cell.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

/// One driver with its controller; a run of it makes something.
class Rig {
 public:
  virtual ~Rig() = default;
  virtual void Step() = 0;
  virtual GrblMachine& machine() = 0;
  virtual bool settled() = 0;
  virtual std::string fault() = 0;
  virtual std::string place_lost() = 0;
  virtual std::uint32_t openings() = 0;
  virtual std::string power_up() = 0;
  virtual void ClearFault() = 0;
  virtual void MoveAway() = 0;
  /// A whole run; false: it did not come to its end, or nothing was made.
  virtual bool Makes() = 0;

  template <typename Condition>
  bool Until(Condition condition) {
    for (int i = 0; i < 20'000 && !condition(); ++i) Step();
    return condition();
  }
  void StepFor(int time_ms) {
    for (int i = 0; i < time_ms; ++i) Step();
  }
  bool Recovers() {
    return Until([&] {
      if (!fault().empty()) ClearFault();
      return fault().empty() && settled();
    });
  }
};

class PointsRig final : public Rig {
 public:
  void Step() override { cell_.Step(); }
  GrblMachine& machine() override { return cell_.machine; }
  bool settled() override { return cell_.driver->up() && cell_.driver->state().at_rest; }
  std::string fault() override {
    const auto& state = cell_.driver->state();
    return state.fault == intaglio_MOTION_OK ? "" : state.message;
  }
  std::string place_lost() override { return cell_.driver->state().place_lost; }
  std::uint32_t openings() override { return cell_.driver->status().openings; }
  std::string power_up() override {
    return std::to_string(cell_.driver->identity().power_up);
  }
  void ClearFault() override { (void)cell_.driver->ClearFault(); }
  void MoveAway() override {
    ASSERT_TRUE(cell_.driver->Jog(Vec3(3, 2, 1), 50));
    ASSERT_TRUE(Until([&] { return cell_.driver->state().at_rest; }));
  }
  bool Makes() override {
    cell_.Prepare();
    cell_.Begin(5, 0.3, false);
    return Until([&] { return cell_.RunIsOver(); }) &&
           cell_.machine.grbl.motion().flashes().size() == 5;
  }

 private:
  GrblCell cell_;
};

class CourseRigOf final : public Rig {
 public:
  explicit CourseRigOf(CourseToolKind kind) : kind_(kind), rig_(kind) {}
  void Step() override { rig_.Step(); }
  GrblMachine& machine() override { return rig_.machine; }
  bool settled() override {
    return rig_.driver->state().link_up && rig_.driver->state().settled;
  }
  std::string fault() override { return rig_.driver->state().fault; }
  std::string place_lost() override { return rig_.driver->state().place_lost; }
  std::uint32_t openings() override { return rig_.driver->state().openings; }
  std::string power_up() override { return rig_.driver->state().power_up; }
  void ClearFault() override { (void)rig_.driver->Reset(); }
  void MoveAway() override {
    ASSERT_TRUE(rig_.driver->hand()->Jog(Vec3(3, 2, 1), 20));
    ASSERT_TRUE(Until([&] { return settled() && rig_.driver->state().at_rest; }));
  }
  bool Makes() override {
    const bool laser = kind_ == COURSE_TOOL_LASER;
    return rig_.Run(1, Squares(laser ? LaserPen() : MillPen(), 2)) &&
           rig_.CountOf(MarkFate::kDone) == 2;
  }

 private:
  CourseToolKind kind_;
  CourseRig rig_;
};

enum class Driver { kPoints, kLaser, kMill };

class GrblSetUp : public ::testing::TestWithParam<Driver> {
 protected:
  static std::unique_ptr<Rig> Make() {
    switch (GetParam()) {
      case Driver::kPoints:
        break;
      case Driver::kLaser:
        return std::make_unique<CourseRigOf>(COURSE_TOOL_LASER);
      case Driver::kMill:
        return std::make_unique<CourseRigOf>(COURSE_TOOL_SPINDLE);
    }
    return std::make_unique<PointsRig>();
  }
  static void ExpectRefused(Rig& rig, std::uint32_t openings) {
    ASSERT_TRUE(rig.Until([&] { return rig.openings() > openings; }))
        << "it costs the grant";
    EXPECT_NE(rig.fault().find("line of its set-up: error:20"), std::string::npos)
        << rig.fault();
    rig.StepFor(100);
    const std::uint64_t lines = rig.machine().grbl.lines_taken();
    rig.StepFor(1000);
    EXPECT_EQ(rig.machine().grbl.lines_taken(), lines) << "nothing is sent by itself";
    EXPECT_FALSE(rig.machine().grbl.motion().lit());
  }
};

// However often the caller repeats it, and however long its answer takes.
TEST_P(GrblSetUp, ARecoverySendsOneResetAndWaitsForIt) {
  const auto hold = [](Rig& rig) { rig.machine().grbl.PressHold(); };
  const auto limit = [](Rig& rig) { rig.machine().grbl.HitLimit(); };
  for (const auto& inflict : {std::function<void(Rig&)>(hold), {limit}}) {
    const auto rig = Make();
    ASSERT_TRUE(rig->Until([&] { return rig->settled(); }));
    rig->StepFor(200);
    const std::uint64_t before = rig->machine().grbl.resets_taken();
    inflict(*rig);
    ASSERT_TRUE(rig->Until([&] { return !rig->fault().empty(); }));
    rig->StepFor(500);
    ASSERT_TRUE(rig->Recovers()) << rig->fault();
    EXPECT_EQ(rig->machine().grbl.resets_taken(), before + 1);
    rig->StepFor(500);
    EXPECT_EQ(rig->machine().grbl.resets_taken(), before + 1);
    EXPECT_EQ(rig->fault(), "");
  }
}

TEST_P(GrblSetUp, ARefusedLineOfTheFirstIsAFaultUntilItIsCleared) {
  // Behind $I and $$: both of its lines.
  for (const std::uint64_t line : {2, 3}) {
    SCOPED_TRACE(line);
    const auto rig = Make();
    rig->machine().grbl.RefuseLineBehind(line);
    ExpectRefused(*rig, 0);
    ASSERT_TRUE(rig->Recovers());
    EXPECT_TRUE(rig->Makes());
  }
}

TEST_P(GrblSetUp, ARefusedLineBehindAHoldIsAFaultUntilItIsCleared) {
  for (const std::uint64_t line : {0, 1}) {
    SCOPED_TRACE(line);
    const auto rig = Make();
    ASSERT_TRUE(rig->Until([&] { return rig->settled(); }));
    rig->machine().grbl.PressHold();
    ASSERT_TRUE(rig->Until([&] { return !rig->fault().empty(); }));
    const std::uint32_t openings = rig->openings();
    rig->machine().grbl.RefuseLineBehind(line);
    ASSERT_TRUE(rig->Until([&] {
      if (rig->machine().grbl.refuses()) rig->ClearFault();
      return !rig->machine().grbl.refuses();
    }));
    ExpectRefused(*rig, openings);
    ASSERT_TRUE(rig->Recovers());
    EXPECT_TRUE(rig->Makes());
  }
}

/// The line is down for longer than its silence; `what` is done to the controller.
template <typename What>
void WhileTheLineIsDown(Rig& rig, What what) {
  rig.machine().Cut(true);
  rig.StepFor(400);
  what(rig.machine().grbl);
  rig.StepFor(400);
  rig.machine().Cut(false);
  ASSERT_TRUE(rig.Until([&] { return rig.settled(); }));
  rig.StepFor(100);
}

TEST_P(GrblSetUp, AResetThatNobodySawLosesThePlace) {
  for (const bool power : {false, true}) {
    SCOPED_TRACE(power);
    const auto rig = Make();
    ASSERT_TRUE(rig->Until([&] { return rig->settled(); }));
    // A power cycle away from the zero shows by the place alone.
    if (!power) rig->MoveAway();
    const std::string power_up = rig->power_up();
    ASSERT_EQ(rig->place_lost(), "");
    WhileTheLineIsDown(*rig, [&](grbl::VirtualGrbl& grbl) {
      power ? grbl.PowerCycle() : grbl.PressReset();
    });
    EXPECT_NE(rig->place_lost(), "");
    EXPECT_NE(rig->power_up(), power_up);
  }
}

// Also at the zero of its axes, where a power-up begins.
TEST_P(GrblSetUp, ALineThatWasDownCostsNoPlace) {
  for (const bool away : {false, true}) {
    SCOPED_TRACE(away);
    const auto rig = Make();
    ASSERT_TRUE(rig->Until([&] { return rig->settled(); }));
    if (away) rig->MoveAway();
    const std::string power_up = rig->power_up();
    WhileTheLineIsDown(*rig, [](grbl::VirtualGrbl&) {});
    EXPECT_EQ(rig->place_lost(), "");
    EXPECT_EQ(rig->power_up(), power_up);
  }
}

std::string NameOf(const ::testing::TestParamInfo<Driver>& row) {
  return row.param == Driver::kPoints  ? "Points"
         : row.param == Driver::kLaser ? "Laser"
                                       : "Mill";
}

INSTANTIATE_TEST_SUITE_P(Drivers, GrblSetUp,
                         ::testing::Values(Driver::kPoints, Driver::kLaser,
                                           Driver::kMill),
                         &NameOf);

}  // namespace
}  // namespace intaglio::drivers
