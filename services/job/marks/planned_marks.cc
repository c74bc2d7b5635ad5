#include "services/job/marks/planned_marks.h"

#include <algorithm>
#include <map>
#include <span>
#include <utility>

#include "engrave/core/try.h"
#include "services/job/marks/job_marks.h"
#include "services/job/marks/timed_mark.h"

namespace intaglio {
namespace {

// Repeats that are made at the same time, whatever does it, and how many each makes until
// they are taken over: enough that none waits for long, and few in memory.
constexpr std::size_t kLanes = 8, kRepeatsOfLane = 16;

/// What is kept of a repeat until it is added to the plan.
struct RepeatFigures {
  std::vector<MeasuredMark> marks;
  std::vector<std::size_t> counts, way_counts;  // of each pen
  bool fits = true;                             // into the field
};

RepeatFigures FiguresOf(std::span<const mark::Mark> marks,
                        std::span<const mark::Pen> pens, const HeadFigures& head) {
  RepeatFigures figures{MeasureAll(marks, pens, head),
                        std::vector<std::size_t>(pens.size()),
                        std::vector<std::size_t>(pens.size())};
  for (const mark::Mark& mark : marks) {
    ++figures.counts[mark.pen];
    figures.way_counts[mark.pen] += mark::LitWayCount(mark);
  }
  figures.fits = std::ranges::all_of(figures.marks, [](const MeasuredMark& mark) {
    return mark.extent.made_at.width_mm() > 0;
  });
  return figures;
}

}  // namespace

PlannedMarks::PlannedMarks(const JobSpec& job, const MachineSpec& machine)
    : head_(HeadFiguresOf(machine)),
      may_reverse_(MayReverse(job)),
      pitch_mm_(job.marks().repeats().pitch_mm()) {}

Result<PlannedMarks> PlannedMarks::Make(const JobSpec& job, const MachineSpec& machine,
                                        std::vector<FileBytes> files,
                                        const ReadLimits& limits,
                                        const Executor& executor, Warnings& warnings,
                                        const PlanningProgress& progress) {
  PlannedMarks planned(job, machine);
  if (job.marks().has_web()) {
    planned.repeats_.emplace(
        INTAGLIO_TRY(RepeatMarks::Open(job, machine, std::move(files), limits)));
    INTAGLIO_TRY(planned.PlanWeb(job, machine.scan_head(), executor, warnings, progress));
  } else {
    INTAGLIO_TRY(
        planned.PlanAtRest(job, machine, std::move(files), limits, warnings, progress));
  }
  return planned;
}

Status PlannedMarks::PlanAtRest(const JobSpec& job, const MachineSpec& machine,
                                std::vector<FileBytes> files, const ReadLimits& limits,
                                Warnings& warnings, const PlanningProgress& progress) {
  auto made = INTAGLIO_TRY(
      MakeJobMarks(job, machine, std::move(files), limits, warnings, progress.made));
  auto ordered = INTAGLIO_TRY(OrderJobMarks(job, machine, std::move(made)));
  times_ = TimesOf(ordered, head_);
  pens_ = std::move(ordered.pens);
  marks_ = std::move(ordered.marks);
  mark_count_ = marks_.size();
  counts_.resize(pens_.size());
  way_counts_.resize(pens_.size());
  for (const mark::Mark& mark : marks_) {
    ++counts_[mark.pen];
    way_counts_[mark.pen] += mark::LitWayCount(mark);
  }
  return {};
}

Result<std::vector<mark::Mark>> PlannedMarks::OrderedRepeat(RepeatMarks& repeats,
                                                            std::size_t repeat,
                                                            Warnings& warnings) const {
  mark::MarkSet made{repeats.pens(), {}};
  made.marks = INTAGLIO_TRY(repeats.Make(repeat, warnings));
  INTAGLIO_TRY(mark::CheckMarks(made));
  return OrderRepeat(std::move(made.marks), may_reverse_);
}

Status PlannedMarks::CheckRepeat(std::size_t repeat, std::size_t first) {
  Warnings ignored;
  const auto marks = INTAGLIO_TRY(repeats_->Make(repeat, ignored));
  return CheckField(marks, first, pens_, true, head_);
}

Status PlannedMarks::PlanWeb(const JobSpec& job, const ScanHead& head,
                             const Executor& executor, Warnings& warnings,
                             const PlanningProgress& progress) {
  double earliest_mm = std::numeric_limits<double>::infinity();
  RepeatMarks& repeats = *repeats_;
  pens_ = repeats.pens();
  counts_.resize(pens_.size());
  way_counts_.resize(pens_.size());
  // What is the same in all repeats is made before there are several to make it.
  INTAGLIO_TRY(repeats.Make(0, warnings));
  std::vector<RepeatMarks> lanes;
  for (std::size_t i = 0; i < kLanes; ++i) lanes.push_back(repeats.Another());
  WebPlan plan(head_, WebPlan::Keeps::kTimes);
  for (std::size_t begin = 0; begin < repeats.count(); begin += kLanes * kRepeatsOfLane) {
    if (progress.made && !progress.made(begin, repeats.count()))
      return Fail(ErrorCode::kCancelled, "the making of marks was cancelled");
    const std::size_t end = std::min(repeats.count(), begin + kLanes * kRepeatsOfLane);
    std::vector<Result<RepeatFigures>> made(end - begin);
    RunEach(executor, kLanes, [&](std::size_t lane) {
      Warnings ignored;  // of what repeats they were found already
      for (std::size_t k = begin + lane; k < end; k += kLanes) {
        const auto marks = OrderedRepeat(lanes[lane], k, ignored);
        made[k - begin] = marks ? Result<RepeatFigures>(FiguresOf(*marks, pens_, head_))
                                : tl::unexpected(marks.error());
      }
    });
    for (std::size_t k = begin; k < end; ++k) {
      const auto& figures = made[k - begin];
      if (!figures) return tl::unexpected(figures.error());
      if (!figures->fits) INTAGLIO_TRY(CheckRepeat(k, plan.mark_count()));
      plan.Add(figures->marks);
      for (const MeasuredMark& mark : figures->marks) {
        earliest_mm = std::min(earliest_mm, mark.extent.made_at.from_mm -
                                                static_cast<double>(k) * pitch_mm_);
      }
      for (std::size_t i = 0; i < pens_.size(); ++i) {
        counts_[i] += figures->counts[i];
        way_counts_[i] += figures->way_counts[i];
      }
      repeat_ends_.push_back(plan.mark_count());
      INTAGLIO_TRY(repeats.CheckCount(plan.mark_count()));
    }
  }
  mark_count_ = plan.mark_count();
  ranges_ = INTAGLIO_TRY(plan.Order(progress.ordered));
  const auto timed = plan.TakeTimes(times_);
  web_ = WebRunOf(job, head_, timed, times_);
  if (*web_) LimitByEye(job, head, earliest_mm, **web_);
  return {};
}

Status PlannedMarks::ForEach(
    const std::function<bool(std::size_t number, const mark::Mark&)>& each,
    double max_web_mm) {
  for (std::size_t i = 0; i < marks_.size(); ++i)
    if (marks_[i].web_mm <= max_web_mm && !each(i, marks_[i])) return {};
  Warnings ignored;  // they were found when the marks were planned
  // From a repeat's first mark in this order to its last.
  struct Open {
    std::vector<mark::Mark> marks;
    std::size_t left = 0;
  };
  std::map<std::size_t, Open> open;
  std::size_t number = 0;
  for (const MarkRange& range : ranges_) {
    const auto of = std::ranges::upper_bound(repeat_ends_, range.first);
    const auto repeat = static_cast<std::size_t>(of - repeat_ends_.begin());
    const std::size_t first = repeat == 0 ? 0 : repeat_ends_[repeat - 1];
    if (static_cast<double>(repeat) * pitch_mm_ <= max_web_mm) {
      const auto [at, is_new] = open.try_emplace(repeat);
      if (is_new) {
        at->second.marks = INTAGLIO_TRY(OrderedRepeat(*repeats_, repeat, ignored));
        at->second.left = *of - first;
      }
      for (std::size_t i = 0; i < range.count; ++i)
        if (!each(number + i, at->second.marks[range.first - first + i])) return {};
      at->second.left -= range.count;
      if (at->second.left == 0) open.erase(at);
    }
    number += range.count;
  }
  return {};
}

}  // namespace intaglio
