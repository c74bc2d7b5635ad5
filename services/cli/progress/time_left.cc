#include "services/cli/progress/time_left.h"

#include <fmt/format.h>

#include <algorithm>

#include "services/client/figure_text.h"

namespace intaglio::cli {
namespace {

constexpr double kPaceIsKnown = 0.05;
constexpr double kLongS = 60;

/// "14:32", of this computer's time zone.
std::string ClockTime(std::time_t time) {
  std::tm local = {};
  localtime_r(&time, &local);
  return fmt::format("{:02}:{:02}", local.tm_hour, local.tm_min);
}

}  // namespace

TimeLeft TimeLeftOf(double share, double elapsed_s, double expected_s, std::time_t now) {
  if (share <= 0 || share >= 1 || elapsed_s <= 0) return {};
  const bool by_plan = share < kPaceIsKnown && expected_s > 0;
  const double left_s = (1 - share) * (by_plan ? expected_s : elapsed_s / share);
  TimeLeft text{client::ShortDuration(left_s) + " left", {}};
  if (left_s >= kLongS)
    text.ends = "ends " + ClockTime(now + static_cast<std::time_t>(left_s));
  return text;
}

double EngravingSeconds(const client::JobView& job, double machine_speed) {
  if (machine_speed <= 0 || job.rate_hz <= 0 || job.speed_percent == 0) return 0;
  // Above 100 % the machine's limits and the lamp decide how much is gained.
  return static_cast<double>(job.estimate_ticks) / job.rate_hz / machine_speed * 100 /
         std::min(job.speed_percent, 100u);
}

std::string TimeLeftText(const client::JobView& job, std::time_t now) {
  const client::JobView::Progress* stage = client::StageAtWork(job);
  if (job.ended() || job.state == intaglio_JOB_PAUSED || stage == nullptr ||
      stage->total_count == 0)
    return {};
  const bool engraves = stage->stage == intaglio_STAGE_ENGRAVE;
  const double share =
      static_cast<double>(stage->done_count) / static_cast<double>(stage->total_count);
  const TimeLeft time =
      TimeLeftOf(share, stage->elapsed_s, engraves ? EngravingSeconds(job) : 0, now);
  if (time.left.empty()) return {};
  return fmt::format("{:.0f} %, {}{}{}", 100 * share, time.left,
                     time.ends.empty() ? "" : ", ", time.ends);
}

}  // namespace intaglio::cli
