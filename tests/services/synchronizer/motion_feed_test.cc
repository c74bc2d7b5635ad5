#include "services/synchronizer/motion_feed.h"

#include <gmock/gmock.h>

#include <map>
#include <random>

#include "services/bus/samples.h"
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

  void Begin() {
    decltype(EngravingJob::plan) plan;
    plan.rate_hz = 100;
    plan.profile = motion::Profile::kMix;
    feed_.Begin("job", 7, kStart, Vec3(-3, 0, 5), plan);
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
    SentBatch sent{
        batch.run, batch.sequence_number, batch.start_tick, batch.abort, batch.last, {}};
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

TEST_F(MotionFeedTest, AbortsWithOneLastWord) {
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
