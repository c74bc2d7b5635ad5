#include "services/drivers/galvo/head_tracker.h"

#include <gtest/gtest.h>

#include <cmath>

namespace intaglio::drivers {
namespace {

constexpr double kCountMm = 0.023, kRateHz = 1e5;
constexpr std::uint16_t kStepTicks = 100;

/// `count` samples from `from_tick` on, of a web at this speed since the tick 0.
link::HeadWeb Samples(std::uint64_t from_tick, int count, double speed_mm_s) {
  link::HeadWeb web;
  web.first_tick = from_tick;
  web.step_ticks = kStepTicks;
  for (int i = 0; i < count; ++i) {
    const double tick = static_cast<double>(from_tick) + i * kStepTicks + 1;
    link::HeadWebSample sample;
    sample.encoder_count = static_cast<decltype(sample.encoder_count)>(
        std::floor(speed_mm_s * tick / kRateHz / kCountMm));
    web.samples.push_back(sample);
  }
  return web;
}

// What it gives as soon as it can be asked, against what it gives when it has settled:
// between them the web has moved as far as it has. A count and a half are not known.
TEST(HeadTracker, FollowsAWebFromItsFirstAnswerOn) {
  for (const double speed_mm_s : {27.0, 200.0, 1000.0}) {
    HeadTracker tracker(kCountMm, 0, 0.04);
    std::uint64_t tick = 0;
    const auto run = [&](int samples) {
      tracker.Receive(Samples(tick, samples, speed_mm_s), kRateHz);
      tick += static_cast<std::uint64_t>(samples) * kStepTicks;
    };
    run(10);
    EXPECT_FALSE(tracker.ready());
    for (int i = 0; i < 4; ++i) run(10);
    ASSERT_TRUE(tracker.ready());
    const std::uint64_t first = tick;
    const double at_first_mm = tracker.At(first, 0).x();
    EXPECT_NEAR(tracker.speed_mm_s(), speed_mm_s, 0.6);
    for (int i = 0; i < 40; ++i) run(10);
    const double moved_mm = tracker.At(tick, 0).x() - at_first_mm;
    EXPECT_NEAR(moved_mm, speed_mm_s * static_cast<double>(tick - first) / kRateHz,
                1.5 * kCountMm)
        << speed_mm_s;
  }
}

TEST(HeadTracker, ExpectsTheCountThatComes) {
  HeadTracker tracker(kCountMm, 0, 0.04);
  for (std::uint64_t tick = 0; tick < 100000; tick += 10 * kStepTicks)
    tracker.Receive(Samples(tick, 10, 200), kRateHz);
  const double later_s = 0.0002;
  EXPECT_NEAR(tracker.CountAt(104000, later_s),
              200 * (1.04 - 0.5 / kRateHz + later_s) / kCountMm, 1.5);
  EXPECT_NEAR(tracker.counts_per_tick(), 200 / kRateHz / kCountMm, 2e-3);
}

TEST(HeadTracker, RemembersHowFarTheWebWasFromWhereItWasExpected) {
  HeadTracker tracker(kCountMm, 0, 0.04);
  std::uint64_t tick = 0;
  for (; tick < 200000; tick += 10 * kStepTicks)
    tracker.Receive(Samples(tick, 10, 200), kRateHz);
  EXPECT_LT(tracker.surprise_mm(), 0.05);
  // Faster by 20 mm/s, which 40 ms before nobody knew.
  const auto ahead = static_cast<std::int64_t>(std::llround(200 * 2.0 / kCountMm));
  for (std::uint64_t later = 0; later < 20000; later += 10 * kStepTicks) {
    link::HeadWeb web = Samples(later, 10, 220);
    web.first_tick += tick;
    for (link::HeadWebSample& sample : web.samples) sample.encoder_count += ahead;
    tracker.Receive(web, kRateHz);
  }
  EXPECT_NEAR(tracker.surprise_mm(), 0.8, 0.15);
}

}  // namespace
}  // namespace intaglio::drivers
