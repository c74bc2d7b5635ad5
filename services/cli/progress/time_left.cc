#include "services/cli/progress/time_left.h"

#include <fmt/format.h>

#include "services/client/figure_text.h"
#include "services/client/job_view.h"

namespace intaglio::cli {
namespace {

constexpr double kLongS = 60;

std::tm LocalTime(std::time_t time) {
  std::tm local = {};
  localtime_r(&time, &local);
  return local;
}

}  // namespace

std::string ClockTime(std::time_t time, std::time_t now) {
  const std::tm local = LocalTime(time), today = LocalTime(now);
  const bool is_today = local.tm_yday == today.tm_yday && local.tm_year == today.tm_year;
  return (is_today ? std::string()
                   : fmt::format("{}-{:02}-{:02} ", 1900 + local.tm_year,
                                 local.tm_mon + 1, local.tm_mday)) +
         fmt::format("{:02}:{:02}", local.tm_hour, local.tm_min);
}

TimeLeft TimeLeftOf(const client::WorkLeft& work, std::time_t now) {
  if (work.left_s <= 0) return {};
  TimeLeft text{client::ShortDuration(work.left_s) + " left", {}};
  if (work.left_s >= kLongS)
    text.ends = "ends " + ClockTime(now + static_cast<std::time_t>(work.left_s), now);
  return text;
}

std::string TimeLeftText(const client::WorkLeft& work, std::time_t now) {
  const TimeLeft time = TimeLeftOf(work, now);
  if (time.left.empty()) return {};
  return fmt::format("{:.0f} %, {}{}{}", 100 * work.share, time.left,
                     time.ends.empty() ? "" : ", ", time.ends);
}

std::string PaceText(const client::WorkLeft& work, std::uint32_t speed_percent,
                     std::time_t now) {
  const std::string left = TimeLeftText(work, now);
  const std::string speed = client::SpeedNote(speed_percent);
  return left + (left.empty() || speed.empty() ? "" : ", ") + speed;
}

}  // namespace intaglio::cli
