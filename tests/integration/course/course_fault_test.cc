// What happens at the controller of a mill or of a laser cutter in the middle of a job:
// its reset, its emergency stop, a hold, a limit, an alarm, a refused line, its mains
// switch. The judge is the true way of the tool, over power cycles and lost steps: behind
// it nothing moves, turns or is lit before a person resumes, and where the place of the
// tool may be lost, not before a person has set the zero.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <thread>
#include <vector>

#include "tests/integration/course/course_shop.h"

namespace intaglio::testing {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr int kSquares = 12;
constexpr double kCellSide_mm = 5, kSquare_mm = 3;

/// Openings into a sheet, in two rows.
std::string Squares() {
  std::string text =
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="30mm" height="10mm" )"
      R"(viewBox="0 0 30 10">)";
  for (int i = 0; i < kSquares; ++i) {
    text += "<rect x=\"" + std::to_string(1 + kCellSide_mm * (i % 6)) + "\" y=\"" +
            std::to_string(1 + kCellSide_mm * (i / 6)) + "\" width=\"" +
            std::to_string(kSquare_mm) + "\" height=\"" + std::to_string(kSquare_mm) +
            "\"/>";
  }
  return text + "</svg>";
}

struct FaultCase {
  const char* name;
  CourseShop::Machine machine;
  std::vector<const char*> at_panel;  ///< the first, and after a second the others
  bool loses_place;
};

class FaultAtTheController : public ::testing::TestWithParam<FaultCase> {
 protected:
  bool is_mill() const { return GetParam().machine == CourseShop::Machine::kMill; }
  void Begin() {
    shop_.Write("squares.svg", Squares());
    ASSERT_TRUE(shop_.Open()) << shop_.Log();
    const std::string tool = is_mill() ? "tool_diameter_mm: 1 depth_mm: 0.5 "
                                         "plunge_mm_s: 10 speed_mm_s: 10"
                                       : "tool_diameter_mm: 0.2 power_ratio: 0.5 "
                                         "speed_mm_s: 10";
    ASSERT_TRUE(shop_.Submit(shop_.WriteJob(
        "squares", "files: \"squares.svg\" make: COURSE_MAKE_CUT inside: true " + tool)));
    ASSERT_TRUE(Eventually(
        [&] {
          // A computer that is too busy for its line.
          shop_.GoOn();
          return WorkLength_mm() > 20;
        },
        60s))
        << shop_.shown() << shop_.Log();
  }
  /// With the beam on, or below the surface.
  std::vector<ToolStep> Work() const {
    std::vector<ToolStep> work;
    for (const ToolStep& step : shop_.Way())
      if (step.on && (!is_mill() || step.lowest_mm() < 0)) work.push_back(step);
    return work;
  }
  double WorkLength_mm() const {
    double length_mm = 0;
    for (const ToolStep& step : Work()) length_mm += step.length_mm();
    return length_mm;
  }
  /// Every motion and every change of output or spindle is a line of it.
  std::string Record() const { return TextIn(shop_.folder() / "way.txt"); }
  void ExpectNothingFor(std::chrono::seconds time, const std::string& what) const {
    const std::string before = Record();
    std::this_thread::sleep_for(time);
    EXPECT_EQ(Record().size(), before.size()) << what << ":\n"
                                              << Record().substr(before.size(), 300);
  }
  /// How far all work is from the contours of the job.
  double Stray_mm() const {
    std::vector<ToolStep> contours;
    for (const mark::Mark& mark : shop_.Marks().marks) {
      std::vector<Vec2> places = mark::PlacesOf(mark, 0.001);
      if (mark.closed) places.push_back(places.front());
      for (std::size_t i = 1; i < places.size(); ++i) {
        ToolStep& way = contours.emplace_back();
        way.from_mm.head<2>() = places[i - 1];
        way.to_mm.head<2>() = places[i];
      }
    }
    double farthest_mm = 0;
    for (const ToolStep& step : Work()) {
      for (const Vec2& place : PlacesOn(step, 0.5))
        farthest_mm = std::max(farthest_mm, DistanceToWay(place, contours));
    }
    return farthest_mm;
  }

  CourseShop shop_{GetParam().machine};
};

TEST_P(FaultAtTheController, NothingMovesOrLightsBeforeAPerson) {
  Begin();
  if (HasFatalFailure()) return;
  const auto& at_panel = GetParam().at_panel;
  shop_.AtPanel(at_panel.front());
  std::this_thread::sleep_for(1s);
  for (std::size_t i = 1; i < at_panel.size(); ++i) shop_.AtPanel(at_panel[i]);
  ASSERT_TRUE(shop_.AwaitState("paused", 20s)) << shop_.shown();
  // The automatic arm behind a lost line takes three seconds at most.
  ExpectNothingFor(5s, "it went on by itself");
  if (GetParam().loses_place) {
    shop_.Type({"resume", "1"});
    ExpectNothingFor(3s, "it went on without a zero");
    shop_.AwaitState("paused", 20s);
    EXPECT_THAT(shop_.shown(), HasSubstr("teach zero"));
  } else {
    ASSERT_TRUE(shop_.AwaitDone(kJobBound)) << shop_.shown() << shop_.Log();
    EXPECT_EQ(shop_.Marks().marks.size(), std::size_t{kSquares});
  }
  EXPECT_LE(Stray_mm(), 0.05);
}

using Machine = CourseShop::Machine;
INSTANTIATE_TEST_SUITE_P(
    Of, FaultAtTheController,
    ::testing::Values(
        FaultCase{"laser_hold", Machine::kLaser, {"hold"}, false},
        FaultCase{"laser_error", Machine::kLaser, {"error"}, false},
        FaultCase{"laser_reset", Machine::kLaser, {"reset"}, true},
        FaultCase{"laser_power", Machine::kLaser, {"power off", "power on"}, true},
        FaultCase{"laser_limit", Machine::kLaser, {"limit"}, true},
        FaultCase{"mill_emergency_stop",
                  Machine::kMill,
                  {"estop press", "estop release"},
                  true},
        FaultCase{"mill_hold", Machine::kMill, {"hold"}, false},
        FaultCase{"mill_alarm", Machine::kMill, {"alarm"}, true},
        FaultCase{"mill_power", Machine::kMill, {"power off", "power on"}, true}),
    [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace intaglio::testing
