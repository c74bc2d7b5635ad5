#include "services/synchronizer/engraving/motion_feed.h"

#include <gmock/gmock.h>

#include "tests/services/synchronizer/motion_feed_bench.h"

namespace intaglio::synchronizer {
namespace {

// A controller with a clock of its own that is `drift_ppm` fast and was at 5 s at tick 0.
std::uint64_t OwnNs(double tick, double drift_ppm) {
  return 5000000000u +
         static_cast<std::uint64_t>(std::llround(tick * 1e7 * (1 + 1e-6 * drift_ppm)));
}

TEST_F(MotionFeedTest, GivesNoTimesToAControllerThatRunsOnTheLampsTicks) {
  Advance(kStart + 50);
  ASSERT_FALSE(sent_.empty());
  EXPECT_EQ(sent_[0].start_controller_ns, 0u);
  EXPECT_TRUE(sent_[0].controller_ns.empty());
}

TEST_F(MotionFeedTest, GivesEachKnotItsTickByTheControllersOwnClock) {
  MotionClock clock;
  clock.Reset(100);
  for (std::uint64_t tick = 1; tick < 500; ++tick) {
    clock.Observe(tick, OwnNs(static_cast<double>(tick), 150));
  }
  Begin(&clock);
  for (std::uint64_t horizon = kStart; !feed_.sent_all(); horizon += 40) Advance(horizon);
  std::uint64_t subticks = 0;
  for (const SentBatch& batch : sent_) {
    EXPECT_EQ(batch.start_controller_ns, OwnNs(kStart, 150));
    ASSERT_EQ(batch.controller_ns.size(), batch.segments.size());
    for (std::size_t i = 0; i < batch.segments.size(); ++i) {
      subticks += batch.segments[i].duration_subticks;
      const double tick = kStart + static_cast<double>(subticks) / kSubticks;
      // Stamps are whole ns, and the line through them is used a thousand ticks ahead.
      EXPECT_NEAR(static_cast<double>(batch.controller_ns[i]),
                  static_cast<double>(OwnNs(tick, 150)), 10);
    }
  }
}

TEST_F(MotionFeedTest, MakesUpForWhatWasWrongWithoutAJerk) {
  MotionClock clock;
  clock.Reset(100);
  // What is known at first is 300 us late, and 100 us more each second.
  std::uint64_t tick = 1;
  for (; tick < 500; ++tick) {
    clock.Observe(tick, 300000 + OwnNs(static_cast<double>(tick), 100));
  }
  Begin(&clock);
  Advance(kStart + 50);
  const std::size_t sent_wrong = sent_.size();
  ASSERT_GT(sent_wrong, 0u);
  clock.Reset(100);
  for (; tick < 900; ++tick) clock.Observe(tick, OwnNs(static_cast<double>(tick), 0));
  while (!feed_.sent_all()) Advance(kNever);
  std::uint64_t subticks = 0, before_ns = sent_[0].start_controller_ns;
  double last_error_us = 0;
  for (const SentBatch& batch : sent_) {
    for (std::size_t i = 0; i < batch.segments.size(); ++i) {
      const std::uint32_t duration = batch.segments[i].duration_subticks;
      subticks += duration;
      const double nominal_ns = 1e7 * duration / kSubticks;
      const double took_ns = static_cast<double>(batch.controller_ns[i] - before_ns);
      EXPECT_NEAR(took_ns / nominal_ns, 1, 0.0022);
      before_ns = batch.controller_ns[i];
      last_error_us =
          1e-3 * (static_cast<double>(before_ns) -
                  static_cast<double>(
                      OwnNs(kStart + static_cast<double>(subticks) / kSubticks, 0)));
    }
  }
  EXPECT_NEAR(last_error_us, 0, 0.1);
}

TEST_F(MotionFeedTest, TimesABatchAgainThatTheBusDidNotTake) {
  MotionClock clock;
  clock.Reset(100);
  for (std::uint64_t tick = 1; tick < 500; ++tick) {
    clock.Observe(tick, OwnNs(static_cast<double>(tick), -80));
  }
  Begin(&clock);
  refuse_ = true;
  Advance(kStart + 30);
  refuse_ = false;
  Advance(kStart + 30);
  ASSERT_FALSE(sent_.empty());
  const double tick =
      kStart + static_cast<double>(sent_[0].segments[0].duration_subticks) / kSubticks;
  EXPECT_NEAR(static_cast<double>(sent_[0].controller_ns[0]),
              static_cast<double>(OwnNs(tick, -80)), 10);
}

TEST_F(MotionFeedTest, SendsTheWholeRunAndSchedulesEveryPulseAtItsSegmentsEnd) {
  while (!feed_.sent_all()) Advance(kNever);
  const auto segments = Segments();
  EXPECT_TRUE(sent_.back().last);
  EXPECT_EQ(segments.back().velocity_mm_s, Vec3(Vec3::Zero()));
  // Where the stage is at the end of each pulse segment, by summing up what was sent.
  std::map<std::uint64_t, Vec3> pulse_at;
  std::uint64_t subticks = 0;
  for (const SentSegment& segment : segments) {
    subticks += segment.duration_subticks;
    if (!segment.pulse) continue;
    EXPECT_EQ(subticks % kSubticks, 0);
    pulse_at[kStart + subticks / kSubticks] = segment.end_mm;
  }
  ASSERT_EQ(pulse_at.size(), points_mm_.size());
  std::size_t armed = 0;
  for (auto at = pulse_at.begin(); at != pulse_at.end(); ++at) {
    schedule_.Decide(
        at->first, at->first,
        [&](std::uint64_t tick, std::uint32_t point) {
          ++armed;
          EXPECT_LT((pulse_at.at(tick) - points_mm_[point]).norm(), 1e-9);
        },
        [](std::uint32_t point) { ADD_FAILURE() << "point " << point << " is late"; });
  }
  EXPECT_EQ(armed, points_mm_.size());
}

TEST_F(MotionFeedTest, StaysAheadOfTheTicksAndNoFarther) {
  // A step of 0.1 to 0.5 mm at 100 Hz takes a few ticks.
  constexpr std::uint64_t kLongestStepTicks = 20;
  for (std::uint64_t horizon = kStart + 40; !feed_.sent_all(); horizon += 7) {
    Advance(horizon);
    ASSERT_LT(horizon, kStart + 100000);
    if (feed_.sent_all()) break;
    EXPECT_GE(CoveredThrough(), horizon);
    EXPECT_LT(CoveredThrough(), horizon + kLongestStepTicks);
  }
  for (std::size_t i = 0; i < sent_.size(); ++i) {
    EXPECT_EQ(sent_[i].number, i);
    EXPECT_EQ(sent_[i].run, 7);
    EXPECT_EQ(sent_[i].start_tick, kStart);
    EXPECT_EQ(sent_[i].last, i + 1 == sent_.size());
  }
}

TEST_F(MotionFeedTest, SendsNoBatchBeyondItsCreditAndLosesNothingByWaiting) {
  while (!feed_.sent_all()) Advance(kNever);
  const auto freely = Segments();
  sent_.clear();
  schedule_ = {};
  next_ = 0;
  Begin();
  grant_ = {};  // the bridge has not seen the run yet
  for (int i = 0; i < 20; ++i) Advance(kNever);
  ASSERT_EQ(sent_.size(), 1);
  EXPECT_EQ(asked_for_, "job/7/MotionSegmentBatch");
  grant_.open = true;
  for (std::uint64_t limit = 1; !feed_.sent_all() && limit < 100; ++limit) {
    grant_.limit = limit;
    for (int i = 0; i < 5; ++i) Advance(kNever);
    EXPECT_LE(sent_.size(), limit);
  }
  EXPECT_TRUE(feed_.sent_all());
  EXPECT_EQ(Segments(), freely);
}

// So that a turn of the loop does not last as long as there is to be planned.
TEST_F(MotionFeedTest, PlansABoundedPartACall) {
  Advance(kNever);
  EXPECT_GT(next_, 0);
  EXPECT_LT(next_, points_mm_.size() - 1);
  while (!feed_.sent_all()) {
    const std::size_t before = next_;
    Advance(kNever);
    EXPECT_LE(next_ - before, 256);
  }
  EXPECT_EQ(next_, points_mm_.size());
}

TEST_F(MotionFeedTest, RepeatsABatchThatWasNotTaken) {
  while (!feed_.sent_all()) Advance(kNever);
  const auto freely = Segments();
  sent_.clear();
  schedule_ = {};
  next_ = 0;
  Begin();
  for (int i = 0; i < 1000 && !feed_.sent_all(); ++i) {
    refuse_ = i % 3 != 0;
    Advance(kNever);
  }
  EXPECT_EQ(Segments(), freely);
  for (std::size_t i = 0; i < sent_.size(); ++i) EXPECT_EQ(sent_[i].number, i);
}

TEST_F(MotionFeedTest, KnowsThatTheBridgeDroppedTheRun) {
  Advance(kStart + 50);
  EXPECT_FALSE(feed_.dropped());
  grant_.cancelled = true;
  EXPECT_TRUE(feed_.dropped());
  const std::size_t sent = sent_.size();
  Advance(kNever);
  EXPECT_EQ(sent_.size(), sent);
  // The next run is another matter.
  Begin();
  EXPECT_FALSE(feed_.dropped());
}

TEST_F(MotionFeedTest, ARunAtItsEndIsNotDropped) {
  while (!feed_.sent_all()) Advance(kNever);
  grant_.cancelled = true;  // as the bridge does when it has all
  EXPECT_FALSE(feed_.dropped());
}

TEST_F(MotionFeedTest, AbortsWithOneLastMessage) {
  Advance(kStart + 50);
  grant_ = {};  // an abort needs no credit
  ASSERT_TRUE(feed_.Abort());
  EXPECT_TRUE(sent_.back().abort);
  EXPECT_EQ(sent_.back().run, 7);
  EXPECT_TRUE(sent_.back().segments.empty());
  EXPECT_TRUE(feed_.sent_all());
  const std::size_t sent = sent_.size();
  grant_ = {true, false, {}, 0, kNever};
  Advance(kNever);
  EXPECT_EQ(sent_.size(), sent);
}

}  // namespace
}  // namespace intaglio::synchronizer
