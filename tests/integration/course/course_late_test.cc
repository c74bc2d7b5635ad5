// A mill on a computer whose job service does not run for a while, so that its permission
// comes late: the tool rests in the work and turns, and every contour is cut to its end.
// Behind the longest rest the spindle is ended where it is, and the job is not good. The
// judge is the true way of the tool.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <thread>

#include "tests/integration/course/course_shop.h"

namespace intaglio::testing {
namespace {

using namespace std::chrono_literals;
using formats::PointOutcome;
using ::testing::HasSubstr;

constexpr std::size_t kLateSquares = 6;
constexpr char kJobService[] = "intaglio-job-service";

class LatePermission : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string drawing =
        R"(<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="10mm" )"
        R"(viewBox="0 0 60 10">)";
    for (std::size_t i = 0; i < kLateSquares; ++i)
      drawing += "<rect x=\"" + std::to_string(1 + 10 * i) +
                 "\" y=\"1\" width=\"8\" height=\"8\"/>";
    shop_.Write("squares.svg", drawing + "</svg>");
    ASSERT_TRUE(shop_.Open()) << shop_.Log();
    ASSERT_TRUE(shop_.Submit(
        shop_.WriteJob("squares",
                       "files: \"squares.svg\" make: COURSE_MAKE_CUT inside: true "
                       "tool_diameter_mm: 1 depth_mm: 0.5 plunge_mm_s: 10 "
                       "speed_mm_s: 10")));
  }
  double CutLength_mm() const {
    double length_mm = 0;
    for (const ToolStep& step : shop_.Way())
      if (step.on && step.lowest_mm() < -0.4) length_mm += step.length_mm();
    return length_mm;
  }
  /// In a contour, so much further than now.
  bool AwaitCut(double more_mm) {
    const double from_mm = CutLength_mm();
    return Eventually(
        [&] {
          if (CutLength_mm() > from_mm + more_mm) return true;
          shop_.GoOn();
          return false;
        },
        60s);
  }
  /// Every motion and every change of the spindle is a line of it.
  std::string Record() const { return TextIn(shop_.folder() / "way.txt"); }

  CourseShop shop_{CourseShop::Machine::kMill};
};

TEST_F(LatePermission, TheToolRestsInTheWorkAndEveryContourIsCutToItsEnd) {
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(AwaitCut(15)) << shop_.shown() << shop_.Log();
    ASSERT_EQ(shop_.Signal(kJobService, SIGSTOP), 1);
    // The lease of 90 ms, what was sent ahead, and a busy computer.
    std::this_thread::sleep_for(800ms);
    const std::string rests = Record();
    std::this_thread::sleep_for(300ms);
    EXPECT_EQ(Record(), rests) << "it goes on, or its spindle was ended";
    EXPECT_TRUE(shop_.Way().back().on);
    ASSERT_EQ(shop_.Signal(kJobService, SIGCONT), 1);
  }
  ASSERT_TRUE(shop_.AwaitDone(kJobBound)) << shop_.shown() << shop_.Log();
  // A line that this computer was too busy for is another matter, once at most.
  const auto outcomes = shop_.Outcomes(kLateSquares);
  const auto made = std::ranges::count(outcomes, PointOutcome::kMade);
  const std::size_t lapses = std::min<std::size_t>(1, shop_.Lapses());
  EXPECT_GE(made + lapses, kLateSquares) << shop_.shown();
  if (lapses == 0) {
    EXPECT_THAT(shop_.shown(), HasSubstr("verdict    good"));
  }
}

TEST_F(LatePermission, BehindTheLongestRestTheContourIsBrokenAndTheJobIsNotGood) {
  ASSERT_TRUE(AwaitCut(15)) << shop_.shown() << shop_.Log();
  ASSERT_EQ(shop_.Signal(kJobService, SIGSTOP), 1);
  std::this_thread::sleep_for(4s);
  const std::string ended = Record();
  std::this_thread::sleep_for(500ms);
  EXPECT_EQ(Record(), ended);
  ASSERT_EQ(shop_.Signal(kJobService, SIGCONT), 1);
  ASSERT_TRUE(shop_.AwaitDone(kJobBound)) << shop_.shown() << shop_.Log();
  const auto outcomes = shop_.Outcomes(kLateSquares);
  EXPECT_GE(std::ranges::count(outcomes, PointOutcome::kUncertain), 1);
  EXPECT_THAT(shop_.shown(), HasSubstr("verdict    not_good"));
  EXPECT_THAT(shop_.shown(), HasSubstr("uncertain"));
}

}  // namespace
}  // namespace intaglio::testing
