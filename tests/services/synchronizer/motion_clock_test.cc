#include "services/synchronizer/pulses/motion_clock.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace intaglio::synchronizer {
namespace {

/// An oscillator whose true time is known, and a line that is late at random.
class SimulatedClock {
 public:
  SimulatedClock(double rate_hz, double jitter_s, unsigned seed)
      : rate_hz_(rate_hz), jitter_s_(jitter_s), random_(seed) {}

  void Tick(double drift_ppm) {
    ++tick_;
    true_ns_ += (1 + drift_ppm * 1e-6) * 1e9 / rate_hz_;
    const double late_ns =
        1e9 * std::uniform_real_distribution<double>(0, jitter_s_)(random_);
    // What is sent first arrives first.
    received_ns_ = std::max(received_ns_, true_ns_ + late_ns);
  }
  /// The next lamp sync comes late, and so all behind it.
  void Shift(double seconds) { true_ns_ += 1e9 * seconds; }
  /// What is sent from now on arrives when that has passed.
  void HoldLine(double seconds) { received_ns_ = true_ns_ + 1e9 * seconds; }
  std::uint64_t tick() const { return tick_; }
  std::uint64_t stamp() const { return static_cast<std::uint64_t>(received_ns_); }
  /// At the newest tick, less the oscillator's own drift.
  double ErrorUs(const MotionClock& clock, double ahead_ticks, double drift_ppm) const {
    const double truth = true_ns_ + ahead_ticks * (1 + drift_ppm * 1e-6) * 1e9 / rate_hz_;
    return 1e-3 *
           (clock.ControllerNsAt(static_cast<double>(tick_) + ahead_ticks) - truth);
  }

 private:
  double rate_hz_, jitter_s_;
  std::mt19937_64 random_;
  std::uint64_t tick_ = 7000;
  double true_ns_ = 3.7e9, received_ns_ = 0;
};

TEST(MotionClock, FindsPhaseAndDriftBelowTheJitter) {
  for (const double rate_hz : {50.0, 200.0, 1000.0}) {
    for (const double drift_ppm : {-200.0, 0.3, 150.0}) {
      SimulatedClock truth(rate_hz, 0.002, 1);
      MotionClock clock;
      clock.Reset(rate_hz);
      double worst_us = 0, worst_ahead_us = 0, sum = 0, count = 0;
      for (int i = 0; i < 40 * rate_hz; ++i) {
        truth.Tick(drift_ppm);
        clock.Observe(truth.tick(), truth.stamp());
        if (i < 8 * rate_hz) continue;
        ASSERT_TRUE(clock.settled()) << rate_hz << " Hz, " << drift_ppm << " ppm";
        const double error_us = truth.ErrorUs(clock, 0, drift_ppm);
        worst_us = std::max(worst_us, std::abs(error_us));
        worst_ahead_us =
            std::max(worst_ahead_us, std::abs(truth.ErrorUs(clock, rate_hz, drift_ppm)));
        sum += error_us * error_us;
        ++count;
      }
      // Motion is out for a second: 80 mm/s make 5 um of 62 us. 50 Hz gives 400 stamps
      // to a line, a fiftieth of a tick.
      const double bound_us = rate_hz < 100 ? 80 : 62;
      EXPECT_LT(worst_us, bound_us) << rate_hz << " Hz, " << drift_ppm << " ppm";
      EXPECT_LT(worst_ahead_us, 1.5 * bound_us) << rate_hz << " Hz, " << drift_ppm;
      EXPECT_LT(std::sqrt(sum / count), 20);
      EXPECT_NEAR(clock.drift_ppm(), drift_ppm, 10);
      EXPECT_EQ(clock.steps(), 0u);
    }
  }
}

TEST(MotionClock, IsExactWithoutJitter) {
  SimulatedClock truth(200, 0, 1);
  MotionClock clock;
  clock.Reset(200);
  for (int i = 0; i < 100; ++i) {
    truth.Tick(-150);
    clock.Observe(truth.tick(), truth.stamp());
    if (i > 32) {  // a line is laid every 16 stamps
      EXPECT_TRUE(clock.settled());
    }
  }
  // Stamps are whole ns.
  EXPECT_NEAR(truth.ErrorUs(clock, 0, -150), 0, 0.002);
  EXPECT_NEAR(clock.drift_ppm(), -150, 0.01);
}

TEST(MotionClock, DoesNotSettleBeforeItIsGood) {
  SimulatedClock truth(200, 0.002, 5);
  MotionClock clock;
  clock.Reset(200);
  int ticks = 0;
  for (; !clock.settled() && ticks < 2000; ++ticks) {
    truth.Tick(120);
    clock.Observe(truth.tick(), truth.stamp());
  }
  EXPECT_GT(ticks, 200);
  EXPECT_LT(ticks, 800);
  EXPECT_LT(std::abs(truth.ErrorUs(clock, 0, 120)), 60);
}

TEST(MotionClock, NoticesThatThePaceHasChangedAndFindsTheNewOne) {
  for (const auto& [from_ppm, to_ppm] :
       {std::pair{150.0, -150.0}, {-150.0, 150.0}, {-100.0, 50.0}, {100.0, 0.0}}) {
    SimulatedClock truth(200, 0.002, 3);
    MotionClock clock;
    clock.Reset(200);
    for (int i = 0; i < 2000; ++i) {
      truth.Tick(from_ppm);
      clock.Observe(truth.tick(), truth.stamp());
    }
    ASSERT_EQ(clock.steps(), 0u);
    int noticed_after = 0;
    for (int i = 0; i < 2000; ++i) {
      truth.Tick(to_ppm);
      clock.Observe(truth.tick(), truth.stamp());
      if (clock.steps() > 0 && noticed_after == 0) noticed_after = i;
    }
    // 300 ppm make 300 us a second, and 200 us are clearly detected.
    if (std::abs(to_ppm - from_ppm) >= 300) {
      EXPECT_GT(noticed_after, 0) << to_ppm;
      EXPECT_LT(noticed_after, 400) << to_ppm;
    }
    EXPECT_TRUE(clock.settled());
    EXPECT_LT(std::abs(truth.ErrorUs(clock, 0, to_ppm)), 40) << to_ppm;
    // 20 us over the two seconds between the stamps that carry the line.
    EXPECT_NEAR(clock.drift_ppm(), to_ppm, 15);
  }
}

TEST(MotionClock, NoticesALampSyncThatIsLateOrLeftOutWithinTenTicks) {
  for (const double rate_hz : {50.0, 100.0, 200.0}) {
    for (const double shift_ticks : {1.0, 2.0, 7.0}) {
      for (const double jitter_s : {0.0, 0.0005, 0.002}) {
        SimulatedClock truth(rate_hz, jitter_s, 8);
        MotionClock clock;
        clock.Reset(rate_hz);
        clock.SetAhead(rate_hz);
        const auto pass = [&](int ticks) {
          for (int i = 0; i < ticks; ++i) {
            truth.Tick(100);
            clock.Observe(truth.tick(), truth.stamp());
          }
        };
        pass(2000);
        ASSERT_TRUE(clock.settled());
        truth.Shift(shift_ticks / rate_hz);
        pass(10);
        EXPECT_EQ(clock.steps(), 1u)
            << rate_hz << ", " << shift_ticks << ", " << jitter_s;
        EXPECT_FALSE(clock.settled()) << "a run that began now would be elsewhere";
        pass(static_cast<int>(8 * rate_hz));
        EXPECT_EQ(clock.steps(), 1u);
        EXPECT_TRUE(clock.settled());
        EXPECT_LT(std::abs(truth.ErrorUs(clock, 0, 100)), 80);
      }
    }
  }
}

// By jitters of a half tick and more, too, where the shift itself is seen much later.
TEST(MotionClock, NoTickBehindALampSyncThatIsLeftOutIsCertain) {
  for (const double jitter_s : {0.0, 0.0005, 0.003, 0.008, 0.02}) {
    for (const int before : {40, 100, 1500}) {
      for (const double shift_ticks : {0.15, 1.0, 3.0}) {
        // Less than the jitter is followed and not reported.
        if (0.01 * shift_ticks < jitter_s && shift_ticks < 1) continue;
        SimulatedClock truth(100, jitter_s, 11);
        MotionClock clock;
        clock.Reset(100);
        const auto pass = [&] {
          truth.Tick(20);
          clock.Observe(truth.tick(), truth.stamp());
        };
        for (int i = 0; i < 4000 && (i < before || !clock.settled()); ++i) pass();
        clock.BeginRun();
        EXPECT_EQ(clock.certain_through(), truth.tick());
        for (int i = 0; i < 100; ++i) pass();
        const std::uint64_t last = truth.tick();
        EXPECT_GT(clock.certain_through() + 60, last) << jitter_s;
        truth.Shift(shift_ticks / 100);
        for (int i = 0; i < 600; ++i) {
          pass();
          ASSERT_LE(clock.certain_through(), last)
              << jitter_s << ", " << before << ", " << shift_ticks << ", " << i;
        }
      }
    }
  }
}

TEST(MotionClock, EveryTickBecomesCertainThoughTheLineIsHeldUp) {
  SimulatedClock truth(200, 0.002, 9);
  MotionClock clock;
  clock.Reset(200);
  const auto pass = [&] {
    truth.Tick(80);
    clock.Observe(truth.tick(), truth.stamp());
  };
  for (int i = 0; i < 1000; ++i) pass();
  clock.BeginRun();
  for (int i = 0; i < 3000; ++i) {
    if (i % 200 == 0) truth.HoldLine(0.2);
    pass();
    EXPECT_FALSE(clock.lost_run());
    EXPECT_GE(clock.certain_through() + 60, truth.tick());
  }
}

TEST(MotionClock, ALampSyncTooManyAndAnotherClockLoseTheRun) {
  for (const bool is_reset : {false, true}) {
    SimulatedClock truth(100, 0.0005, 8);
    MotionClock clock;
    clock.Reset(100);
    const auto pass = [&] {
      truth.Tick(20);
      clock.Observe(truth.tick(), truth.stamp());
    };
    for (int i = 0; i < 500; ++i) pass();
    clock.BeginRun();
    const std::uint64_t last = truth.tick();
    EXPECT_FALSE(clock.lost_run());
    is_reset ? clock.Reset(100) : truth.Shift(-0.01);
    pass();
    EXPECT_EQ(clock.lost_run(), true);
    for (int i = 0; i < 500; ++i) pass();
    EXPECT_EQ(clock.certain_through(), last);
    clock.BeginRun();
    EXPECT_FALSE(clock.lost_run());
    for (int i = 0; i < 10; ++i) pass();
    EXPECT_EQ(clock.certain_through(), truth.tick());
  }
}

TEST(MotionClock, NoticesAShiftOfATenthOfATickWhereTheLineIsExactEnough) {
  SimulatedClock truth(100, 0.0003, 8);
  MotionClock clock;
  clock.Reset(100);
  for (int i = 0; i < 1000; ++i) {
    truth.Tick(100);
    clock.Observe(truth.tick(), truth.stamp());
  }
  truth.Shift(0.0011);
  for (int i = 0; i < 10; ++i) {
    truth.Tick(100);
    clock.Observe(truth.tick(), truth.stamp());
  }
  EXPECT_EQ(clock.steps(), 1u);
}

TEST(MotionClock, TakesALineThatWasHeldUpForNoShift) {
  for (const double held_s : {0.03, 0.1, 0.24}) {
    SimulatedClock truth(200, 0.002, 9);
    MotionClock clock;
    clock.Reset(200);
    for (int i = 0; i < 4000; ++i) {
      truth.Tick(80);
      if (i > 1000 && i % 200 == 0) truth.HoldLine(held_s);
      clock.Observe(truth.tick(), truth.stamp());
    }
    EXPECT_EQ(clock.steps(), 0u) << held_s;
    EXPECT_LT(std::abs(truth.ErrorUs(clock, 0, 80)), 60) << held_s;
  }
}

TEST(MotionClock, FollowsACrystalThatWarmsUpWithoutAReport) {
  SimulatedClock truth(200, 0.002, 4);
  MotionClock clock;
  clock.Reset(200);
  double drift_ppm = -20;
  for (int i = 0; i < 60 * 200; ++i) {
    drift_ppm += 1.0 / 200;  // 1 ppm a second
    truth.Tick(drift_ppm);
    clock.Observe(truth.tick(), truth.stamp());
    if (i > 2000) {
      EXPECT_LT(std::abs(truth.ErrorUs(clock, 0, drift_ppm)), 62);
    }
  }
  EXPECT_EQ(clock.steps(), 0u);
}

TEST(MotionClock, DoesNotMindAStampThatIsOutOfAllMeasure) {
  SimulatedClock truth(200, 0.002, 6);
  MotionClock clock;
  clock.Reset(200);
  for (int i = 0; i < 2000; ++i) {
    truth.Tick(80);
    clock.Observe(truth.tick(), truth.stamp() + (i % 300 == 17 ? 250000000u : 0u));
  }
  EXPECT_TRUE(clock.settled());
  EXPECT_LT(std::abs(truth.ErrorUs(clock, 0, 80)), 60);
}

TEST(MotionClock, StartsOverWithAnotherPowerUpOfTheLaser) {
  SimulatedClock truth(200, 0, 1);
  MotionClock clock;
  clock.Reset(200);
  for (int i = 0; i < 100; ++i) {
    truth.Tick(0);
    clock.Observe(truth.tick(), truth.stamp());
  }
  ASSERT_TRUE(clock.settled());
  clock.Observe(1, truth.stamp() + 1000000000);
  EXPECT_FALSE(clock.settled());
  EXPECT_EQ(clock.newest_tick(), 1u);
}

}  // namespace
}  // namespace intaglio::synchronizer
