#include "services/cli/status/job_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <tuple>

#include "engrave/core/counted.h"
#include "services/cli/progress/time_left.h"
#include "services/cli/terminal/text_table.h"
#include "services/client/event_lines.h"
#include "services/client/figure_text.h"
#include "services/client/job_need.h"
#include "services/client/shop/queue_time.h"
#include "services/client/warning_text.h"
#include "services/job/verdict/verdict.h"

namespace intaglio::cli {
namespace {

/// Names what became of the points of an ended job.
std::string VerdictReasonOf(const client::JobView& job) {
  if (!client::IsSettled(job))
    return fmt::format("its machine has not reported yet which {} were made", job.makes);
  return VerdictOf(job.state == intaglio_JOB_DONE, job.counts, job.warnings, job.makes)
      .reason;
}

std::string ProgressOf(const client::JobView& job) {
  if (job.ended()) {
    if (job.counts.planned == 0) return "-";
    return fmt::format("made {} / {}", client::GroupedDigits(job.counts.made),
                       client::GroupedDigits(job.counts.planned));
  }
  const client::JobView::Progress* p = client::StageAtWork(job);
  if (p == nullptr || p->total_count == 0) return "-";
  return fmt::format("{} {} / {}", client::NameOf(p->stage),
                     client::GroupedDigits(p->done_count),
                     client::GroupedDigits(p->total_count));
}

/// "200 planned, 120 made, 3 armed, 77 to come"; at the end none is to come or armed.
std::string CountsText(const client::JobView& job) {
  const intaglio_PointCounts& counts = job.counts;
  std::string text =
      fmt::format("{} planned, {} made", client::GroupedDigits(counts.planned),
                  client::GroupedDigits(counts.made));
  const auto add = [&text](std::uint64_t count, const char* what, bool always) {
    if (count > 0 || always)
      text += fmt::format(", {} {}", client::GroupedDigits(count), what);
  };
  const bool ended = job.ended();
  add(counts.armed, "armed", !ended);
  add(counts.to_come, "to come", !ended);
  add(counts.missed, "missed", ended);
  add(counts.skipped, ended ? "skipped" : "left out", ended);
  add(counts.uncertain, "uncertain", ended);
  return text;
}

/// "queued, place 2".
std::string StateInQueue(const client::JobView& job) {
  std::string state = client::StateOf(job);
  if (job.queue_place > 0) state += fmt::format(", place {}", job.queue_place);
  return state;
}

/// "queue of left: 2 jobs take 1 h 02 min, until 14:32 or later; the time of 3 jobs is
/// not known". Empty of a single job, which has a line of its own.
std::string QueueLine(const QueueTime& queue, std::time_t now) {
  if (queue.jobs() < 2) return {};
  const std::uint32_t known = queue.jobs() - queue.unknown_jobs();
  std::string text = fmt::format("queue of {}: ", queue.cell());
  if (known > 0) {
    const std::time_t end = now + static_cast<std::time_t>(queue.left_s());
    text += fmt::format("{} {} {}, until {} or later", Counted(known, "job"),
                        known == 1 ? "takes" : "take",
                        client::ShortDuration(queue.left_s()), ClockTime(end, now));
  }
  if (queue.unknown_jobs() > 0) {
    text += fmt::format("{}the time of {} is not known", known > 0 ? "; " : "",
                        Counted(queue.unknown_jobs(), "job"));
  }
  return text + "\n";
}

}  // namespace

std::string TimeOf(const client::JobView& job) {
  if (job.estimate_ticks == 0 || job.rate_hz <= 0) return "-";
  return client::ShortDuration(static_cast<double>(job.estimate_ticks) / job.rate_hz);
}

std::string ReasonOf(const client::JobView& job) {
  if (!job.ended()) return job.message;
  const std::string of_points = VerdictReasonOf(job);
  if (job.message.empty() || of_points.empty()) return job.message + of_points;
  return job.message + "; " + of_points;
}

std::string ListText(std::vector<client::JobView> jobs, std::time_t now) {
  std::sort(
      jobs.begin(), jobs.end(), [](const client::JobView& a, const client::JobView& b) {
        return std::tie(a.queue_place, a.number) < std::tie(b.queue_place, b.number);
      });
  using Align = TextTable::Align;
  TextTable table({{"job", Align::kRight},
                   {"state"},
                   {"machine"},
                   {"verdict"},
                   {"time"},
                   {"progress"},
                   {"name"}});
  for (const client::JobView& job : jobs) {
    table.AddRow({std::to_string(job.number), StateInQueue(job), job.cell,
                  job.verdict.empty() ? "-" : job.verdict, TimeOf(job), ProgressOf(job),
                  job.name});
    const std::uint32_t speed_percent = job.ended() ? 100 : job.speed_percent;
    if (const std::string pace = PaceText(client::WorkLeftOf(job), speed_percent, now);
        !pace.empty())
      table.AddBelow(pace);
    if (!job.alarm.empty()) table.AddBelow("ALARM " + job.alarm);
    if (const std::string need = client::NeedOf(job); !need.empty())
      table.AddBelow("to do: " + need);
    else if (const std::string reason = ReasonOf(job); !reason.empty())
      table.AddBelow(reason);
  }
  std::string text = table.Text();
  for (const QueueTime& queue :
       client::QueueTimesOf(jobs, std::chrono::system_clock::from_time_t(now)))
    text += QueueLine(queue, now);
  return text;
}

std::string ShowText(const client::JobView& job, std::time_t now) {
  std::string text = fmt::format(
      "job        {} ({})\nname       {}\nstate      {}\nmachine    {}\nattempt    {}\n",
      job.number, job.uid, job.name, client::StateOf(job), job.cell, job.attempt);
  if (job.queue_place > 0) text += fmt::format("queue      place {}\n", job.queue_place);
  if (!job.verdict.empty()) text += fmt::format("verdict    {}\n", job.verdict);
  if (job.counts.planned > 0)
    text += fmt::format("{:<10} {}\n", job.makes, CountsText(job));
  for (const client::JobView::Progress& p : job.progress) {
    if (p.total_count == 0) continue;
    text += fmt::format("{:<10} {} / {} {}, {}\n", client::NameOf(p.stage),
                        client::GroupedDigits(p.done_count),
                        client::GroupedDigits(p.total_count), job.makes,
                        client::ShortDuration(p.elapsed_s));
  }
  if (const std::string left = TimeLeftText(client::WorkLeftOf(job), now); !left.empty())
    text += fmt::format("at work    {}\n", left);
  for (const Warning& warning : job.warnings) text += client::WarningLine(warning) + "\n";
  if (!job.breakage_accepted_by.empty())
    text += fmt::format("accepted   breakage, by {}\n", job.breakage_accepted_by);
  text += fmt::format("estimate   {}\nspeed      {} %\nfolder     {}\n", TimeOf(job),
                      job.speed_percent, job.result_directory);
  if (!job.alarm.empty()) text += fmt::format("alarm      {}\n", job.alarm);
  if (const std::string reason = ReasonOf(job); !reason.empty())
    text += fmt::format("{:<10} {}\n", job.ended() ? "reason" : "message", reason);
  if (const std::string need = client::NeedOf(job); !need.empty())
    text += fmt::format("to do      {}\n", need);
  if (!job.armed && !job.ended() && !job.disarm_reason.empty())
    text += fmt::format("disarmed   {}\n", job.disarm_reason);
  return text;
}

}  // namespace intaglio::cli
