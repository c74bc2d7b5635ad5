#include "services/job/marks/web_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/galvo/web_speed.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/machine/head_ticks.h"
#include "services/job/marks/job_marks.h"
#include "services/job/marks/timed_mark.h"

namespace intaglio {
namespace {

/// Down to the last digit shown: what is typed from it is still possible.
double Shown(double speed_mm_s) { return std::floor(10 * speed_mm_s) / 10; }

std::string RepeatsAMinute(const JobSpec& job, double speed_mm_s) {
  const double pitch_mm = job.marks().repeats().pitch_mm();
  if (!(pitch_mm > 0)) return "";
  return fmt::format(", {:.4g} repeats a minute", 60 * speed_mm_s / pitch_mm);
}

/// Of the pitch: print marks may lie nearer to each other by their tolerance.
double RoomByPrint(const JobSpec& job) {
  if (!job.marks().web().has_eye()) return 1;
  const Marks marks = WithDefaults(job.marks());
  return 1 - marks.web().eye().tolerance_mm() / marks.repeats().pitch_mm();
}

}  // namespace

std::string PrintMarksText(const JobSpec& job) {
  const Marks marks = WithDefaults(job.marks());
  const MarkEye& eye = marks.web().eye();
  return fmt::format(
      "marks.web.eye: each repeat begins at its print mark, expected every {:g} mm "
      "within "
      "{:g} mm; up to {} may be missing in a row",
      marks.repeats().pitch_mm(), eye.tolerance_mm(), eye.max_missing());
}

Result<WebRun> WebRunOf(const JobSpec& job, const MachineSpec& machine,
                        const mark::MarkSet& ordered) {
  const HeadFigures head = HeadFiguresOf(machine);
  MarkTimes times;
  const auto timed = TimedMarksOf(ordered, head, &times);
  auto run = INTAGLIO_TRY(WebRunOf(job, head, timed, times));
  if (job.marks().web().has_eye()) {
    LimitByEye(job, machine.scan_head(),
               EarliestBeginMm(ordered.marks, ordered.pens, head), run);
  }
  return run;
}

double EarliestBeginMm(std::span<const mark::Mark> marks, std::span<const mark::Pen> pens,
                       const HeadFigures& head) {
  double earliest_mm = std::numeric_limits<double>::infinity();
  for (const mark::Mark& mark : marks) {
    const double from_mm = ExtentOf(mark, pens[mark.pen], head).made_at.from_mm;
    earliest_mm = std::min(earliest_mm, from_mm - mark.web_mm);
  }
  return earliest_mm;
}

// A print mark is reported with the next status, and a mark is sent as far ahead as all
// ticks are, half of it at the latest.
void LimitByEye(const JobSpec& job, const ScanHead& head, double earliest_mm,
                WebRun& run) {
  const Marks marks = WithDefaults(job.marks());
  if (!marks.web().has_eye()) return;
  const MarkEye& eye = marks.web().eye();
  run.eye_way_mm = earliest_mm - (eye.offset_mm() - head.eye_mm());
  run.eye_max_mm_s = std::max(0.0, run.eye_way_mm / EyeAheadSeconds(head));
  run.max_mm_s = std::min(run.max_mm_s, *run.eye_max_mm_s);
}

Status CheckEyeWay(const JobSpec& job, const MachineSpec& machine, const WebRun& run) {
  if (!run.eye_max_mm_s) return {};
  const ScanHead& head = machine.scan_head();
  const double asked_mm_s = job.marks().web().speed_mm_s();
  if (*run.eye_max_mm_s > 0 && asked_mm_s <= *run.eye_max_mm_s) return {};
  const std::string seen = fmt::format(
      "the photo eye of {} (scan_head.eye_mm: {:g}) sees a print mark {:.1f} mm of web "
      "before the first mark of its repeat can begin, and ticks are sent {:.0f} ms ahead",
      machine.name(), head.eye_mm(), std::max(0.0, run.eye_way_mm),
      1e3 * EyeAheadSeconds(head));
  if (*run.eye_max_mm_s <= 0) {
    return Fail(
        ErrorCode::kRefused,
        fmt::format("marks.web.eye.offset_mm: {:g} mm: {}; mount the eye {:.1f} mm "
                    "or more farther from the field, or choose print marks that "
                    "arrive before their repeat",
                    job.marks().web().eye().offset_mm(), seen, -run.eye_way_mm),
        fmt::format("{:g}", job.marks().web().eye().offset_mm()));
  }
  return Fail(
      ErrorCode::kRefused,
      fmt::format("marks.web.speed_mm_s: at {:.6g} mm/s that is too late: {}; the "
                  "largest speed is {:.1f} mm/s: give this or less, or mount the "
                  "eye farther from the field",
                  asked_mm_s, seen, Shown(*run.eye_max_mm_s)),
      fmt::format("{:.6g}", asked_mm_s));
}

Result<WebRun> WebRunOf(const JobSpec& job, const HeadFigures& head,
                        std::span<const galvo::TimedMark> timed, const MarkTimes& times) {
  auto max_mm_s = galvo::MaxSpeed(timed, head.web_field_mm());
  if (!max_mm_s) {
    max_mm_s.error().message = "marks.web: " + max_mm_s.error().message;
    return tl::unexpected(max_mm_s.error());
  }
  const double room_ratio = RoomByPrint(job);
  WebRun run{*max_mm_s * room_ratio, {}, times};
  const double asked_mm_s = job.marks().web().speed_mm_s() / room_ratio;
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
  INTAGLIO_TRY(CheckEyeWay(job, machine, run));
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
  if (run.eye_max_mm_s)
    warnings.push_back(MakeWarning(WarningCode::kChosen, PrintMarksText(job)));
  return {};
}

}  // namespace intaglio
