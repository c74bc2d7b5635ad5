#include "services/synchronizer/pulses/tick_clock.h"

#include <gtest/gtest.h>

#include <random>

namespace intaglio::synchronizer {
namespace {

using namespace std::chrono_literals;
using std::chrono::milliseconds;

link::LaserStatus StatusAt(double seconds, double rate_hz, double speed = 1) {
  link::LaserStatus status;
  status.rate_hz = rate_hz;
  status.tick = static_cast<std::uint64_t>(seconds * rate_hz * speed);
  return status;
}

TEST(TickClock, KeepsTheNominalRateUntilItSawAnother) {
  TickClock clock;
  clock.Observe(StatusAt(0, 200), 0ms);
  EXPECT_EQ(clock.ticks_per_s(), 200);
  EXPECT_EQ(clock.TickAt(100ms), 20u);
  EXPECT_FALSE(clock.settled());
  clock.Observe(StatusAt(0.06, 200), 60ms);
  EXPECT_TRUE(clock.settled());
}

TEST(TickClock, SeesAMachineThatRunsManyTimesRealTime) {
  for (const double speed : {0.01, 0.5, 1.0, 20.0, 100.0}) {
    TickClock clock;
    for (int ms = 0; ms <= 5000; ms += 20) {
      clock.Observe(StatusAt(ms * 1e-3, 200, speed), milliseconds(ms));
    }
    // A tick more or less over a second at least.
    EXPECT_NEAR(clock.ticks_per_s(), 200 * speed, 1.0) << speed;
    EXPECT_NEAR(static_cast<double>(clock.TickAt(5100ms)), 5.1 * 200 * speed, 2.0);
  }
}

TEST(TickClock, BearsStatusesThatAreLate) {
  std::mt19937_64 random(1);
  TickClock clock;
  for (int ms = 0; ms <= 10000; ms += 20) {
    clock.Observe(StatusAt(ms * 1e-3, 1000), milliseconds(ms + random() % 10));
    if (ms > 2000) {
      EXPECT_NEAR(clock.ticks_per_s(), 1000, 11);
    }
  }
}

TEST(TickClock, StartsOverWithAnotherRateOrAnotherPowerUp) {
  TickClock clock;
  for (int ms = 0; ms <= 2000; ms += 20) {
    clock.Observe(StatusAt(ms * 1e-3, 200, 20), milliseconds(ms));
  }
  clock.Observe(StatusAt(2.02, 100), 2020ms);
  EXPECT_EQ(clock.ticks_per_s(), 100);
  clock.Observe(StatusAt(0, 100), 2040ms);
  EXPECT_EQ(clock.TickAt(2040ms), 0u);
  EXPECT_EQ(clock.ticks_per_s(), 100);
}

}  // namespace
}  // namespace intaglio::synchronizer
