#pragma once

// How fast the web of a job of marks may run under its head, and what is missed above it.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "engrave/mark/mark.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/marks/mark_times.h"

namespace intaglio {

struct WebRun {
  double max_mm_s = 0;
  /// At marks.web.speed_mm_s: places in the order, ascending.
  std::vector<std::size_t> missed;
  MarkTimes times;
  /// With a photo eye: how fast the web may run so that print marks are seen early
  /// enough, which limits max_mm_s too, and how far it runs between that and the first
  /// mark; at or below 0: a print mark is seen too late at any speed.
  std::optional<double> eye_max_mm_s = {};
  double eye_way_mm = 0;
};

/// `ordered` as of OrderJobMarks, `job` with marks on a web. kInvalidValue: there is no
/// speed at which all are made.
Result<WebRun> WebRunOf(const JobSpec& job, const MachineSpec& machine,
                        const mark::MarkSet& ordered);

/// The same of marks that are timed already, as of TimedMarksOf, in their order.
Result<WebRun> WebRunOf(const JobSpec& job, const HeadFigures& head,
                        std::span<const galvo::TimedMark> timed, const MarkTimes& times);

/// How far from where the first mark of a repeat may be begun to the origin of the
/// repeat, along +x of the field, at the least.
double EarliestBeginMm(std::span<const mark::Mark> marks, std::span<const mark::Pen> pens,
                       const HeadFigures& head);

/// What the photo eye of a job's marks changes; nothing without one. `earliest_mm` as of
/// EarliestBeginMm, over all repeats.
void LimitByEye(const JobSpec& job, const ScanHead& head, double earliest_mm,
                WebRun& run);

/// marks.web.speed_mm_s, or that there is none, against the eye. kRefused.
Status CheckEyeWay(const JobSpec& job, const MachineSpec& machine, const WebRun& run);

/// By which print marks its repeats begin, of a job with a photo eye.
std::string PrintMarksText(const JobSpec& job);

/// "item 2 of repeat 17".
std::string NameOfMark(const JobSpec& job, std::span<const mark::Pen> pens,
                       const mark::Mark& mark);

/// Before anything is made. kRefused: marks would be missed at the speed that the job
/// gives, with the largest one. Where it gives none, a note with the largest is added to
/// `warnings`. A job without a web passes.
Status CheckWebRun(const JobSpec& job, const MachineSpec& machine,
                   const mark::MarkSet& ordered, Warnings& warnings);

}  // namespace intaglio
