// What the outputs of a stage do, edge by edge.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "tests/services/drivers/motion_bench.h"
#include "tests/services/reference_controller/stage_rig.h"

namespace intaglio::reference_controller {
namespace {

using namespace std::chrono_literals;
using drivers::Course;
using drivers::MotionBench;

/// A rig in a bench, whose edges a test reads.
class StageEdges : public ::testing::Test {
 protected:
  void Make(bool homes = true) {
    bench.reset();  // its line has the same name
    bench = std::make_unique<MotionBench>([&](const std::string& serial_number) {
      auto made = std::make_unique<StageRig>(serial_number, homes);
      rig = made.get();
      return made;
    });
    bench->Connect();
    began = rig->edges().size();
  }
  std::vector<Edge> NewEdges() const {
    return {rig->edges().begin() + static_cast<std::ptrdiff_t>(began),
            rig->edges().end()};
  }
  std::size_t CountOf(Output output) const {
    const auto edges = NewEdges();
    return static_cast<std::size_t>(
        std::ranges::count_if(edges, [&](const Edge& e) { return e.output == output; }));
  }

  std::unique_ptr<MotionBench> bench;
  StageRig* rig = nullptr;
  std::size_t began = 0;
};

TEST_F(StageEdges, StepsKeepTheTimesOfTheDriveAndFollowTheCommandWithinAStep) {
  Make();
  const Course course = bench->CourseFromHere();
  const std::uint64_t start = bench->Begin(1);
  bench->Append(course.Segments());
  const double step_mm = 1 / rig->options().steps.steps_per_mm.x();
  const double offset_mm =
      rig->actual_mm().x() - rig->controller().stage().actual_mm().x();
  for (int ms = 0; ms < 1000; ++ms) {
    bench->Step();
    const double ticks = 1e-7 * static_cast<double>(rig->controller().NsAt(rig->now()) -
                                                    rig->NsOfTick(start));
    // The oracle knows whole ticks; between them, where it cruises, it is linear.
    if (ticks < 6 || ticks > 5 + course.cruise_ticks - 1) continue;
    const auto tick = static_cast<std::uint32_t>(ticks);
    const double part = ticks - tick;
    const double planned =
        (1 - part) * course.At(tick) + part * course.At(tick + 1) + offset_mm;
    // Half a step, and what passes in a turn.
    EXPECT_NEAR(rig->actual_mm().x(), planned, 0.55 * step_mm + 0.001) << ticks;
  }
  std::map<Output, std::chrono::nanoseconds> on_at, turned_at;
  for (const Edge& edge : NewEdges()) {
    if (edge.output == Output::kDirectionX) turned_at[edge.output] = edge.at;
    if (edge.output != Output::kStepX) continue;
    if (!edge.on) {
      EXPECT_GE(edge.at - on_at[edge.output], rig->options().steps.pulse);
      continue;
    }
    if (on_at.contains(edge.output)) {
      EXPECT_GE(edge.at - on_at[edge.output], 50us);
    }
    if (turned_at.contains(Output::kDirectionX)) {
      EXPECT_GE(edge.at - turned_at[Output::kDirectionX],
                rig->options().steps.direction_setup);
    }
    on_at[edge.output] = edge.at;
  }
  EXPECT_NEAR(static_cast<double>(CountOf(Output::kStepX)) / 2,
              (course.end_mm() - course.x0_mm) / step_mm, 1.1);
  EXPECT_EQ(CountOf(Output::kStepY) + CountOf(Output::kStepZ), 0u);
}

TEST_F(StageEdges, NothingIsSwitchedBeforeAPersonHomesIt) {
  Make(false);
  EXPECT_FALSE(bench->state().homed);
  EXPECT_TRUE(bench->driver().Jog(Vec3(1, 0, 0), 1).error().message.size() > 20);
  bench->Begin(1);
  bench->Append(bench->CourseFromHere().Segments());
  bench->ExpectFault(intaglio_MOTION_SAFE_STATE, "a run before home");
  bench->StepFor(1s);
  EXPECT_TRUE(rig->edges().empty()) << "no step, no drive, no in-position";
  EXPECT_GT(rig->pins().alive_count(), 900u);
  bench->ClearFault();
  ASSERT_TRUE(rig->FindPlace());
  EXPECT_TRUE(rig->pins().is_on(Output::kEnable));
  EXPECT_LT(rig->actual_mm().norm(), rig->tolerance_mm()) << "home is at zero";
}

TEST_F(StageEdges, InPositionIsOnAroundMarkedPointsAndThereAlone) {
  Make();
  Course course = bench->CourseFromHere();
  auto segments = course.Segments();
  std::vector<std::uint32_t> marked;
  for (const std::size_t i : {3U, 4U, 9U, 15U}) {
    segments[i].pulse = true;
    marked.push_back(5 + static_cast<std::uint32_t>(i));  // ticks after the start
  }
  const std::uint64_t start = bench->Begin(1);
  bench->Append(segments);
  bench->StepFor(1s);
  std::vector<std::pair<double, double>> on;  // ticks after the start
  for (const Edge& edge : NewEdges()) {
    if (edge.output != Output::kInPosition) continue;
    const double ticks = 1e-7 * (static_cast<double>(rig->controller().NsAt(edge.at)) -
                                 static_cast<double>(rig->NsOfTick(start)));
    if (edge.on) on.emplace_back(ticks, 1e9);
    if (!edge.on) on.back().second = ticks;
  }
  ASSERT_EQ(on.size(), marked.size());
  for (std::size_t i = 0; i < on.size(); ++i) {
    EXPECT_LT(on[i].first, marked[i]) << "at the tick it is on";
    EXPECT_GT(on[i].second, marked[i]);
    // 0.35 ms of a tick of 10 ms, and a turn.
    EXPECT_GT(on[i].first, marked[i] - 0.041);
    EXPECT_LT(on[i].second, marked[i] + 0.041);
  }
}

// A controller that hangs leaves its output on, and the ticks of the next points come.
TEST_F(StageEdges, InPositionEndsForTheLaserWhenTheControllerHangs) {
  Make();
  Course course = bench->CourseFromHere();
  auto segments = course.Segments();
  segments[9].pulse = true;
  const std::uint64_t start = bench->Begin(1);
  bench->Append(segments);
  ASSERT_TRUE(rig->Until([&] { return rig->pins().is_on(Output::kInPosition); }));
  EXPECT_GT(rig->controller().NsAt(rig->now()), rig->NsOfTick(start + 13));
  EXPECT_GT(rig->controller().witness().in_position_until, rig->now());
  rig->Stall(600us);
  EXPECT_TRUE(rig->pins().is_on(Output::kInPosition));
  EXPECT_LT(rig->controller().witness().in_position_until, rig->now());
  bench->StepFor(5ms);
  EXPECT_FALSE(rig->pins().is_on(Output::kInPosition));
  EXPECT_EQ(rig->controller().witness().in_position_until.count(), 0);
}

TEST_F(StageEdges, AStopCutsTheDrivesAtOnceAndThePlaceIsLost) {
  for (const Input input : {Input::kStop, Input::kDrives}) {
    Make();
    bench->MoveALot(1);
    rig->pins().Hold(input, false);
    bench->StepFor(3ms);
    const std::uint64_t steps = rig->step_count();
    EXPECT_FALSE(rig->pins().is_on(Output::kEnable));
    bench->StepFor(500ms);
    EXPECT_EQ(rig->step_count(), steps);
    EXPECT_FALSE(bench->state().homed);
    EXPECT_TRUE(bench->driver().ClearFault().has_value());
    bench->StepFor(100ms);
    EXPECT_EQ(bench->state().fault, intaglio_MOTION_SAFE_STATE) << "its cause is there";
    rig->pins().Hold(input, true);
    bench->StepFor(500ms);
    EXPECT_EQ(rig->step_count(), steps);
    EXPECT_FALSE(rig->pins().is_on(Output::kEnable)) << "until a person homes it";
  }
}

TEST_F(StageEdges, StepsThatAreTooLateAreAFaultAndNeverFasterThanTheDriveAllows) {
  for (const auto& [stall, fault] :
       {std::pair{std::chrono::nanoseconds(5ms), intaglio_MOTION_OK},
        std::pair{std::chrono::nanoseconds(50ms), intaglio_MOTION_FOLLOWING_ERROR}}) {
    Make();
    bench->MoveALot(1);
    rig->Stall(stall);
    bench->StepFor(1s);
    EXPECT_EQ(bench->state().fault, fault) << bench->Message();
    EXPECT_EQ(bench->state().homed, fault == intaglio_MOTION_OK);
    std::chrono::nanoseconds before{0};
    for (const Edge& edge : NewEdges()) {
      if (edge.output != Output::kStepX || !edge.on) continue;
      EXPECT_GE(edge.at - before, 50us);
      before = edge.at;
    }
  }
}

TEST_F(StageEdges, OutputsAreOffWhenTheControllerIsGone) {
  Make();
  bench->MoveALot(1);
  rig->SwitchOff();
  const auto edges = NewEdges();
  std::map<Output, bool> left;
  for (const Edge& edge : rig->edges()) left[edge.output] = edge.on;
  for (const auto& [output, on] : left) EXPECT_FALSE(on) << NameOf(output);
  bench->StepFor(1s);
  EXPECT_EQ(NewEdges().size(), edges.size());
}

TEST_F(StageEdges, ABoardThatFailsEndsTheMotionWithAnError) {
  Make();
  bench->MoveALot(1);
  const std::uint64_t steps = rig->step_count();
  rig->BreakBoard();
  bench->StepFor(300ms);
  EXPECT_EQ(rig->error(), "the board is broken");
  EXPECT_EQ(rig->step_count(), steps);
}

TEST_F(StageEdges, ASwitchThatIsNotThereIsNamed) {
  Make(false);
  rig->pins().Hold(Input::kFreeY, true);
  ASSERT_TRUE(bench->driver().Home().has_value());
  ASSERT_TRUE(
      rig->Until([&] { return bench->state().fault != intaglio_MOTION_OK; }, 30s));
  EXPECT_NE(bench->Message().find("the switch of y was not met"), std::string::npos)
      << bench->Message();
  EXPECT_FALSE(bench->state().homed);
}

}  // namespace
}  // namespace intaglio::reference_controller
