#include "services/synchronizer/pulses/motion_clock.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "engrave/core/check.h"

// How far the line is off. n stamps, late by 0..J evenly: the minimum of n is late by
// J / (n + 1) on the average, and the two that carry the line are such minima of its
// halves, so at its end, half a window further, it is off by about 4 J / n.
//
// How a change of pace shows. All of m stamps are late by more than x with probability
// (1 - x / J)^m, which for x = 20 J / m is e^-20: never in a job. So each quarter of the
// stamps has one below that, or there is no one line: the clock has become slower. One
// that has become faster gives stamps below the line of a second ago, where none can be.
// A smaller change is followed and not reported.

namespace intaglio::synchronizer {
namespace {

// Long enough that the line is good to some us, short enough to follow a crystal that
// warms up by 1 ppm a second.
constexpr double kWindowSeconds = 4, kWindowPerAhead = 4;
constexpr double kMinWindow = 400, kMaxWindow = 4096;
constexpr std::size_t kFitEvery = 16;
constexpr std::size_t kMinStamps = 16;
constexpr std::size_t kParts = 4;
constexpr std::size_t kMinPart = 64;
constexpr double kNeverFactor = 20;
// No stamp is early; only the line of a second ago may be wrong, seen 0.35 of the limit.
constexpr double kAheadOfLimit = 0.6;
// The controller's clock has some resolution of its own.
constexpr double kResolutionNs = 2000;
constexpr std::size_t kStampsAfterStep = 64;
// No stamp of one line is later than the jitter, and those of a shift are as scattered as
// it.
constexpr std::size_t kShiftStamps = 8;
constexpr double kShiftTickRatio = 0.1, kShiftJitters = 1.5, kScatterJitters = 2;
constexpr double kSettledNs = 16e3;
constexpr double kSettledTickRatio = 1.0 / 300;

}  // namespace

void MotionClock::Reset(double rate_hz) {
  Require(rate_hz > 0, "rate_hz has to be positive, is {}", rate_hz);
  const std::uint32_t steps = steps_;
  const std::uint64_t certain_through = certain_through_;
  *this = MotionClock();
  steps_ = steps;
  certain_through_ = certain_through;
  lost_run_ = true;
  tick_ns_ = 1e9 / rate_hz;
  SetAhead(kWindowSeconds * rate_hz / kWindowPerAhead);
}

void MotionClock::SetAhead(double ticks) {
  window_ = static_cast<std::size_t>(
      std::clamp(kWindowPerAhead * ticks, kMinWindow, kMaxWindow));
}

void MotionClock::Observe(std::uint64_t tick, std::uint64_t controller_ns) {
  if (tick_ns_ <= 0) return;
  if (!stamps_.empty() && tick <= newest_tick_) Reset(1e9 / tick_ns_);
  if (stamps_.empty()) {
    base_tick_ = tick;
    base_ns_ = controller_ns;
  }
  newest_tick_ = tick;
  const auto ticks = static_cast<double>(tick - base_tick_);
  // The difference of both is exact, whatever the sign.
  const auto ns =
      static_cast<double>(static_cast<std::int64_t>(controller_ns - base_ns_));
  stamps_.push_back({ticks, ns - ticks * tick_ns_});
  while (stamps_.size() > window_) stamps_.pop_front();
  CountCertain(stamps_.back());
  const bool early = IsEarly();
  if (early || IsShifted()) {
    lost_run_ = true;
    CountStep(early ? 1 : kShiftStamps, line_);
    settled_ = false;
    return;
  }
  if (++unfitted_ >= kFitEvery || stamps_.size() < kMinStamps) Fit();
}

void MotionClock::BeginRun() {
  certain_through_ = newest_tick_;
  lost_run_ = false;
  run_line_.reset();
}

double MotionClock::LateTicks() const {
  if (!run_line_ || stamps_.empty()) return 0;
  const double tick = stamps_.back().tick;
  return std::max(0.0, line_.LateNsAt(tick) - run_line_->LateNsAt(tick)) / tick_ns_;
}

void MotionClock::CountCertain(const Stamp& stamp) {
  const double beside_ns = stamp.late_ns - run_line_.value_or(line_).LateNsAt(stamp.tick);
  if (!lost_run_ && std::abs(beside_ns) < kShiftTickRatio * tick_ns_)
    certain_through_ = newest_tick_;
}

double MotionClock::ControllerNsAt(double tick) const {
  Require(!stamps_.empty(), "no stamp of tick {} or any other has come", tick);
  const double ticks = tick - static_cast<double>(base_tick_);
  return static_cast<double>(base_ns_) + ticks * tick_ns_ + line_.LateNsAt(ticks);
}

// The edge of the lower hull that spans the middle of the stamps.
void MotionClock::FitLine() {
  hull_.clear();
  for (const Stamp& stamp : stamps_) {
    while (hull_.size() >= 2) {
      const Stamp& a = hull_[hull_.size() - 2];
      const Stamp& b = hull_.back();
      const double turn = (b.tick - a.tick) * (stamp.late_ns - a.late_ns) -
                          (stamp.tick - a.tick) * (b.late_ns - a.late_ns);
      if (turn > 0) break;
      hull_.pop_back();
    }
    hull_.push_back(stamp);
  }
  const double middle = 0.5 * (stamps_.front().tick + stamps_.back().tick);
  auto right = std::find_if(hull_.begin(), hull_.end(),
                            [&](const Stamp& stamp) { return stamp.tick >= middle; });
  if (right == hull_.begin() && hull_.size() > 1) ++right;
  line_.slope_ns = 0;
  if (hull_.size() > 1) {
    const auto left = std::prev(right);
    line_.slope_ns = (right->late_ns - left->late_ns) / (right->tick - left->tick);
  }
  line_.offset_ns = right->late_ns - line_.slope_ns * right->tick;
}

void MotionClock::Measure() {
  above_ns_.clear();
  for (const Stamp& stamp : stamps_) {
    above_ns_.push_back(stamp.late_ns - line_.LateNsAt(stamp.tick));
  }
  // Twice the median is J, and does not mind a stamp that is out of all measure.
  std::vector<double> sorted = above_ns_;
  const auto median = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), median, sorted.end());
  jitter_ns_ = 2 * *median;
  const auto count = static_cast<double>(stamps_.size());
  uncertainty_ns_ = 4 * jitter_ns_ / count;
  limit_ns_ = kResolutionNs + kNeverFactor * jitter_ns_ * kParts / count;
}

bool MotionClock::LeavesLine() const {
  const std::size_t part = stamps_.size() / kParts;
  if (part < kMinPart) return false;
  for (std::size_t i = 0; i < kParts; ++i) {
    const auto begin = above_ns_.begin() + static_cast<std::ptrdiff_t>(i * part);
    const auto end = begin + static_cast<std::ptrdiff_t>(part);
    if (*std::min_element(begin, end) > limit_ns_) return true;
  }
  return false;
}

bool MotionClock::IsEarly() const {
  const Stamp& newest = stamps_.back();
  return settled_ &&
         newest.late_ns - line_.LateNsAt(newest.tick) < -kShiftTickRatio * tick_ns_;
}

bool MotionClock::IsShifted() const {
  if (stamps_.size() < kMinStamps + kShiftStamps) return false;
  double min_ns = std::numeric_limits<double>::infinity(), max_ns = 0;
  for (auto stamp = stamps_.end() - static_cast<std::ptrdiff_t>(kShiftStamps);
       stamp != stamps_.end(); ++stamp) {
    const double above_ns = stamp->late_ns - line_.LateNsAt(stamp->tick);
    min_ns = std::min(min_ns, above_ns);
    max_ns = std::max(max_ns, above_ns);
  }
  const double jitter_ns = jitter_ns_ + kResolutionNs;
  return min_ns > std::max(kShiftJitters * jitter_ns, kShiftTickRatio * tick_ns_) &&
         max_ns - min_ns <= kScatterJitters * jitter_ns;
}

bool MotionClock::RunsAhead() {
  const std::size_t kept = window_ / kParts / kFitEvery;
  const bool ahead =
      earlier_lines_.size() >= kept &&
      std::any_of(stamps_.end() - static_cast<std::ptrdiff_t>(kFitEvery), stamps_.end(),
                  [this](const Stamp& stamp) {
                    return stamp.late_ns < earlier_lines_.front().LateNsAt(stamp.tick) -
                                               kAheadOfLimit * limit_ns_;
                  });
  if (stamps_.size() == window_) earlier_lines_.push_back(line_);
  if (earlier_lines_.size() > kept) earlier_lines_.pop_front();
  return ahead;
}

void MotionClock::KeepNewest(std::size_t count) {
  stamps_.erase(stamps_.begin(), stamps_.end() - static_cast<std::ptrdiff_t>(count));
  earlier_lines_.clear();
}

void MotionClock::CountStep(std::size_t kept_stamps, const Line& before) {
  ++steps_;
  if (!run_line_) run_line_ = before;
  KeepNewest(kept_stamps);
  FitLine();
  Measure();
}

void MotionClock::Fit() {
  unfitted_ = 0;
  const Line before = line_;
  FitLine();
  Measure();
  if (LeavesLine() || RunsAhead()) CountStep(kStampsAfterStep, before);
  settled_ = stamps_.size() >= kMinStamps &&
             uncertainty_ns_ <= std::max(kSettledNs, kSettledTickRatio * tick_ns_);
}

}  // namespace intaglio::synchronizer
