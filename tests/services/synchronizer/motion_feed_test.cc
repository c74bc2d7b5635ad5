#include "services/synchronizer/motion_feed.h"

#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <random>

#include "services/platform/bus/samples.h"
#include "services/synchronizer/engraving.h"

namespace intaglio::synchronizer {
namespace {

using bus::View;
constexpr std::uint32_t kSubticks = 65536;
constexpr std::uint64_t kStart = 1000;
constexpr std::uint64_t kNever = 1ull << 60;

struct SentSegment {
  Vec3 end_mm, velocity_mm_s;
  std::uint32_t duration_subticks;
  bool pulse;
  bool operator==(const SentSegment&) const = default;
};

struct SentBatch {
  std::uint32_t run;
  std::uint64_t number, start_tick;
  bool abort, last;
  std::vector<SentSegment> segments;
  std::uint64_t start_controller_ns;
  std::vector<std::uint64_t> controller_ns;
};

class MotionFeedTest : public testing::Test {
 protected:
  MotionFeedTest() {
    std::mt19937_64 random(3);
    for (int i = 0; i < 300; ++i) {
      points_mm_.push_back(Vec3(0.1 * i, 0.001 * static_cast<double>(random() % 500), 5));
    }
    Begin();
  }

  void Begin(const MotionClock* clock = nullptr) {
    decltype(EngravingJob::plan) plan;
    plan.rate_hz = 100;
    plan.profile = motion::Profile::kMix;
    feed_.Begin("job", 7, kStart, Vec3(-3, 0, 5), plan, clock);
  }

  void Advance(std::uint64_t horizon) {
    feed_.Advance(
        horizon,
        [this]() -> std::optional<MotionFeed::Target> {
          if (next_ == points_mm_.size()) return std::nullopt;
          const auto point = static_cast<std::uint32_t>(next_++);
          return MotionFeed::Target{point, points_mm_[point]};
        },
        schedule_);
  }

  Status Take(const intaglio_MotionSegmentBatch& batch) {
    if (refuse_) return Fail(ErrorCode::kTimedOut, "the test refuses it");
    const auto times = View(batch.controller_ns);
    SentBatch sent{batch.run,
                   batch.sequence_number,
                   batch.start_tick,
                   batch.abort,
                   batch.last,
                   {},
                   batch.start_controller_ns,
                   {times.begin(), times.end()}};
    const auto x = View(batch.x_mm), y = View(batch.y_mm), z = View(batch.z_mm);
    const auto vx = View(batch.vx_mm_s), vy = View(batch.vy_mm_s),
               vz = View(batch.vz_mm_s);
    for (std::size_t i = 0; i < View(batch.duration_subticks).size(); ++i) {
      sent.segments.push_back({Vec3(x[i], y[i], z[i]), Vec3(vx[i], vy[i], vz[i]),
                               View(batch.duration_subticks)[i],
                               View(batch.pulse)[i] != 0});
    }
    sent_.push_back(std::move(sent));
    return {};
  }

  std::vector<SentSegment> Segments() const {
    std::vector<SentSegment> all;
    for (const SentBatch& batch : sent_) {
      all.insert(all.end(), batch.segments.begin(), batch.segments.end());
    }
    return all;
  }

  std::uint64_t CoveredThrough() const {
    std::uint64_t subticks = 0;
    for (const SentSegment& segment : Segments()) subticks += segment.duration_subticks;
    return kStart + subticks / kSubticks;
  }

  PointList points_mm_;
  std::size_t next_ = 0;
  std::vector<SentBatch> sent_;
  bool refuse_ = false;
  bus::CreditBook::Grant grant_{true, false, {}, 0, kNever};
  std::string asked_for_;
  PulseSchedule schedule_;
  MotionFeed feed_{[this](const intaglio_MotionSegmentBatch& b) { return Take(b); },
                   [this](const std::string& stream) {
                     asked_for_ = stream;
                     return grant_;
                   }};
};

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
