#include "services/job/marks/job_marks.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "engrave/mark/jump_order.h"
#include "services/job/checks/marks_check.h"
#include "services/job/convert/model_kind.h"
#include "services/job/head/head_correction.h"
#include "services/job/machine/head_ticks.h"
#include "services/job/marks/repeat_marks.h"

namespace intaglio {

std::vector<std::string> JobMarkFilesOf(const JobSpec& job) {
  JobSpec marks;
  *marks.mutable_marks() = job.marks();
  std::vector<std::string> files;
  ForEachFile(marks,
              [&](std::string& file, const std::string&) { files.push_back(file); });
  return files;
}

Result<std::vector<FileBytes>> ReadJobMarkFiles(const JobSpec& job,
                                                const ReadLimits& limits) {
  std::vector<FileBytes> files;
  for (const std::string& name : JobMarkFilesOf(job)) {
    const auto text = io::ReadWholeFile(name, limits.max_file_bytes);
    if (!text) return tl::unexpected(WithRemedy(text.error(), limits));
    const auto bytes = std::as_bytes(std::span(*text));
    files.emplace_back(bytes.begin(), bytes.end());
  }
  return files;
}

Result<mark::MarkSet> MakeJobMarks(const JobSpec& job, const MachineSpec& machine,
                                   std::vector<FileBytes> files, const ReadLimits& limits,
                                   Warnings& warnings, const ProgressSink& progress) {
  auto repeats = INTAGLIO_TRY(RepeatMarks::Open(job, machine, std::move(files), limits));
  mark::MarkSet made{repeats.pens(), {}};
  for (std::size_t k = 0; k < repeats.count(); ++k) {
    if (progress && !progress(k, repeats.count()))
      return Fail(ErrorCode::kCancelled, "the making of marks was cancelled");
    auto marks = INTAGLIO_TRY(repeats.Make(k, warnings));
    INTAGLIO_TRY(repeats.CheckCount(made.marks.size() + marks.size()));
    std::ranges::move(marks, std::back_inserter(made.marks));
  }
  INTAGLIO_TRY(mark::CheckMarks(made));
  return made;
}

HeadFigures HeadFiguresOf(const MachineSpec& machine) {
  const ScanHead& head = machine.scan_head();
  HeadFigures figures;
  if (head.field_mm() > 0) {
    // A sorter on another computer than the head's may not have the file: it plans with
    // the whole field, and the head's driver refuses what it cannot reach.
    figures.window = WindowOf(head).value_or(galvo::FieldWindow(head.field_mm()));
  }
  const double jump_mm_s = figures.ticks.jump_mm_s;
  figures.ticks = TickOptionsOf(head, mark::Pen(), figures.ticks.rate_hz);
  if (!(head.jump_mm_s() > 0)) figures.ticks.jump_mm_s = jump_mm_s;
  return figures;
}

bool MayReverse(const JobSpec& job) {
  return std::ranges::none_of(job.marks().items(), [](const MarkItem& item) {
    const bool hatch_keeps = item.has_hatch() && item.hatch().has_bidirectional() &&
                             !item.hatch().bidirectional();
    return hatch_keeps ||
           (item.image().has_bidirectional() && !item.image().bidirectional());
  });
}

Result<mark::MarkSet> OrderJobMarks(const JobSpec& job, const MachineSpec& machine,
                                    mark::MarkSet marks, const ProgressSink& progress) {
  const HeadFigures head = HeadFiguresOf(machine);
  if (job.marks().has_web())
    return OrderForWeb(std::move(marks), head, MayReverse(job), progress);
  INTAGLIO_TRY(CheckField(marks, false, head));
  marks.marks =
      mark::OrderByJumps(std::move(marks.marks), {Vec2::Zero(), MayReverse(job)});
  return marks;
}

}  // namespace intaglio
