#include <gmock/gmock.h>

#include <vector>

#include "tests/services/synchronizer/motion_feed_bench.h"

namespace intaglio::synchronizer {
namespace {

TEST_F(MotionFeedTest, ChangesItsSpeedFromTheNextPlannedMotionOnAndLosesNoPoint) {
  Advance(kStart + 200);
  const std::size_t fast = Segments().size();
  feed_.SetSpeed(0.3, schedule_);
  Advance(kStart + 400);
  const std::size_t slow_end = Segments().size();
  feed_.SetSpeed(1, schedule_);
  while (!feed_.sent_all()) Advance(kNever);
  const auto segments = Segments();
  std::vector<double> fastest(3, 0);
  std::uint64_t subticks = 0;
  std::size_t point = 0;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const int part = i < fast + 8 ? 0 : i < slow_end ? 1 : 2;
    fastest[part] =
        std::max(fastest[part], segments[i].velocity_mm_s.cwiseAbs().maxCoeff());
    subticks += segments[i].duration_subticks;
    if (!segments[i].pulse) continue;
    ASSERT_LT(point, points_mm_.size());
    EXPECT_LT((segments[i].end_mm - points_mm_[point++]).norm(), 1e-9) << "in its order";
    EXPECT_EQ(subticks % kSubticks, 0u);
  }
  EXPECT_EQ(point, points_mm_.size());
  // A step of 0.1 to 0.5 mm at 7 m/s^2 reaches 27 to 60 mm/s; at 0.63 m/s^2 8 to 18.
  EXPECT_GT(fastest[0], 25);
  EXPECT_LT(fastest[1], 20);
  EXPECT_GT(fastest[2], 25);
  std::size_t scheduled = 0;
  schedule_.Decide(
      kStart, kStart + 1, [](std::uint64_t, std::uint32_t) {}, [](std::uint32_t) {});
  for (std::uint64_t first = kStart + 2; first < kStart + 8000; first += 1000) {
    schedule_.Decide(
        first, first + 999, [&](std::uint64_t, std::uint32_t) { ++scheduled; },
        [](std::uint32_t late) { ADD_FAILURE() << late; });
  }
  EXPECT_EQ(scheduled, points_mm_.size());
}

TEST_F(MotionFeedTest, BeginsALaterRunAtTheSpeedThatIsSet) {
  feed_.SetSpeed(0.3, schedule_);
  Begin();
  Advance(kStart + 400);
  for (const SentSegment& segment : Segments()) {
    EXPECT_LT(segment.velocity_mm_s.cwiseAbs().maxCoeff(), 0.3 * 80 + 1e-9);
  }
}

// A job at half of the machine's speed; 140 % raises the cap, not above the machine's.
TEST_F(MotionFeedTest, GoesBeyondTheJobsLimitsAndNotBeyondTheMachines) {
  const auto ticks_and_peak = [this](double job_share, double ratio) {
    sent_.clear();
    schedule_ = {};
    next_ = 0;
    limits_ = motion::LimitsAtSpeed(machine_, machine_, job_share);
    feed_.SetSpeed(ratio, schedule_);
    Begin();
    while (!feed_.sent_all()) Advance(kNever);
    double peak_mm_s = 0;
    std::uint64_t subticks = 0;
    for (const SentSegment& segment : Segments()) {
      peak_mm_s = std::max(peak_mm_s, segment.velocity_mm_s.cwiseAbs().maxCoeff());
      subticks += segment.duration_subticks;
    }
    return std::pair{subticks / kSubticks, peak_mm_s};
  };
  const auto [half_ticks, half_peak] = ticks_and_peak(0.5, 1);
  const auto [more_ticks, more_peak] = ticks_and_peak(0.5, 1.4);
  const auto [full_ticks, full_peak] = ticks_and_peak(1, 1);
  const auto [over_ticks, over_peak] = ticks_and_peak(1, 1.4);
  EXPECT_LE(half_peak, 40 + 1e-9);
  EXPECT_GT(more_peak, half_peak);
  EXPECT_LE(more_peak, 56 + 1e-9);
  // A step takes whole ticks, so not all of 1 / 1.4 is gained.
  EXPECT_LT(static_cast<double>(more_ticks), 0.9 * static_cast<double>(half_ticks));
  EXPECT_GE(static_cast<double>(more_ticks), static_cast<double>(half_ticks) / 1.4);
  EXPECT_EQ(over_ticks, full_ticks) << "the machine is at its limits";
  EXPECT_EQ(over_peak, full_peak);
}

TEST_F(MotionFeedTest, MakesEveryPointAtOnePercentOfItsSpeed) {
  feed_.SetSpeed(0.01, schedule_);
  Begin();
  while (!feed_.sent_all()) Advance(kNever);
  std::size_t pulses = 0;
  for (const SentSegment& segment : Segments()) {
    EXPECT_LT(segment.velocity_mm_s.cwiseAbs().maxCoeff(), 0.01 * 80 + 1e-9);
    pulses += segment.pulse ? 1 : 0;
  }
  EXPECT_EQ(pulses, points_mm_.size());
}

}  // namespace
}  // namespace intaglio::synchronizer
