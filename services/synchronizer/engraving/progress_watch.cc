#include "services/synchronizer/engraving/progress_watch.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "engrave/core/counted.h"

namespace intaglio::synchronizer {
namespace {

constexpr double kSampleS = 1;
constexpr double kGrace = 0.8;
constexpr double kStalledRatio = 0.1, kRecoveredRatio = 0.2;

Disturbances Difference(const Disturbances& to, const Disturbances& from) {
  return {to.out_of_position_count - from.out_of_position_count,
          to.late_count - from.late_count,
          to.other_skips_count - from.other_skips_count,
          to.missed_count - from.missed_count,
          to.line_loss_count - from.line_loss_count,
          to.run_count - from.run_count};
}

}  // namespace

void Disturbances::Add(const PulseResult& result) {
  if (result.outcome == formats::PointOutcome::kMissed) ++missed_count;
  if (result.outcome != formats::PointOutcome::kSkipped) return;
  switch (result.reason) {
    case SkipReason::kLeftOut:
    case SkipReason::kNone:
      return;
    case SkipReason::kPosition:
      ++out_of_position_count;
      return;
    case SkipReason::kLate:
      ++late_count;
      return;
    default:
      ++other_skips_count;
  }
}

void ProgressWatch::Update(const WorkSight& sight) {
  const bool continues = began_ && now_.sight.works && sight.works && sight.tick != 0 &&
                         now_.sight.tick != 0 && sight.tick >= now_.sight.tick;
  if (continues) {
    const auto ticks = static_cast<double>(sight.tick - now_.sight.tick);
    now_.working_ticks += ticks;
    // What is gained above 100 % is not known; less than planned is never expected.
    now_.planned_ticks += ticks * std::min(sight.speed_percent, 100u) / 100;
  }
  // The place in the order jumps: what was expected at the old one says nothing.
  const bool jumps = began_ && sight.left_out_count != now_.sight.left_out_count;
  const std::uint64_t known_tick = sight.tick != 0 ? sight.tick : now_.sight.tick;
  now_.sight = sight;
  now_.sight.tick = known_tick;
  began_ = true;
  if (jumps) samples_.clear();
  if (!samples_.empty() &&
      now_.working_ticks < samples_.back().working_ticks + kSampleS * rate_hz_) {
    return;
  }
  samples_.push_back(now_);
  if (!point_ticks_.empty()) Judge();
}

std::uint64_t ProgressWatch::Expected(const Sample& from, const Sample& to) const {
  const std::size_t begin =
      std::min<std::size_t>(from.sight.ended_count, point_ticks_.size());
  const double start = begin == 0 ? 0 : point_ticks_[begin - 1];
  const double end = start + kGrace * (to.planned_ticks - from.planned_ticks);
  const auto first = point_ticks_.begin() + static_cast<std::ptrdiff_t>(begin);
  const auto made =
      std::upper_bound(first, point_ticks_.end(), end,
                       [](double tick, std::uint32_t planned) { return tick < planned; });
  return static_cast<std::uint64_t>(made - first);
}

bool ProgressWatch::IsWindow(const Sample& from, const Sample& to) const {
  if (to.working_ticks - from.working_ticks < kWindowS * rate_hz_) return false;
  const std::uint64_t expected = Expected(from, to);
  const std::uint64_t left =
      point_ticks_.size() -
      std::min<std::size_t>(from.sight.ended_count, point_ticks_.size());
  return expected >= kMinExpected || (expected > 0 && expected == left);
}

// The shortest window that ends now; what is older is not needed any more.
void ProgressWatch::Judge() {
  while (samples_.size() > 1 && IsWindow(samples_[1], now_)) samples_.pop_front();
  const Sample& from = samples_.front();
  if (!IsWindow(from, now_)) return;
  const std::uint64_t expected = Expected(from, now_);
  const std::uint64_t made =
      now_.sight.made_count - std::min(now_.sight.made_count, from.sight.made_count);
  const double limit =
      (stall_ ? kRecoveredRatio : kStalledRatio) * static_cast<double>(expected);
  if (static_cast<double>(made) >= limit) {
    stall_.reset();
    return;
  }
  const double renewal_ticks = kWindowS / 3 * rate_hz_;
  if (stall_ && now_.working_ticks < stalled_at_ticks_ + renewal_ticks) return;
  stalled_at_ticks_ = now_.working_ticks;
  stall_ = {(now_.working_ticks - from.working_ticks) / rate_hz_, made, expected,
            Difference(now_.sight.disturbances, from.sight.disturbances)};
}

std::string TextOf(const Stall& stall, const std::string& tolerance_mismatch) {
  struct Cause {
    std::uint64_t count;
    const char* text;
    const char* remedy;
  };
  const Disturbances& d = stall.disturbances;
  std::vector<Cause> causes = {
      {d.out_of_position_count,
       "pulses were held back because the stage was outside its position tolerance",
       "compare the tolerance of the stage controller with position_tolerance_um of the "
       "profile, and check the drives"},
      {d.late_count, "points were reached too late to be armed",
       "check the load of this computer and its lines"},
      {d.other_skips_count, "pulses were held back by the machine",
       "check lamp, shutters and interlocks"},
      {d.missed_count, "pulses made no crack",
       "check lens, block, pulse energy and photosensor"},
      {d.line_loss_count, "times a line was lost", "check the cables of the machine"}};
  std::erase_if(causes, [](const Cause& cause) { return cause.count == 0; });
  std::stable_sort(causes.begin(), causes.end(),
                   [](const Cause& a, const Cause& b) { return a.count > b.count; });
  std::vector<std::string> reasons;
  for (const Cause& cause : causes)
    reasons.push_back(fmt::format("{} {}", cause.count, cause.text));
  if (d.run_count > 1)
    reasons.push_back(fmt::format("the run began {}", Counted(d.run_count, "time")));
  const char* remedy =
      causes.empty() ? "pause the job and check the machine" : causes.front().remedy;
  return fmt::format(
      "no progress: {} of {} in {:.0f} s of work{}{}: {}", stall.made_count,
      Counted(stall.expected_count, "expected point"), stall.working_s,
      reasons.empty() ? "" : "; ", fmt::join(reasons, ", "),
      tolerance_mismatch.empty() || d.out_of_position_count == 0 ? remedy
                                                                 : tolerance_mismatch);
}

}  // namespace intaglio::synchronizer
