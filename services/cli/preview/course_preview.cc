#include "services/cli/preview/course_preview.h"

#include <utility>

#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "services/cli/contour/contour_figures.h"
#include "services/cli/contour/contour_files.h"
#include "services/cli/contour/contour_picture.h"
#include "services/client/preview/preview.h"
#include "services/client/preview/preview_text.h"
#include "services/job/checks/course_check.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/verdict/warnings.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

void AddFigures(const ContourWork& work, const Course& whole, JobPreview& figures) {
  CoursePreview& course = *figures.mutable_course();
  course.set_contour_count(work.paths.size());
  course.set_hole_count(work.hole_count);
  course.set_work_mm(work.work_mm);
  course.set_idle_mm(work.idle_mm + work.drill_idle_mm);
  course.set_tool_diameter_mm(whole.tool_diameter_mm());
  const WorkTime time = TimeOf(work, whole);
  course.set_work_s(time.work_s);
  course.set_idle_s(time.idle_s);
  course.set_drill_s(time.drill_s);
  figures.mutable_time()->set_machining_time_s(time.sum_s());
}

}  // namespace

Result<JobPreview> PreviewCourse(const JobSpec& job, double size_limits,
                                 const fs::path& folder) {
  if (const auto errors = CheckCourse(job); !errors.empty())
    return tl::unexpected(JoinErrors(errors));
  const Course whole = WithDefaults(job.course());
  const Vec2 start_mm(0, 0);
  Warnings warnings;
  const auto made =
      INTAGLIO_TRY(ContoursFromFiles(whole, size_limits, start_mm, warnings));
  const ContourWork& work = made.work;
  JobPreview figures;
  figures.set_name(job.name().empty()
                       ? fs::path(job.course().files(0)).filename().string()
                       : job.name());
  figures.set_machine(fs::path(job.machine_file()).stem().string());
  figures.set_verdict(client::VerdictOf(warnings));
  for (const Warning& warning : warnings) *figures.add_warnings() = RecordOf(warning);
  figures.set_picture(kCoursePicture);
  *figures.mutable_job() = job;
  AddFigures(work, whole, figures);
  INTAGLIO_TRY(client::WriteFigures(folder, figures));
  INTAGLIO_TRY(io::WriteFileAtomically(folder / kCoursePicture,
                                       SvgOf(work, start_mm, whole.tool_diameter_mm())));
  return figures;
}

}  // namespace intaglio::cli
