#include "services/job/marks/web_run.h"

#include <fmt/format.h>

#include <cmath>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/galvo/web_speed.h"
#include "services/job/marks/job_marks.h"

namespace intaglio {
namespace {

/// Down to the last digit shown: what is typed from it is still possible.
double Shown(double speed_mm_s) { return std::floor(10 * speed_mm_s) / 10; }

std::string RepeatsAMinute(const JobSpec& job, double speed_mm_s) {
  const double pitch_mm = job.marks().repeats().pitch_mm();
  if (!(pitch_mm > 0)) return "";
  return fmt::format(", {:.4g} repeats a minute", 60 * speed_mm_s / pitch_mm);
}

}  // namespace

Result<WebRun> WebRunOf(const JobSpec& job, const MachineSpec& machine,
                        const mark::MarkSet& ordered) {
  const HeadFigures head = HeadFiguresOf(machine);
  MarkTimes times;
  const auto timed = TimedMarksOf(ordered, head, &times);
  return WebRunOf(job, head, timed, times);
}

Result<WebRun> WebRunOf(const JobSpec& job, const HeadFigures& head,
                        std::span<const galvo::TimedMark> timed, const MarkTimes& times) {
  auto max_mm_s = galvo::MaxSpeed(timed, head.web_field_mm());
  if (!max_mm_s) {
    max_mm_s.error().message = "marks.web: " + max_mm_s.error().message;
    return tl::unexpected(max_mm_s.error());
  }
  WebRun run{*max_mm_s, {}, times};
  const double asked_mm_s = job.marks().web().speed_mm_s();
  if (asked_mm_s > 0)
    run.missed = galvo::MissedMarks(timed, head.web_field_mm(), asked_mm_s);
  return run;
}

std::string NameOfMark(const JobSpec& job, std::span<const mark::Pen> pens,
                       const mark::Mark& mark) {
  const double pitch_mm = job.marks().repeats().pitch_mm();
  const double repeat = pitch_mm > 0 ? mark.web_mm / pitch_mm : 0;
  return fmt::format("{} of repeat {:.0f}", pens[mark.pen].name, repeat + 1);
}

Status CheckWebRun(const JobSpec& job, const MachineSpec& machine,
                   const mark::MarkSet& ordered, Warnings& warnings) {
  if (!job.has_marks() || !job.marks().has_web()) return {};
  const WebRun run = INTAGLIO_TRY(WebRunOf(job, machine, ordered));
  const double asked_mm_s = job.marks().web().speed_mm_s();
  if (!run.missed.empty()) {
    return Fail(
        ErrorCode::kRefused,
        fmt::format("marks.web.speed_mm_s: at {:.6g} mm/s {} of {} would be "
                    "missed, the first: {}; the largest speed is {:.1f} mm/s: give this "
                    "or less, mark faster, or give 0 for as fast as possible",
                    asked_mm_s, run.missed.size(), Counted(ordered.marks.size(), "mark"),
                    NameOfMark(job, ordered.pens, ordered.marks[run.missed.front()]),
                    Shown(run.max_mm_s)),
        fmt::format("{:.6g}", asked_mm_s));
  }
  if (asked_mm_s == 0) {
    warnings.push_back(MakeWarning(
        WarningCode::kChosen,
        fmt::format("marks.web.speed_mm_s: all marks are made up to {:.1f} mm/s{}; set "
                    "the drive of the web to this or less",
                    Shown(run.max_mm_s), RepeatsAMinute(job, run.max_mm_s))));
  }
  return {};
}

}  // namespace intaglio
