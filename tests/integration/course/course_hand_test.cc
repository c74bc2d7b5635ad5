// A person at a mill: the tool is driven to the corner of the sheet by hand, the work
// zero is set, and the plate is cut there. The judge is the way that the tool really
// went.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <optional>
#include <thread>

#include "tests/integration/course/course_shop.h"

namespace intaglio::testing {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;

class MillByHand : public ::testing::Test {
 protected:
  void SetUp() override {
    shop_.Write(
        "plate.svg",
        R"(<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="20mm" )"
        R"(viewBox="0 0 20 20"><rect x="2" y="3" width="16" height="14"/></svg>)");
    ASSERT_TRUE(shop_.Open()) << shop_.Log();
    ASSERT_TRUE(Eventually(
        [&] { return Teach({"status"}).find("by hand: allowed") != std::string::npos; },
        20s))
        << Teach({"status"});
  }
  std::string Teach(std::vector<std::string> words) const {
    words.insert(words.begin(), "teach");
    return shop_.Type(words);
  }
  std::string Do(const std::vector<std::string>& words) const {
    return shop_.Teach(words);
  }
  std::filesystem::path Job(const std::string& more = "") const {
    return shop_.WriteJob(
        "plate",
        "files: \"plate.svg\" make: COURSE_MAKE_CUT tool_diameter_mm: 2 "
        "depth_mm: 1 speed_mm_s: 50 plunge_mm_s: 10 " +
            more);
  }
  Vec3 PlaceNow() const {
    const auto way = shop_.Way();
    return way.empty() ? Vec3(Vec3::Zero()) : way.back().to_mm;
  }
  /// A jog of x by 60 mm at 20 mm/s, which is 4 mm on its way. A press that a busy
  /// computer has lost is repeated.
  void JogFrom(double from_mm, std::optional<Running>& jog) {
    const auto moves = [&] { return PlaceNow().x() > from_mm + 4; };
    for (int i = 0; i < 5 && !moves(); ++i) {
      jog.emplace(Program("intaglio"),
                  shop_.With({"teach", "jog", "x", "60", "--speed", "20"}),
                  shop_.folder() / "jog.txt");
      Eventually([&] { return moves() || !jog->running(); }, 20s);
    }
    ASSERT_TRUE(moves()) << jog->Output();
  }

  CourseShop shop_{CourseShop::Machine::kMill};
};

TEST_F(MillByHand, APlateIsCutWhereThePersonHasSetTheZero) {
  EXPECT_THAT(Do({"move", "40", "25", "-7"}),
              MatchesRegex("x (39.99|40.00).* mm, y (24.99|25.00).* mm, z -[67].* mm\n"));
  EXPECT_LT((PlaceNow() - Vec3(40, 25, -7)).norm(), 0.004);
  EXPECT_THAT(Do({"zero", "--axes", "xy"}), HasSubstr("the work zero is set"));
  // A gauge of 0.1 mm is between tool and sheet.
  EXPECT_THAT(Do({"zero", "--axes", "z", "--height", "0.1"}),
              HasSubstr("the tool is at 0.000, 0.000, 0.100"));
  EXPECT_THAT(Do({"move", "0", "0", "5"}), HasSubstr(" mm, z "));
  for (const ToolStep& step : shop_.Way())
    EXPECT_FALSE(step.on) << "the spindle turns by hand";
  const std::size_t by_hand = shop_.Way().size();
  ASSERT_TRUE(shop_.Submit(Job()));
  ASSERT_TRUE(shop_.AwaitDone(kJobBound)) << shop_.shown() << shop_.Log();
  const std::vector<ToolStep> way = shop_.Way();
  Box3 work{Vec3::Constant(1e9), Vec3::Constant(-1e9)};
  for (std::size_t i = by_hand; i < way.size(); ++i) {
    if (way[i].lowest_mm() > -7.2) continue;
    EXPECT_TRUE(way[i].on);
    work.min_mm = work.min_mm.cwiseMin(way[i].to_mm);
    work.max_mm = work.max_mm.cwiseMax(way[i].to_mm);
  }
  // The plate is at 2..18, 3..17 of the sheet; the tool's middle runs 1 mm beside it.
  EXPECT_LT((work.min_mm.head<2>() - Vec2(41, 27)).norm(), 0.006);
  EXPECT_LT((work.max_mm.head<2>() - Vec2(59, 43)).norm(), 0.006);
  EXPECT_NEAR(work.min_mm.z(), -7.1 - 1, 0.004);
}

TEST_F(MillByHand, MotionEndsWithTheProgramThatHoldsIt) {
  for (const int how : {SIGINT, SIGKILL}) {
    const double from_mm = PlaceNow().x();
    std::optional<Running> jog;
    ASSERT_NO_FATAL_FAILURE(JogFrom(from_mm, jog));
    jog->Signal(how);
    // 200 ms without a command, what was sent ahead (at most 0.15 s), and the braking;
    // and a computer that is busy.
    std::this_thread::sleep_for(1s);
    const double rests_mm = PlaceNow().x();
    EXPECT_LT(rests_mm, from_mm + 4 + 20 * 0.8);
    std::this_thread::sleep_for(1s);
    EXPECT_EQ(PlaceNow().x(), rests_mm) << "it goes on";
    jog->WaitForEnd(10s);
  }
}

// The controller is idle behind it, and nothing but its place says so.
TEST_F(MillByHand, AHoldAtTheControllerEndsAJogUntilAnotherOne) {
  const double from_mm = PlaceNow().x();
  std::optional<Running> jog;
  ASSERT_NO_FATAL_FAILURE(JogFrom(from_mm, jog));
  shop_.AtPanel("hold");
  const Ended ended = jog->WaitForEnd(10s);
  EXPECT_EQ(ended.exit_code, 4) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("as a hold at it does"));
  const double rests_mm = PlaceNow().x();
  EXPECT_LT(rests_mm, from_mm + 50);
  std::this_thread::sleep_for(2s);
  EXPECT_EQ(PlaceNow().x(), rests_mm) << "it goes on";
  EXPECT_THAT(Teach({"jog", "x", "2"}), HasSubstr("y 0.0000 mm")) << "it says its place";
  EXPECT_NEAR(PlaceNow().x(), rests_mm + 2, 0.01);
}

TEST_F(MillByHand, WhileAJobIsArmedOrADoorIsOpenNothingIsMovedByHand) {
  shop_.AtPanel("door open");
  ASSERT_TRUE(Eventually(
      [&] { return Teach({"status"}).find("door OPEN") != std::string::npos; }, 20s));
  EXPECT_THAT(Teach({"jog", "x", "5"}), HasSubstr("door"));
  EXPECT_THAT(Teach({"zero"}), HasSubstr("door"));
  shop_.AtPanel("door close");
  ASSERT_TRUE(Eventually(
      [&] { return Teach({"status"}).find("door closed") != std::string::npos; }, 20s));
  EXPECT_THAT(Teach({"park"}), HasSubstr("its work zero"));
  EXPECT_THAT(Teach({"lamp", "--for", "1"}), HasSubstr("neither lamp nor shutter"));
  EXPECT_TRUE(shop_.Way().empty());
  ASSERT_TRUE(shop_.Submit(Job("repeat_count: 60")));
  // A line that was lost pauses the job, which then permits it.
  std::string answer;
  const auto is_refused = [&](const std::vector<std::string>& words) {
    shop_.GoOn();
    answer = Teach(words);
    return answer.find("a job") != std::string::npos;
  };
  EXPECT_TRUE(Eventually([&] { return is_refused({"jog", "x", "0.1"}); }, 60s)) << answer;
  EXPECT_TRUE(Eventually([&] { return is_refused({"zero"}); }, 60s)) << answer;
  shop_.Type({"cancel", "1"});
}

}  // namespace
}  // namespace intaglio::testing
