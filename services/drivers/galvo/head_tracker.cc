#include "services/drivers/galvo/head_tracker.h"

#include <algorithm>
#include <cmath>

namespace intaglio::drivers {
namespace {

// With a sample each millisecond the speed is known to a count in this time.
constexpr std::size_t kFirstSamples = 50;
// At 1 kHz: settled within 0.1 s, a fifth of a count.
constexpr double kTrackerAlpha = 0.05, kTrackerBeta = 0.00125;

// A web whose speed varies does so at each turn of its rollers.
constexpr double kSurpriseSeconds = 5;

}  // namespace

HeadTracker::HeadTracker(double count_mm, double edge_sensor_mm, double ahead_s)
    : count_mm_(count_mm), edge_sensor_mm_(edge_sensor_mm), ahead_s_(ahead_s) {}

void HeadTracker::Forget() {
  first_.clear();
  follower_.reset();
  zero_mm_.reset();
  expected_mm_.clear();
  surprise_mm_ = 0;
}

void HeadTracker::Begin(std::uint16_t step_ticks) {
  period_s_ = step_ticks / rate_hz_;
  galvo::WebFollowerOptions options;
  options.count_mm = count_mm_;
  options.period_s = period_s_;
  options.alpha = kTrackerAlpha;
  options.beta = kTrackerBeta;
  options.edge_sensor_upstream_mm = edge_sensor_mm_;
  const auto counts = first_.back().encoder_count - first_.front().encoder_count;
  const double speed_mm_s = static_cast<double>(counts) * count_mm_ /
                            (static_cast<double>(first_.size() - 1) * period_s_);
  // Its first update is a period after what it begins with, and so is the first sample:
  // a web of 1 m/s would be a millimetre ahead of itself until that has settled.
  first_count_ =
      first_.front().encoder_count - std::llround(speed_mm_s * period_s_ / count_mm_);
  follower_.emplace(options, first_count_, speed_mm_s);
  for (const link::HeadWebSample& sample : first_)
    newest_mm_ = follower_->Update(sample.encoder_count, sample.edge_mm);
  first_.clear();
}

void HeadTracker::Follow(const link::HeadWebSample& sample) {
  newest_mm_ = follower_->Update(sample.encoder_count, sample.edge_mm);
  surprise_mm_ *= std::exp(-period_s_ / kSurpriseSeconds);
  expected_mm_.push_back(newest_mm_.x() + ahead_s_ * speed_mm_s());
  if (static_cast<double>(expected_mm_.size()) * period_s_ <= ahead_s_) return;
  surprise_mm_ = std::max(surprise_mm_, std::abs(newest_mm_.x() - expected_mm_.front()));
  expected_mm_.pop_front();
}

void HeadTracker::Receive(const link::HeadWeb& web, double rate_hz) {
  if (!follows()) return;
  rate_hz_ = rate_hz;
  for (const link::HeadWebSample& sample : web.samples) {
    if (follower_) {
      Follow(sample);
      continue;
    }
    first_.push_back(sample);
    if (first_.size() == kFirstSamples) Begin(web.step_ticks);
  }
  newest_tick_ =
      web.first_tick + (web.samples.size() - 1) * std::uint64_t{web.step_ticks};
}

// A sample is of the end of its tick; the follower adds half of its period.
double HeadTracker::PlaceAt(std::uint64_t tick, double later_s) const {
  const double by_s =
      (static_cast<double>(tick) - static_cast<double>(newest_tick_) - 0.5) / rate_hz_ +
      later_s - period_s_ / 2;
  return newest_mm_.x() + by_s * speed_mm_s();
}

Vec2 HeadTracker::At(std::uint64_t tick, double later_s) {
  if (!follower_) return Vec2::Zero();
  const double now_mm = newest_mm_.x() - period_s_ / 2 * speed_mm_s();
  if (!zero_mm_) zero_mm_ = now_mm;
  return {PlaceAt(tick, later_s) - *zero_mm_, newest_mm_.y()};
}

Vec2 HeadTracker::Since(double from, std::uint64_t tick, double later_s) const {
  return {(CountAt(tick, later_s) - from) * count_mm_, newest_mm_.y()};
}

double HeadTracker::CountAt(std::uint64_t tick, double later_s) const {
  return static_cast<double>(first_count_) + PlaceAt(tick, later_s) / count_mm_;
}

}  // namespace intaglio::drivers
