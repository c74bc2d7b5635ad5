// A stage that finds its place by switches, on axes whose real place only the test knows.

#include "services/virtual_engraver/home_course.h"

#include <gtest/gtest.h>

#include <cmath>

#include "services/virtual_engraver/stage.h"

namespace intaglio::virtual_engraver {
namespace {

using link::StageFault;

constexpr std::uint64_t kTurnNs = 100'000;

/// Exact axes that count from anywhere. The switch of each is pressed at or below
/// `switch_mm` of the real place.
class CountingAxes final : public StageAxes {
 public:
  explicit CountingAxes(const Vec3& at_mm) : really_mm(at_mm) {}

  void Follow(const CubicCommand& command, double, double to_s) override {
    const Vec3 to_mm = command.At(to_s);
    for (int axis = 0; axis < 3; ++axis)
      if (axis != blocked) really_mm[axis] += to_mm[axis] - counted_mm_[axis];
    counted_mm_ = to_mm;
    farthest_mm = farthest_mm.cwiseMin(really_mm);
  }
  const Vec3& actual_mm() const override { return counted_mm_; }
  bool IsAtSwitch(int axis) const override {
    return axis == stuck || (axis != missing && really_mm[axis] <= switch_mm);
  }
  void ShiftPlace(int axis, double by_mm) override { counted_mm_[axis] += by_mm; }

  double switch_mm = -2;
  Vec3 really_mm;
  Vec3 farthest_mm = Vec3::Constant(1e9);
  int missing = -1, stuck = -1, blocked = -1;

 private:
  Vec3 counted_mm_ = Vec3::Zero();
};

class Homing : public ::testing::Test {
 protected:
  explicit Homing(const Vec3& really_mm = Vec3(30, 60, 10)) { Make(really_mm); }

  void Make(const Vec3& really_mm) {
    StageOptions options;
    options.travel_max_mm = Vec3::Constant(100);
    options.max_speed_mm_s = Vec3::Constant(50);
    options.own_clock = OwnClockOptions{};
    options.homing.emplace();
    for (HomingOptions::Axis& axis : options.homing->axes) axis = {false, -2, 107};
    options.homing->speed_mm_s = 50;
    options.homing->acceleration_mm_s2 = 700;
    auto axes_of_stage = std::make_unique<CountingAxes>(really_mm);
    axes = axes_of_stage.get();
    stage.emplace(options, std::move(axes_of_stage));
    now_ns = stage->own_clock()->now_ns();
  }
  bool KnowsPlace() { return !stage->Report().place_lost; }
  void Turn() { stage->AdvanceClock(now_ns += kTurnNs); }
  void TurnUntilRest() {
    for (int i = 0; i < 400'000 && stage->running(); ++i) Turn();
    ASSERT_FALSE(stage->running());
  }
  void Home() {
    stage->Home();
    TurnUntilRest();
  }
  /// 10 mm along x within a second, from where it is.
  void BeginARun() {
    stage->BeginTimedRun({5, now_ns + 1'000'000});
    const auto x_nm =
        static_cast<std::int32_t>(std::lround(1e6 * stage->actual_mm().x()));
    stage->AppendTimed(
        {5,
         0,
         {{x_nm + 10'000'000, 0, 0, 0, 0, 0, now_ns + 1'001'000'000, false, true}}});
  }

  std::optional<Stage> stage;
  CountingAxes* axes = nullptr;
  std::uint64_t now_ns = 0;
};

TEST_F(Homing, FindsThePlaceFromAnywhereAndRestsAtHome) {
  for (const Vec3& from_mm :
       {Vec3(30, 60, 10), Vec3(100, 0, -1.99), Vec3(-2.5, -4, 99)}) {
    Make(from_mm);
    EXPECT_FALSE(KnowsPlace());
    Home();
    EXPECT_EQ(stage->fault(), StageFault::kNone);
    EXPECT_TRUE(KnowsPlace());
    // A turn at the speed of the touch, 1 mm/s, and one at which the command ends.
    EXPECT_LT((axes->really_mm - axes->actual_mm()).norm(), 3e-4);
    EXPECT_LT(axes->really_mm.norm(), 3e-4) << "home is at zero";
    // From 50 mm/s it brakes within 1.8 mm.
    EXPECT_GT(axes->farthest_mm.minCoeff(), -4.1);
  }
}

TEST_F(Homing, NothingElseMovesBefore) {
  stage->Jog({1'000'000, 0, 0, 1'000'000});
  EXPECT_FALSE(stage->running());
  EXPECT_EQ(stage->Report().jogs_taken, 1u);
  BeginARun();
  EXPECT_EQ(stage->fault(), StageFault::kPlaceLost);
  EXPECT_EQ(stage->Report().run, 5u);
  for (int i = 0; i < 20'000; ++i) Turn();
  EXPECT_EQ(axes->really_mm, Vec3(30, 60, 10));
  stage->Reset();
  EXPECT_FALSE(KnowsPlace());
  Home();
  BeginARun();
  TurnUntilRest();
  EXPECT_EQ(stage->fault(), StageFault::kNone);
  EXPECT_NEAR(axes->really_mm.x(), 10, 3e-4);
}

TEST_F(Homing, ASwitchThatIsNotMetIsAFaultWithItsAxis) {
  axes->missing = 1;
  Home();
  EXPECT_EQ(stage->fault(), StageFault::kNoSwitch);
  EXPECT_EQ(stage->Report().fault_axes, (std::array{false, true, false}));
  EXPECT_FALSE(KnowsPlace());
  EXPECT_NEAR(axes->really_mm.y(), 60 - 107, 1e-6) << "no farther than it is sought";
  // From 1 mm/s it brakes within 0.0007 mm.
  EXPECT_NEAR(axes->really_mm.x(), -2, 1e-3) << "the axes before are at their switches";
}

TEST_F(Homing, ASwitchThatStaysPressedIsAFaultWithItsAxis) {
  axes->stuck = 2;
  Home();
  EXPECT_EQ(stage->fault(), StageFault::kSwitchStuck);
  EXPECT_EQ(stage->Report().fault_axes, (std::array{false, false, true}));
  EXPECT_NEAR(axes->really_mm.z(), 10 + 5, 1e-6) << "it backs off, and no more";
  EXPECT_EQ(axes->really_mm.x(), 30) << "no other axis moves behind it";
}

TEST_F(Homing, AnAbortBrakesItAndThePlaceStaysUnknown) {
  stage->Home();
  for (int i = 0; i < 2000; ++i) Turn();
  ASSERT_TRUE(stage->running());
  stage->Abort();
  TurnUntilRest();
  EXPECT_EQ(stage->fault(), StageFault::kNone);
  EXPECT_FALSE(KnowsPlace());
  Home();
  EXPECT_TRUE(KnowsPlace());
}

TEST_F(Homing, DrivesThatAreCutRestAtOnceAndLoseThePlace) {
  for (const StageFault cause : {StageFault::kStopPressed, StageFault::kDriveFault}) {
    Make(Vec3(30, 60, 10));
    Home();
    BeginARun();
    for (int i = 0; i < 5000; ++i) Turn();
    ASSERT_TRUE(stage->running());
    stage->SetDrives(cause);
    EXPECT_FALSE(stage->running());
    const Vec3 rests_mm = axes->really_mm;
    stage->Reset();
    EXPECT_EQ(stage->fault(), cause) << "its cause is there";
    stage->SetDrives(StageFault::kNone);
    EXPECT_EQ(stage->fault(), cause);
    stage->Reset();
    EXPECT_EQ(stage->fault(), StageFault::kNone);
    for (int i = 0; i < 20'000; ++i) Turn();
    EXPECT_EQ(axes->really_mm, rests_mm);
    BeginARun();
    EXPECT_EQ(stage->fault(), StageFault::kPlaceLost);
  }
}

TEST_F(Homing, ASwitchWithinTheTravelShowsLostSteps) {
  Home();
  stage->Jog({20'000'000, 0, 0, 50'000'000});
  TurnUntilRest();
  axes->blocked = 0;  // the motor has no hold of it, and it is at the switch
  axes->really_mm.x() = -2;
  Turn();
  EXPECT_EQ(stage->fault(), StageFault::kSwitchMet);
  EXPECT_EQ(stage->Report().fault_axes, (std::array{true, false, false}));
  EXPECT_FALSE(KnowsPlace());
}

TEST_F(Homing, WhatIsFasterThanTheAxesAllowIsNotTaken) {
  Home();
  stage->BeginTimedRun({6, now_ns + 1'000'000});
  stage->AppendTimed(
      {6, 0, {{1'000'000, 0, 0, 0, 50'000'001, 0, now_ns + 101'000'000, false, false}}});
  EXPECT_EQ(stage->fault(), StageFault::kTooFast);
  EXPECT_EQ(stage->Report().fault_axes, (std::array{false, true, false}));
  stage->Reset();
  stage->Jog({50'000'000, 10'000'000, 0, 4'000'000'000});
  double fastest_mm_s = 0;
  for (Vec3 before = axes->really_mm; stage->running(); before = axes->really_mm) {
    Turn();
    const Vec3 way_mm = axes->really_mm - before;
    fastest_mm_s =
        std::max(fastest_mm_s, way_mm.cwiseAbs().maxCoeff() / (1e-9 * kTurnNs));
  }
  EXPECT_NEAR(fastest_mm_s, 50, 1e-3);
}

}  // namespace
}  // namespace intaglio::virtual_engraver
