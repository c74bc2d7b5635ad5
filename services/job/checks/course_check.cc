#include "services/job/checks/course_check.h"

#include <cmath>
#include <filesystem>
#include <utility>

#include "services/job/convert/mark_defaults.h"
#include "services/job/convert/v_bit.h"
#include "services/job/fields/field_ranges.h"
#include "services/platform/fields/field_defaults.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;

constexpr double kSameWidth_mm = 1e-6;

void CheckCourseFiles(const Course& course, Findings& findings) {
  if (course.files().empty()) {
    findings.Missing("course.files", "name a circuit board or a drawing");
  }
  for (int i = 0; i < course.files_size(); ++i) {
    std::error_code error;
    if (fs::is_regular_file(course.files(i), error)) continue;
    findings.Wrong(fmt::format("course.files[{}]", i), course.files(i),
                   "does not exist or is not a file");
  }
}

void CheckTool(const Course& course, Findings& findings) {
  if (course.has_power_ratio() && course.has_depth_mm()) {
    findings.Wrong("course.depth_mm", course.depth_mm(),
                   "excludes course.power_ratio; a laser has a power and no depth");
  }
  const bool isolates = course.make() == COURSE_MAKE_ISOLATION;
  if (!isolates && course.has_pass_count()) {
    findings.Wrong("course.pass_count", course.pass_count(),
                   "is of isolations; remove it, or make an isolation");
  }
  if (!isolates && course.make() != COURSE_MAKE_POCKET && course.has_overlap_ratio()) {
    findings.Wrong("course.overlap_ratio", course.overlap_ratio(),
                   "is of isolations and pockets; remove it, or make one of these");
  }
  if (course.make() != COURSE_MAKE_CUT && (course.has_lead_mm() || course.inside())) {
    findings.Wrong("course.lead_mm", course.lead_mm(),
                   "and course.inside are of cuts; remove them, or make a cut");
  }
}

/// A service checks a job whose diameter a client has filled in.
void CheckVBit(const Course& course, Findings& findings) {
  if (!course.has_tip_mm() && !course.has_tool_angle_deg()) return;
  if (!IsVBit(course)) {
    findings.Missing(course.has_tip_mm() ? "course.tool_angle_deg" : "course.tip_mm",
                     "give it, since a V-shaped tool has a tip and an angle");
    return;
  }
  if (course.has_power_ratio()) {
    findings.Wrong("course.tip_mm", course.tip_mm(),
                   "is of mills, and power_ratio of lasers; remove one of them");
    return;
  }
  const NumberRange range = RangeOf<Course>(Course::kToolDiameterMmFieldNumber);
  const Course whole = WithDefaults(course);
  const double width_mm = WidthOfVBit(whole, whole.depth_mm());
  if (std::abs(whole.tool_diameter_mm() - width_mm) > kSameWidth_mm) {
    findings.Wrong(
        "course.tool_diameter_mm", course.tool_diameter_mm(),
        "is not what a tip of {:g} mm and {:g} degrees cut at {:g} mm, {:.4g}; "
        "remove it",
        course.tip_mm(), course.tool_angle_deg(), whole.depth_mm(), width_mm);
  } else if (width_mm < range.min || width_mm > range.max) {
    findings.Wrong(
        "course.depth_mm", whole.depth_mm(),
        "makes the cut of the V-shaped tool {:.4g} mm wide, outside {:g}..{:g}", width_mm,
        range.min, range.max);
  }
}

void CheckTabs(const Course& course, Findings& findings) {
  const bool asked = course.has_tab_count() || course.has_tab_distance_mm();
  if (course.has_tab_count() && course.has_tab_distance_mm()) {
    findings.Wrong("course.tab_distance_mm", course.tab_distance_mm(),
                   "excludes course.tab_count; give one of them");
  }
  if (asked &&
      (course.make() == COURSE_MAKE_ISOLATION || course.make() == COURSE_MAKE_POCKET)) {
    findings.Wrong(course.has_tab_count() ? "course.tab_count" : "course.tab_distance_mm",
                   course.has_tab_count() ? course.tab_count() : course.tab_distance_mm(),
                   "is of cuts, outlines and curves; remove it, or make one of these");
  }
  if (!asked && (course.has_tab_width_mm() || course.has_tab_height_mm())) {
    findings.Missing("course.tab_count",
                     "give it or tab_distance_mm, since tabs have a width or a height");
  }
  if (!course.has_tab_height_mm()) return;
  if (course.has_power_ratio()) {
    findings.Wrong("course.tab_height_mm", course.tab_height_mm(),
                   "is of mills; a laser leaves tabs whole: remove it");
  } else if (course.tab_height_mm() > WithDefaults(course).depth_mm()) {
    findings.Wrong("course.tab_height_mm", course.tab_height_mm(),
                   "is more than depth_mm, {}", WithDefaults(course).depth_mm());
  }
}

}  // namespace

std::vector<Finding> CheckCourse(const JobSpec& job) {
  Findings findings;
  CheckRanges(job.course(), "course", findings.found());
  if (!CourseMake_IsValid(job.course().make())) {
    findings.Wrong("course.make", static_cast<int>(job.course().make()), "is none, 0..{}",
                   static_cast<int>(CourseMake_MAX));
  }
  if (!job.models().empty()) {
    findings.Wrong("models", job.models_size(),
                   "are given beside course; make a job of each");
  }
  CheckCourseFiles(job.course(), findings);
  CheckTool(job.course(), findings);
  CheckVBit(job.course(), findings);
  CheckTabs(job.course(), findings);
  return std::move(findings.found());
}

std::vector<Finding> RefuseCourse(const JobSpec& job) {
  Findings findings;
  if (job.has_course()) {
    findings.Wrong("course", job.course().files_size(),
                   "files of contours, and this makes points in a block: play such a job "
                   "by intaglio contour JOB --page FILE, write its program by intaglio "
                   "post JOB --template NAME --out FILE, make it on a virtual mill by "
                   "intaglio run JOB, or submit it to a shop with a mill or a laser "
                   "cutter");
  }
  return std::move(findings.found());
}

}  // namespace intaglio
