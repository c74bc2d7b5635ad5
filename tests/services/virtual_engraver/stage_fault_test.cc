// How the stage stops: limits, starvation, stuck axes, aborts, wrong commands.

#include <gtest/gtest.h>

#include "tests/services/virtual_engraver/stage_path.h"

namespace intaglio::virtual_engraver {
namespace {

using link::StageFault;

TEST(StageStops, TargetOutsideTheTravelStopsIt) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double limit_um : {-50000.0, 50000.0}) {
      Vec3 inside = Vec3::Zero(), outside = Vec3::Zero();
      inside[axis] = limit_um;
      outside[axis] = limit_um * (1 + 1e-6);
      Stage good(Roomy(0)), bad(Roomy(0));
      Begin(good, {{inside, Vec3::Zero(), 1000 * kTick, false, true}});
      Begin(bad, {{outside, Vec3::Zero(), 1000 * kTick, false, true}});
      EXPECT_EQ(good.Report().fault, StageFault::kNone);
      EXPECT_EQ(bad.Report().fault, StageFault::kLimit) << axis << " " << limit_um;
      EXPECT_FALSE(bad.running());
    }
  }
}

TEST(StageStops, LimitInMidRunBrakesWithinTheBrakingDistance) {
  Stage stage(Roomy(0));
  std::vector<Knot> line;
  for (int i = 1; i <= 20; ++i) line.push_back({{i * 500.0, 0, 0}, {50000, 0, 0}, kTick});
  Begin(stage, line);
  for (std::uint64_t tick = 0; tick < kStartTick + 5; ++tick) stage.AdvanceTick(kRateHz);
  const double before_mm = stage.actual_mm().x();
  stage.Append(Frame({{{60000, 0, 0}, {50000, 0, 0}, kTick}}, line.size()));
  EXPECT_EQ(stage.Report().fault, StageFault::kLimit);
  ASSERT_TRUE(TicksToRest(stage).has_value());
  // v^2 / 2a = 50^2 / 14000 mm; the end of the braking is rounded to a nm.
  EXPECT_NEAR(stage.actual_mm().x() - before_mm, 2500.0 / 14000, 1e-6);
  EXPECT_EQ(stage.Report().vx_counts, 0);
}

TEST(StageStops, StarvedItBrakesToRest) {
  for (const std::uint32_t rest : {0u, kTick / 3}) {  // ends on a tick and between two
    Stage stage(Roomy(0));
    const double end_mm = 1 + 0.5 * rest / kTick;
    Begin(stage, {{{500, 0, 0}, {50000, 0, 0}, kTick},
                  {{1000, 0, 0}, {50000, 0, 0}, kTick},
                  {{end_mm * 1000, 0, 0}, {50000, 0, 0}, kTick / 1000 + rest}});
    const auto ticks = TicksToRest(stage);
    ASSERT_TRUE(ticks.has_value());
    // Braking from 50 mm/s takes 7.1 ms: within the tick after the last segment, the
    // motion has no pause.
    EXPECT_LE(*ticks, static_cast<int>(kStartTick) + 4);
    EXPECT_NEAR(stage.actual_mm().x(), end_mm + 2500.0 / 14000, 2e-6);
    EXPECT_EQ(stage.Report().fault, StageFault::kStarved);
    EXPECT_TRUE(stage.Report().at_rest);
  }
}

TEST(StageStops, StarvingKeepsTheLagGoing) {
  // Between the last segment and the braking the drive lags on without a jump: the
  // largest step of a tick is what the speed allows.
  Stage stage(Roomy(0.005));
  Begin(stage,
        {{{500, 0, 0}, {50000, 0, 0}, kTick}, {{1000, 0, 0}, {50000, 0, 0}, kTick}});
  Vec3 before = stage.actual_mm();
  for (int tick = 0; tick < 30; ++tick) {
    stage.AdvanceTick(kRateHz);
    EXPECT_GE(stage.actual_mm().x(), before.x()) << tick;
    EXPECT_LT(stage.actual_mm().x() - before.x(), 0.75) << tick;
    // Before the start nothing moves, at the end the lag has faded.
    if (tick > static_cast<int>(kStartTick) && tick < 12) {
      EXPECT_GT(stage.actual_mm().x(), before.x()) << tick;
    }
    before = stage.actual_mm();
  }
}

TEST(StageStops, InLockstepATickWaitsForItsMotion) {
  Stage stage(Roomy(0));
  EXPECT_TRUE(stage.MayPass(kRateHz));
  stage.BeginRun({1, kStartTick});
  for (std::uint64_t tick = 0; tick < kStartTick; ++tick) {
    EXPECT_TRUE(stage.MayPass(kRateHz));
    stage.AdvanceTick(kRateHz);
  }
  EXPECT_FALSE(stage.MayPass(kRateHz));
  stage.Append(Frame({{{10, 0, 0}, {1000, 0, 0}, kTick / 2}}));
  EXPECT_FALSE(stage.MayPass(kRateHz));
  stage.Append(Frame({{{20, 0, 0}, {1000, 0, 0}, kTick / 2}}, 1));
  EXPECT_TRUE(stage.MayPass(kRateHz));
  stage.AdvanceTick(kRateHz);
  EXPECT_FALSE(stage.MayPass(kRateHz));
  stage.Append(Frame({{{25, 0, 0}, {0, 0, 0}, kTick / 2, false, true}}, 2));
  EXPECT_TRUE(stage.MayPass(kRateHz));
  stage.AdvanceTick(kRateHz);
  EXPECT_EQ(stage.Report().fault, StageFault::kNone);
  EXPECT_TRUE(stage.MayPass(kRateHz));
}

TEST(StageStops, StuckItStopsWithAFaultThatStaysWithItsCause) {
  Stage stage(Roomy(0.0002));
  stage.Stick(1);
  Begin(stage, {{{0, 9000, 0}, {0, 30000, 0}, 50 * kTick},
                {{0, 30000, 0}, {0, 0, 0}, 100 * kTick, false, true}});
  ASSERT_TRUE(TicksToRest(stage).has_value());
  EXPECT_EQ(stage.Report().fault, StageFault::kFollowingError);
  EXPECT_EQ(stage.actual_mm().y(), 0);
  // Its own brakes stopped it, long before the end of what was commanded.
  EXPECT_LT(stage.Report().tick, 60u);

  stage.Reset();
  stage.AdvanceTick(kRateHz);
  EXPECT_EQ(stage.Report().fault, StageFault::kFollowingError);
  stage.Unstick();
  for (int i = 0; i < 3; ++i) stage.AdvanceTick(kRateHz);
  EXPECT_EQ(stage.Report().fault, StageFault::kFollowingError) << "latched until reset";
  stage.Reset();
  stage.AdvanceTick(kRateHz);
  EXPECT_EQ(stage.Report().fault, StageFault::kNone);
}

TEST(StageStops, StuckAxisLeavesTheOthersAlone) {
  Stage stage(Roomy(0));
  stage.Stick(2);
  Begin(stage, {{{500, 500, 500}, {0, 0, 0}, 10 * kTick, false, true}});
  ASSERT_TRUE(TicksToRest(stage).has_value());
  EXPECT_LT((stage.actual_mm() - Vec3(0.5, 0.5, 0)).norm(), 1e-12);
  stage.Stick(-1);
  stage.BeginRun({2, 100});
  stage.Append(Frame({{{700, 700, 700}, {0, 0, 0}, kTick, false, true}}, 0, 2));
  while (stage.Report().tick < 110) stage.AdvanceTick(kRateHz);
  EXPECT_LT((stage.actual_mm() - Vec3(0.5, 0.5, 0)).norm(), 1e-12);
}

TEST(StageStops, AbortBrakesWithoutAFault) {
  Stage stage(Roomy(0.0002));
  Begin(stage, kPath);
  for (int i = 0; i < 7; ++i) stage.AdvanceTick(kRateHz);
  stage.Abort();
  EXPECT_TRUE(stage.running());
  ASSERT_TRUE(TicksToRest(stage).has_value());
  const Vec3 at_rest = stage.actual_mm();
  for (int i = 0; i < 5; ++i) stage.AdvanceTick(kRateHz);
  EXPECT_LT((stage.actual_mm() - at_rest).norm(), 0.01);
  EXPECT_EQ(stage.Report().fault, StageFault::kNone);
}

TEST(StageStops, RefusesRunsThatCannotBe) {
  Stage late(Roomy(0));
  late.AdvanceTick(kRateHz);
  late.BeginRun({1, 1});
  EXPECT_EQ(late.Report().fault, StageFault::kLate);
  EXPECT_FALSE(late.running());
  late.BeginRun({2, 10});
  EXPECT_EQ(late.Report().fault, StageFault::kLate) << "a fault stays until reset";
  late.Reset();
  late.BeginRun({3, 10});
  EXPECT_EQ(late.Report().fault, StageFault::kNone);
  EXPECT_TRUE(late.running());
  late.BeginRun({4, 20});
  EXPECT_EQ(late.Report().fault, StageFault::kRunRefused) << "a run is going on";
  EXPECT_EQ(late.Report().run, 3u);
}

TEST(StageStops, GapsAndOverfullQueuesAreFaults) {
  StageOptions options = Roomy(0);
  options.queue_capacity = 4;
  const Knot knot = {{10, 0, 0}, {0, 0, 0}, kTick};
  Stage gap(options), full(options), other_run(options);
  Begin(gap, {knot});
  gap.Append(Frame({knot}, 2));
  EXPECT_EQ(gap.Report().fault, StageFault::kBadSequence);
  Begin(full, {knot, knot, knot, knot});
  EXPECT_EQ(full.Report().queue_free, 0u);
  EXPECT_EQ(full.Report().fault, StageFault::kNone);
  full.Append(Frame({knot}, 4));
  EXPECT_EQ(full.Report().fault, StageFault::kBadSequence);
  Begin(other_run, {knot});
  other_run.Append(Frame({knot}, 1, 7));
  EXPECT_EQ(other_run.Report().fault, StageFault::kNone);
  EXPECT_EQ(other_run.Report().segments_taken, 1u);
}

}  // namespace
}  // namespace intaglio::virtual_engraver
