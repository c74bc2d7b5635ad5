#pragma once

// A MotionFeed whose batches the test keeps, and a way of 300 points.

#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "services/platform/bus/samples.h"
#include "services/synchronizer/engraving.h"
#include "services/synchronizer/engraving/motion_feed.h"

namespace intaglio::synchronizer {

using bus::View;
inline constexpr std::uint32_t kSubticks = 65536;
inline constexpr std::uint64_t kStart = 1000;
inline constexpr std::uint64_t kNever = 1ull << 60;

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
    plan.limits = limits_;
    feed_.Begin("job", 7, kStart, Vec3(-3, 0, 5), plan, machine_, clock);
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

  Status Receive(const intaglio_MotionSegmentBatch& batch) {
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
  motion::Limits machine_, limits_ = machine_;
  std::vector<SentBatch> sent_;
  bool refuse_ = false;
  bus::CreditBook::Grant grant_{true, false, {}, 0, kNever};
  std::string asked_for_;
  PulseSchedule schedule_;
  MotionFeed feed_{[this](const intaglio_MotionSegmentBatch& b) { return Receive(b); },
                   [this](const std::string& stream) {
                     asked_for_ = stream;
                     return grant_;
                   }};
};

}  // namespace intaglio::synchronizer
