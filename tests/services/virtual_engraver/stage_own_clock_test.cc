// The stage on an oscillator of its own: where it is at the lamp's ticks, when its
// in-position output is on, and what it reports about the ticks it is notified of.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/services/virtual_engraver/stage_path.h"

namespace intaglio::virtual_engraver {
namespace {

using link::StageFault;

constexpr double kTickNs = 1e9 / kRateHz;

StageOptions OnItsOwn(double drift_ppm, double jitter_s = 0) {
  StageOptions options = Roomy(0);
  options.own_clock = OwnClockOptions{drift_ppm, jitter_s, 7, 1};
  return options;
}

/// Knots every tick on a straight line along x, at `speed_mm_s` from the first one on.
/// Marked for a pulse all of them.
struct Line {
  std::uint64_t start_ns = 0;
  double tick_ns = kTickNs;  ///< by the controller's clock
  double speed_mm_s = 10;
  int knots = 20;

  link::TimedSegments Frame() const {
    link::TimedSegments frame{1, 0, {}};
    for (int i = 1; i <= knots; ++i) {
      link::WireTimedSegment segment;
      segment.x_nm = static_cast<std::int32_t>(std::lround(1e6 * AtMm(EndNs(i))));
      segment.vx_counts = static_cast<std::int32_t>(std::lround(1e6 * speed_mm_s));
      segment.end_ns = EndNs(i);
      segment.pulse = true;
      frame.segments.push_back(segment);
    }
    return frame;
  }
  std::uint64_t EndNs(int knot) const {
    return start_ns + static_cast<std::uint64_t>(std::llround(knot * tick_ns));
  }
  /// From the first knot on; before it the stage gathers speed.
  double AtMm(std::uint64_t ns) const {
    return 1e-9 * speed_mm_s * static_cast<double>(ns - start_ns);
  }
};

TEST(StageOnItsOwnClock, IsWhereItsOwnTimeReportsAtEachTickOfTheLamp) {
  for (const double drift_ppm : {-200.0, 0.5, 150.0}) {
    Stage stage(OnItsOwn(drift_ppm));
    const std::uint64_t powered_ns = stage.own_clock()->now_ns();
    Line line{powered_ns + 35000000};
    stage.BeginTimedRun({1, line.start_ns});
    stage.AppendTimed(line.Frame());
    for (int tick = 1; tick < 20; ++tick) {
      stage.AdvanceTick(kRateHz);
      const double own_ns =
          static_cast<double>(powered_ns) + tick * kTickNs * (1 + 1e-6 * drift_ppm);
      if (own_ns < static_cast<double>(line.EndNs(1))) continue;
      const double expected_mm =
          1e-9 * line.speed_mm_s * (own_ns - static_cast<double>(line.start_ns));
      // A ns of time is 10 fm; positions on the line are whole nm.
      EXPECT_NEAR(stage.actual_mm().x(), expected_mm, 2e-6) << drift_ppm << " " << tick;
    }
    EXPECT_EQ(stage.Report().fault, StageFault::kNone);
  }
}

TEST(StageOnItsOwnClock, IsInPositionOnlyAroundAKnotsTimeAndPlace) {
  struct Case {
    double speed_mm_s, off_us;
    bool on;
  };
  // 0.35 ms around the time, 10 um around the place; and a whole tick off is the place of
  // another point.
  for (const Case& c : {Case{10, 0, true}, Case{10, 300, true}, Case{10, -300, true},
                        Case{10, 400, false}, Case{10, -400, false}, Case{80, 100, true},
                        Case{80, -100, true}, Case{80, 150, false}, Case{80, -150, false},
                        Case{80, 2500, false}, Case{80, 5000, false}}) {
    Stage stage(OnItsOwn(1e-9));
    Line line{
        stage.own_clock()->now_ns() + 30000000 +
        static_cast<std::uint64_t>(std::lround(1000 * (c.off_us + 1000)) - 1000000)};
    line.speed_mm_s = c.speed_mm_s;
    stage.BeginTimedRun({1, line.start_ns});
    stage.AppendTimed(line.Frame());
    for (int tick = 1; tick < 20; ++tick) {
      stage.AdvanceTick(kRateHz);
      if (tick < 5) continue;
      EXPECT_EQ(stage.in_position(), c.on) << c.speed_mm_s << " " << c.off_us;
    }
  }
}

TEST(StageOnItsOwnClock, StampsEachTickLateAndInOrderWithThePlaceOfThatTime) {
  constexpr double kJitterS = 0.002;
  Stage stage(OnItsOwn(100, kJitterS));
  const std::uint64_t powered_ns = stage.own_clock()->now_ns();
  Line line{powered_ns + 25000000};
  line.knots = 30;
  stage.BeginTimedRun({1, line.start_ns});
  stage.AppendTimed(line.Frame());
  for (int tick = 1; tick < 28; ++tick) stage.AdvanceTick(kRateHz);
  std::uint64_t next = 1, last_ns = 0;
  double latest_us = 0;
  for (const link::TimedPositions& frame : stage.TakeTimedPositions()) {
    EXPECT_EQ(frame.first_tick, next);
    for (const auto& p : frame.positions) {
      const double tick_ns = static_cast<double>(powered_ns) +
                             static_cast<double>(next) * kTickNs * (1 + 100e-6);
      const double late_us = 1e-3 * (static_cast<double>(p.at_ns) - tick_ns);
      EXPECT_GE(late_us, -0.002);
      EXPECT_LE(late_us, 1e6 * kJitterS);
      latest_us = std::max(latest_us, late_us);
      EXPECT_GE(p.at_ns, last_ns);
      last_ns = p.at_ns;
      if (p.at_ns >= line.EndNs(1)) {
        EXPECT_NEAR(p.x_nm, 1e6 * line.AtMm(p.at_ns), 2);
      }
      ++next;
    }
  }
  EXPECT_GE(next, 27u);
  EXPECT_GT(latest_us, 1000) << "there is jitter";
}

TEST(StageOnItsOwnClock, ReportsTheTickItReceivedAndLeavesCoverageToTheHost) {
  Stage stage(OnItsOwn(0.1));
  for (int tick = 0; tick < 5; ++tick) stage.AdvanceTick(kRateHz);
  EXPECT_EQ(stage.Report().tick, 5u);
  EXPECT_EQ(stage.Report().covered_through_tick, 0u);
}

TEST(StageOnItsOwnClock, RefusesWhatIsMeantForTheOtherClock) {
  Stage own(OnItsOwn(100));
  own.BeginRun({1, 1000});
  EXPECT_EQ(own.Report().fault, StageFault::kRunRefused);
  Stage slaved(Roomy(0));
  slaved.BeginTimedRun({1, 1000});
  EXPECT_EQ(slaved.Report().fault, StageFault::kRunRefused);
}

TEST(StageOnItsOwnClock, RefusesAStartThatHasPassedAndTimesThatGoBack) {
  Stage late(OnItsOwn(100));
  late.BeginTimedRun({1, late.own_clock()->now_ns()});
  EXPECT_EQ(late.Report().fault, StageFault::kLate);
  Stage back(OnItsOwn(100));
  const Line line{back.own_clock()->now_ns() + 1000000};
  back.BeginTimedRun({1, line.start_ns});
  link::TimedSegments frame = line.Frame();
  frame.segments[0].end_ns = line.start_ns;
  back.AppendTimed(frame);
  EXPECT_EQ(back.Report().fault, StageFault::kBadSequence);
}

TEST(StageOnItsOwnClock, StarvesAndBrakesInItsOwnTime) {
  Stage stage(OnItsOwn(-200));
  Line line{stage.own_clock()->now_ns() + 1000000};
  stage.BeginTimedRun({1, line.start_ns});
  stage.AppendTimed(line.Frame());
  const auto ticks = TicksToRest(stage);
  ASSERT_TRUE(ticks.has_value());
  EXPECT_EQ(stage.Report().fault, StageFault::kStarved);
  // 10 mm/s brake within 7 um.
  EXPECT_NEAR(stage.actual_mm().x(), line.AtMm(line.EndNs(20)) + 0.00714, 1e-4);
}

TEST(StageOnItsOwnClock, InLockstepWaitsForMotionByItsOwnTime) {
  Stage stage(OnItsOwn(200));
  Line line{stage.own_clock()->now_ns() + 15000000};
  line.knots = 3;
  stage.BeginTimedRun({1, line.start_ns});
  EXPECT_TRUE(stage.MayPass(kRateHz));
  stage.AdvanceTick(kRateHz);
  EXPECT_FALSE(stage.MayPass(kRateHz));
  stage.AppendTimed(line.Frame());
  int passed = 0;
  for (; stage.MayPass(kRateHz) && passed < 10; ++passed) stage.AdvanceTick(kRateHz);
  // 5 ms to the start, three ticks of motion.
  EXPECT_EQ(passed, 3);
}

}  // namespace
}  // namespace intaglio::virtual_engraver
