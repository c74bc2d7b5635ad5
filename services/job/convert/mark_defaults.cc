#include "services/job/convert/mark_defaults.h"

#include <filesystem>
#include <utility>

#include "services/job/convert/v_bit.h"
#include "services/platform/fields/field_defaults.h"

namespace intaglio {
namespace {

void CompletePen(MarkPen& pen, const MarkPen& defaults) {
  MarkPen whole = defaults;
  whole.MergeFrom(pen);
  pen = std::move(whole);
}

void CompleteHatch(MarkHatch& hatch, bool of_code) {
  if (of_code && !hatch.has_contour()) hatch.set_contour(false);
  FillDefaults(hatch);
}

void CompleteContent(MarkItem& item) {
  if (item.has_text()) {
    FillDefaults(*item.mutable_text());
  } else if (item.has_image()) {
    MarkImage& image = *item.mutable_image();
    FillDefaults(image);
    if (!image.has_dot_mm() && image.make() == MARK_IMAGE_MAKE_DOTS)
      image.set_dot_mm(image.distance_mm() / 2);
  } else if (item.has_code()) {
    FillDefaults(*item.mutable_code());
    item.mutable_hatch();
  }
}

void CompleteItem(MarkItem& item, const MarkPen& pen) {
  CompletePen(*item.mutable_pen(), pen);
  CompleteContent(item);
  if (item.has_hatch()) CompleteHatch(*item.mutable_hatch(), item.has_code());
  FillDefaults(*item.mutable_placement());
}

void FillTabs(Course& course) {
  if (!course.has_tab_distance_mm()) FillDefaults(course, {Course::kTabCountFieldNumber});
  FillDefaults(course, {Course::kTabWidthMmFieldNumber});
  if (!course.has_tab_height_mm() && course.has_depth_mm())
    course.set_tab_height_mm(course.depth_mm() / 2);
}

}  // namespace

Marks WithDefaults(Marks marks) {
  FillDefaults(*marks.mutable_pen());
  FillDefaults(marks);
  if (marks.web().has_eye()) FillDefaults(*marks.mutable_web()->mutable_eye());
  for (MarkItem& item : *marks.mutable_items()) CompleteItem(item, marks.pen());
  return marks;
}

Course WithDefaults(Course course) {
  if (!course.has_power_ratio()) FillDefaults(course, {Course::kDepthMmFieldNumber});
  if (IsVBit(course) && !course.has_tool_diameter_mm())
    course.set_tool_diameter_mm(WidthOfVBit(course, course.depth_mm()));
  FillDefaults(course,
               {Course::kToolDiameterMmFieldNumber, Course::kSpeedMmSFieldNumber,
                Course::kTravelMmSFieldNumber, Course::kRepeatCountFieldNumber,
                Course::kSafeHeightMmFieldNumber, Course::kDrillDepthMmFieldNumber});
  const bool isolates = course.make() == COURSE_MAKE_ISOLATION;
  if (isolates) FillDefaults(course, {Course::kPassCountFieldNumber});
  const bool clears = course.make() == COURSE_MAKE_POCKET;
  if (isolates || clears) FillDefaults(course, {Course::kOverlapRatioFieldNumber});
  if (!course.has_plunge_mm_s()) course.set_plunge_mm_s(course.speed_mm_s());
  if (!isolates && !clears) FillTabs(course);
  return course;
}

JobSpec WithMarkDefaults(JobSpec job) {
  if (job.has_marks()) {
    const Marks marks = WithDefaults(job.marks());
    *job.mutable_marks() = marks;
    if (job.name().empty()) job.set_name("marks");
  }
  if (job.has_course()) {
    const Course course = WithDefaults(job.course());
    *job.mutable_course() = course;
  }
  if (job.name().empty() && job.course().files_size() > 0) {
    job.set_name(std::filesystem::path(job.course().files(0)).filename().string());
  }
  return job;
}

}  // namespace intaglio
