// The outline that a guide laser draws, by the record of a BJJCZ board of the tests' own.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/services/drivers/bjjcz/point_rig.h"
#include "tests/services/drivers/motion_conformance.h"

namespace intaglio::drivers {
namespace {

using ::testing::HasSubstr;

// Half a place on both axes.
constexpr double kRoundedPlaces = 0.7072;
constexpr double kMiddlePlace = 32768;
constexpr std::uint16_t kGate = 1, kGuide = 1U << kBoardGuideOutput;

class Board {
 public:
  explicit Board(const MachineSpec& profile = BjjczPointProfile(),
                 bool needs_oscillator = false)
      : machine(needs_oscillator, true),
        driver(MakeBjjczPointDriverAt(machine, profile)) {
    for (int i = 0; i < 3000 && !driver->state().link_up; ++i) Step();
    EXPECT_TRUE(driver->state().at_rest) << driver->state().message;
  }
  void Step() {
    machine.Advance();
    driver->Poll();
    const std::uint64_t lists = board().lists_executed();
    list_ms_ = board().moves() && lists == lists_ ? list_ms_ + 1 : 0;
    lists_ = lists;
    longest_list_ms = std::max(longest_list_ms, list_ms_);
  }
  void StepFor(int ms) {
    for (int i = 0; i < ms; ++i) Step();
  }
  const bjjcz::VirtualBjjcz& board() const { return machine.board; }

  BjjczMachine machine;
  std::unique_ptr<MotionDriver> driver;
  int longest_list_ms = 0;

 private:
  std::uint64_t lists_ = 0;
  int list_ms_ = 0;
};

Vec2 PlaceOf(const Vec2& at_mm) {
  return kBoardPlacesPerMm * at_mm + Vec2(kMiddlePlace, kMiddlePlace);
}

/// Places from the edges of a closed polygon.
double Beside(const std::vector<Vec2>& corners_mm, const std::array<double, 2>& at) {
  double nearest = std::numeric_limits<double>::infinity();
  const Vec2 place(at[0], at[1]);
  for (std::size_t i = 0; i < corners_mm.size(); ++i) {
    const Vec2 from = PlaceOf(corners_mm[i]);
    const Vec2 way = PlaceOf(corners_mm[(i + 1) % corners_mm.size()]) - from;
    const double share =
        std::clamp((place - from).dot(way) / way.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (from + share * way - place).norm());
  }
  return nearest;
}

void ExpectDark(const bjjcz::VirtualBjjcz& board) {
  EXPECT_TRUE(board.flashes().empty());
  for (const bjjcz::Stroke& stroke : board.strokes()) {
    EXPECT_FALSE(stroke.is_mark);
    EXPECT_EQ(stroke.lit_us, 0);
    EXPECT_EQ(stroke.outputs & kGate, 0);
    EXPECT_EQ(
        stroke.current + stroke.q_switch_period + stroke.mark_period + stroke.power_ratio,
        0)
        << "power or frequency of the laser was set";
  }
}

/// How often each corner was the end of a stroke with the guide laser on; the others are
/// counted in the last.
std::vector<int> Visits(const bjjcz::VirtualBjjcz& board,
                        const std::vector<Vec2>& corners_mm) {
  std::vector<int> visits(corners_mm.size() + 1, 0);
  for (const bjjcz::Stroke& stroke : board.strokes()) {
    if ((stroke.outputs & kGuide) == 0) continue;
    const Vec2 to(stroke.to[0], stroke.to[1]);
    std::size_t at = 0;
    while (at < corners_mm.size() &&
           (PlaceOf(corners_mm[at]) - to).norm() > kRoundedPlaces)
      ++at;
    ++visits[at];
  }
  return visits;
}

TEST(BjjczOutline, WhatTheMirrorsDrewIsTheOutlineAndTheLaserDidNothing) {
  // At 2 m/s in less than a list, and slowly, in several lists an edge.
  for (const double speed_mm_s : {2000.0, 150.0}) {
    Board host;
    const std::vector<Vec2> corners = {
        {-20.1234, -11.4321}, {23.71, -14.007}, {17.3, 21.9}, {-3.33, 26.01}};
    ASSERT_TRUE(host.driver->DrawOutline(corners, speed_mm_s));
    host.StepFor(5000);
    ASSERT_TRUE(host.driver->Hold());
    host.StepFor(300);
    EXPECT_TRUE(host.driver->state().at_rest);
    EXPECT_EQ(host.board().outputs(), 0);
    ExpectDark(host.board());
    EXPECT_LE(host.longest_list_ms, 151);
    double beside = 0;
    for (const bjjcz::Stroke& stroke : host.board().strokes()) {
      if ((stroke.outputs & kGuide) == 0) continue;
      beside =
          std::max({beside, Beside(corners, stroke.from), Beside(corners, stroke.to)});
    }
    EXPECT_LE(beside, kRoundedPlaces);
    const std::vector<int> visits = Visits(host.board(), corners);
    // 160 mm of way, and what passes on the line between two lists.
    const int rounds = static_cast<int>(0.7 * 5 / (160 / speed_mm_s));
    for (std::size_t i = 0; i < corners.size(); ++i) EXPECT_GE(visits[i], rounds) << i;
    if (speed_mm_s > 1000) {
      EXPECT_EQ(visits.back(), 0) << "an edge is not one stroke";
    }
    EXPECT_EQ(host.board().unknown_count(), 0u);
  }
}

// The way from where the mirrors were is dark.
TEST(BjjczOutline, TheGuideLaserIsOnFromTheFirstCornerOn) {
  Board host;
  ASSERT_TRUE(
      host.driver->DrawOutline(std::vector<Vec2>{{30, 30}, {40, 30}, {40, 40}}, 500));
  while (host.board().strokes().size() < 3) host.Step();
  const auto& strokes = host.board().strokes();
  EXPECT_EQ(strokes[0].from, (std::array<double, 2>{kMiddlePlace, kMiddlePlace}));
  EXPECT_EQ(strokes[0].outputs & kGuide, 0);
  EXPECT_EQ(strokes[1].outputs & kGuide, kGuide);
}

TEST(BjjczOutline, OneCornerIsAPlaceThatIsShown) {
  Board host;
  ASSERT_TRUE(host.driver->DrawOutline(std::vector<Vec2>{{10, -5}}, 500));
  host.StepFor(1000);
  EXPECT_EQ(host.board().outputs(), kGuide);
  EXPECT_NEAR(host.board().place()[0], PlaceOf({10, -5}).x(), 0.5);
  EXPECT_LE(host.longest_list_ms, 151);
  ASSERT_TRUE(host.driver->Hold());
  host.StepFor(300);
  EXPECT_TRUE(host.driver->state().at_rest);
  ExpectDark(host.board());
}

// The synchronizer has its shutter open, and asks for it again and again.
TEST(BjjczOutline, ClosesTheGateAndKeepsItClosed) {
  Board host;
  LaserController& laser = *host.driver->laser();
  ASSERT_TRUE(laser.Reset() && laser.Lamp(true, 4000));
  host.StepFor(50);
  ASSERT_TRUE(laser.OpenShutters(1));
  host.StepFor(50);
  ASSERT_EQ(host.board().outputs() & kGate, kGate);
  ASSERT_TRUE(
      host.driver->DrawOutline(std::vector<Vec2>{{-20, -20}, {20, -20}, {20, 20}}, 1000));
  host.StepFor(20);
  for (int i = 0; i < 2000; ++i) {
    ASSERT_TRUE(laser.OpenShutters(1));
    host.Step();
    ASSERT_EQ(host.board().outputs() & kGate, 0) << i;
    ASSERT_EQ(laser.status().shutters_open, 0) << i;
  }
  EXPECT_TRUE(host.board().flashes().empty());
}

// A motion before has switched the oscillator on.
TEST(BjjczOutline, SwitchesTheOscillatorOfAFibreLaserOff) {
  MachineSpec profile = BjjczPointProfile();
  profile.mutable_bjjcz_board()->set_laser(BJJCZ_LASER_FIBRE);
  Board host(profile, true);
  ASSERT_TRUE(host.driver->Jog(host.driver->state().position_mm + Vec3(5, 0, 0), 20));
  host.StepFor(1000);
  ASSERT_TRUE(host.driver->state().at_rest);
  ASSERT_TRUE(host.board().oscillates());
  ASSERT_TRUE(
      host.driver->DrawOutline(std::vector<Vec2>{{0, 0}, {20, 0}, {20, 20}}, 1000));
  while ((host.board().outputs() & kGuide) == 0) host.Step();
  for (int i = 0; i < 1000; ++i) {
    host.Step();
    ASSERT_FALSE(host.board().oscillates());
  }
}

TEST(BjjczOutline, IsRefusedWithoutAGuideLaser) {
  MachineSpec profile = BjjczPointProfile();
  profile.mutable_bjjcz_board()->clear_guide_output();
  Board host(profile);
  const auto drawn = host.driver->DrawOutline(std::vector<Vec2>{{0, 0}}, 500);
  ASSERT_FALSE(drawn);
  EXPECT_EQ(drawn.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(drawn.error().message, HasSubstr("bjjcz_board.guide_output"));
}

// Planted: the output that is switched on for an outline is that of the gate.
TEST(BjjczOutline, AnOutlineThatRaisesTheGateIsFoundByTheSuite) {
  MachineSpec profile = BjjczPointProfile();
  profile.mutable_bjjcz_board()->set_guide_output(profile.bjjcz_board().gate_output());
  const MotionRigMaker make = [&](const std::string&) {
    return MakeBjjczMotionRigOf(profile);
  };
  const auto checks = MotionChecks();
  const auto outline = std::ranges::find(checks, "M19_outline", &MotionCheck::name);
  ASSERT_NE(outline, checks.end());
  EXPECT_THAT(ViolationOf(*outline, make), HasSubstr("the gate of the laser is open"));
}

}  // namespace
}  // namespace intaglio::drivers
