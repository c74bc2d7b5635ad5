#include "services/job/marks/mark_maker.h"

#include <array>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "services/job/checks/marks_check.h"
#include "services/job/course/course_marks.h"
#include "services/job/marks/dot_rows.h"
#include "services/job/marks/job_marks.h"
#include "services/job/marks/web_run.h"

namespace intaglio {
namespace {

/// What a job may ask for in marks.
struct MarkJobKind {
  bool (*is_of)(const JobSpec& job);
  Result<mark::MarkSet> (*make)(const JobSpec& job, const MachineSpec& machine,
                                std::vector<FileBytes> files, const ReadLimits& limits,
                                Warnings& warnings, const ProgressSink& progress);
  Result<mark::MarkSet> (*order)(const JobSpec& job, const MachineSpec& machine,
                                 mark::MarkSet marks, const ProgressSink& progress);
  std::vector<std::string> (*files)(const JobSpec& job);
};

constexpr std::array kMarkJobKinds = {
    MarkJobKind{[](const JobSpec& job) { return job.has_marks(); }, MakeJobMarks,
                OrderJobMarks, JobMarkFilesOf},
    MarkJobKind{[](const JobSpec& job) { return job.has_course(); }, MakeCourseMarks,
                [](const JobSpec& job, const MachineSpec& machine, mark::MarkSet marks,
                   const ProgressSink&) {
                  return OrderCourseMarks(job, machine, std::move(marks));
                },
                CourseMarkFilesOf},
};

const MarkJobKind& KindOfMarks(const JobSpec& job) {
  for (const MarkJobKind& kind : kMarkJobKinds) {
    if (kind.is_of(job)) return kind;
  }
  throw PreconditionError("a job without marks and course makes no marks");
}

}  // namespace

Result<mark::MarkSet> MakeMarks(const JobSpec& job, const MachineSpec& machine,
                                std::vector<FileBytes> files, const ReadLimits& limits,
                                Warnings& warnings, const ProgressSink& progress) {
  auto marks = INTAGLIO_TRY(
      KindOfMarks(job).make(job, machine, std::move(files), limits, warnings, progress));
  if (marks.marks.empty()) {
    return Fail(ErrorCode::kMissing,
                "the files of the job have nothing to mark: see whether they are empty, "
                "and which layers of them are taken");
  }
  INTAGLIO_TRY(mark::CheckMarks(marks));
  return marks;
}

Result<mark::MarkSet> OrderMarks(const JobSpec& job, const MachineSpec& machine,
                                 mark::MarkSet marks, Warnings& warnings,
                                 const ProgressSink& progress) {
  auto ordered =
      INTAGLIO_TRY(KindOfMarks(job).order(job, machine, std::move(marks), progress));
  INTAGLIO_TRY(CheckWebRun(job, machine, ordered, warnings));
  NoteDotModes(job, machine, warnings);
  return ordered;
}

std::vector<std::string> MarkFilesOf(const JobSpec& job) {
  return KindOfMarks(job).files(job);
}

}  // namespace intaglio
