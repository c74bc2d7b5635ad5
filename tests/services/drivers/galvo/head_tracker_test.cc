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
    HeadTracker tracker(kCountMm, 0);
    std::uint64_t tick = 0;
    const auto run = [&](int samples) {
      tracker.Take(Samples(tick, samples, speed_mm_s), kRateHz);
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

}  // namespace
}  // namespace intaglio::drivers
