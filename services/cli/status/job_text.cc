#include "services/cli/status/job_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "services/client/figure_text.h"
#include "services/client/warning_text.h"
#include "services/job/verdict/verdict.h"

namespace intaglio::cli {
namespace {

/// Of an ended job: what became of its points.
std::string VerdictReasonOf(const client::JobView& job) {
  EngraveOutcome outcome;
  outcome.set_planned_count(job.counts.planned);
  outcome.set_made_count(job.counts.made);
  outcome.set_missed_count(job.counts.missed);
  outcome.set_skipped_count(job.counts.skipped);
  outcome.set_uncertain_count(job.counts.uncertain);
  const bool known = job.counts.planned > 0;
  return VerdictOf(job.state == intaglio_JOB_DONE, known ? &outcome : nullptr,
                   job.warnings)
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

std::string CountsText(const intaglio_PointCounts& counts) {
  return fmt::format(
      "{} planned, {} made, {} missed, {} skipped, {} uncertain",
      client::GroupedDigits(counts.planned), client::GroupedDigits(counts.made),
      client::GroupedDigits(counts.missed), client::GroupedDigits(counts.skipped),
      client::GroupedDigits(counts.uncertain));
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

std::string ListText(std::vector<client::JobView> jobs) {
  std::sort(jobs.begin(), jobs.end(),
            [](const client::JobView& a, const client::JobView& b) {
              return a.number < b.number;
            });
  constexpr const char* kLine = "{:>6}  {:<24} {:<12} {:<9} {:<10} {:<28} {}\n";
  std::string text = fmt::format(fmt::runtime(kLine), "job", "state", "machine",
                                 "verdict", "time", "progress", "name");
  for (const client::JobView& job : jobs) {
    text += fmt::format(fmt::runtime(kLine), job.number, client::StateOf(job), job.cell,
                        job.verdict.empty() ? "-" : job.verdict, TimeOf(job),
                        ProgressOf(job), job.name);
    if (!job.alarm.empty()) text += fmt::format("        ALARM {}\n", job.alarm);
    if (const std::string reason = ReasonOf(job); !reason.empty())
      text += fmt::format("        {}\n", reason);
  }
  return text;
}

std::string ShowText(const client::JobView& job) {
  std::string text = fmt::format(
      "job        {} ({})\nname       {}\nstate      {}\nmachine    {}\nattempt    {}\n",
      job.number, job.uid, job.name, client::StateOf(job), job.cell, job.attempt);
  if (!job.verdict.empty()) text += fmt::format("verdict    {}\n", job.verdict);
  if (job.counts.planned > 0)
    text += fmt::format("points     {}\n", CountsText(job.counts));
  for (const client::JobView::Progress& p : job.progress) {
    if (p.total_count == 0) continue;
    text += fmt::format("{:<10} {} / {} points, {}\n", client::NameOf(p.stage),
                        client::GroupedDigits(p.done_count),
                        client::GroupedDigits(p.total_count),
                        client::ShortDuration(p.elapsed_s));
  }
  for (const Warning& warning : job.warnings) text += client::WarningLine(warning) + "\n";
  if (!job.breakage_accepted_by.empty())
    text += fmt::format("accepted   breakage, by {}\n", job.breakage_accepted_by);
  text += fmt::format("estimate   {}\nspeed      {} %\nfolder     {}\n", TimeOf(job),
                      job.speed_percent, job.result_directory);
  if (!job.alarm.empty()) text += fmt::format("alarm      {}\n", job.alarm);
  if (const std::string reason = ReasonOf(job); !reason.empty())
    text += fmt::format("{:<10} {}\n", job.ended() ? "reason" : "message", reason);
  if (!job.armed && !job.ended() && !job.disarm_reason.empty())
    text += fmt::format("disarmed   {}\n", job.disarm_reason);
  return text;
}

}  // namespace intaglio::cli
