#include "services/job/checks/mark_job_check.h"

#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <utility>

#include "services/job/checks/course_check.h"
#include "services/job/checks/marks_check.h"
#include "services/job/fields/field_ranges.h"
#include "services/job/fields/job_kind.h"

namespace intaglio {
namespace {

void RefuseFieldsOfPoints(const JobSpec& job, Findings& findings) {
  constexpr const char* kOfPoints[] = {"block",  "glass",          "lens",
                                       "laser",  "discretization", "ordering",
                                       "motion", "channel_blocks"};
  for (const char* name : kOfPoints) {
    const auto* field = JobSpec::descriptor()->FindFieldByName(name);
    const auto& fields = *job.GetReflection();
    const bool given = field->is_repeated() ? fields.FieldSize(job, field) > 0
                                            : fields.HasField(job, field);
    if (!given) continue;
    findings.Wrong(name, "it",
                   "is of points in a block, and this job makes marks; remove it");
  }
}

}  // namespace

Status CheckMakesPoints(const MachineSpec& machine) {
  if (!machine.has_mark_line()) return {};
  return Fail(ErrorCode::kUnsupported,
              fmt::format("machine {}: it makes marks or contours (its profile has a "
                          "mark_line), and these are points in a block: give marks or a "
                          "course in their place, or name a machine that engraves",
                          machine.name()),
              machine.name());
}

std::vector<Finding> CheckMarkJob(const JobSpec& job, const MachineSpec& machine) {
  Findings findings;
  if (!MakesMarks(job)) {
    findings.Wrong(
        "models", job.models_size(),
        "are points in a block, and {} makes marks (its profile has a "
        "mark_line); give marks or a course in their place, or name a machine that "
        "engraves",
        machine.name());
    return std::move(findings.found());
  }
  if (job.machine_file().empty()) {
    findings.Missing("machine_file", "name a machine profile with a mark_line");
  } else if (!machine.has_mark_line()) {
    findings.Wrong("machine_file", machine.name(),
                   "engraves points in a block (its profile has no mark_line), and this "
                   "job makes marks; name a machine that marks or cuts");
  }
  RefuseFieldsOfPoints(job, findings);
  if (job.has_course()) {
    if (machine.has_mark_line() && !machine.has_course_tool()) {
      findings.Wrong("course.files", job.course().files_size(),
                     "files of contours, and {} has no tool that follows them: its "
                     "profile has no course_tool; name the profile of one in "
                     "machine_file, or write a program by `intaglio post`",
                     machine.name());
    }
    for (Finding& found : CheckCourse(job)) findings.found().push_back(std::move(found));
  }
  if (job.has_marks()) {
    for (Finding& found : CheckMarks(job)) findings.found().push_back(std::move(found));
    if (machine.has_mark_line()) {
      for (Finding& found : CheckMarksOnMachine(job, machine))
        findings.found().push_back(std::move(found));
    }
  }
  return std::move(findings.found());
}

}  // namespace intaglio
