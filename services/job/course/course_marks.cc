#include "services/job/course/course_marks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/machine/clearance.h"
#include "engrave/post/tab_parts.h"
#include "services/job/checks/marks_check.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/course/course_files.h"
#include "services/job/course/course_work.h"
#include "services/job/machine/course_tool.h"
#include "services/job/plan/course_motion.h"

namespace intaglio {
namespace {

using std::numbers::pi;
/// Ends of a path that are one place.
constexpr double kClosed_mm = 1e-6;
/// A bulge of more is no longer exact: such arcs are divided.
constexpr double kLargestSweep_rad = pi;

/// The way that `move` makes from the last place of `mark`, and its end.
void AddMove(const post::WorkMove& move, mark::Mark& mark) {
  if (move.kind == post::WorkKind::kLine) {
    mark.places.push_back({move.end_mm});
    return;
  }
  const double sign = move.kind == post::WorkKind::kCounterClockwise ? 1 : -1;
  const int parts = static_cast<int>(std::ceil(move.sweep_rad / kLargestSweep_rad));
  const double sweep_rad = sign * move.sweep_rad / std::max(parts, 1);
  const Vec2 from_center_mm = -move.center_from_begin_mm;
  const Vec2 center_mm = mark.places.back().at_mm + move.center_from_begin_mm;
  for (int i = 1; i <= parts; ++i) {
    mark.places.back().bulge = std::tan(sweep_rad / 4);
    const Vec2 turned = Eigen::Rotation2Dd(i * sweep_rad) * from_center_mm;
    mark.places.push_back({i == parts ? move.end_mm : Vec2(center_mm + turned)});
  }
}

mark::Mark MarkOfPath(const post::ToolPath& path, std::uint32_t pen) {
  mark::Mark mark;
  mark.pen = pen;
  mark.places.push_back({path.begin_mm});
  for (const post::WorkMove& move : path.moves) AddMove(move, mark);
  const bool returns =
      (mark.places.back().at_mm - mark.places.front().at_mm).norm() < kClosed_mm;
  if (returns && mark.places.size() > 2) {
    mark.places.pop_back();
    mark.closed = true;
  }
  return mark;
}

mark::Mark CircleOf(const Vec2& center_mm, double diameter_mm, std::uint32_t pen) {
  const Vec2 to_side_mm(diameter_mm / 2, 0);
  mark::Mark mark;
  mark.pen = pen;
  mark.closed = true;
  mark.places = {{center_mm + to_side_mm, 1}, {center_mm - to_side_mm, 1}};
  return mark;
}

mark::Pen ContourPen(const Course& course) {
  mark::Pen pen;
  pen.name = "contours";
  pen.speed_mm_s = course.speed_mm_s();
  pen.pass_count = course.repeat_count();
  if (course.has_power_ratio()) {
    pen.power_ratio = course.power_ratio();
    return pen;
  }
  pen.depth_mm = course.depth_mm();
  pen.plunge_mm_s = course.plunge_mm_s();
  return pen;
}

/// The pen of one pass at that depth, of contours; made when there is none.
std::uint32_t PenAtDepth(const Course& course, double depth_mm, mark::MarkSet& set) {
  for (std::size_t i = 1; i < set.pens.size(); ++i)
    if (set.pens[i].depth_mm == depth_mm) return static_cast<std::uint32_t>(i);
  mark::Pen pen = ContourPen(course);
  pen.name = fmt::format("contours, {:g} mm deep", depth_mm);
  pen.pass_count = 1;
  pen.depth_mm = depth_mm;
  set.pens.push_back(std::move(pen));
  return static_cast<std::uint32_t>(set.pens.size() - 1);
}

/// Adds what is left of a path with tabs in each pass; of others one mark of all passes.
void AddPath(const post::ToolPath& path, const Course& course, mark::MarkSet& set) {
  if (!post::HasTabs(path)) {
    set.marks.push_back(MarkOfPath(path, 0));
    return;
  }
  const post::Cutting cutting = PassesOf(course);
  for (std::size_t pass = 0; pass < cutting.depths_mm.size(); ++pass) {
    for (const post::PathPart& part : post::PartsOfPass(path, cutting, pass))
      set.marks.push_back(MarkOfPath(part.path, PenAtDepth(course, -part.depth_mm, set)));
  }
}

mark::Pen DrillPen(const Course& course, double diameter_mm) {
  mark::Pen pen;
  pen.name = fmt::format("holes of {:g} mm", diameter_mm);
  pen.speed_mm_s = course.speed_mm_s();
  pen.depth_mm = course.drill_depth_mm();
  pen.plunge_mm_s = course.plunge_mm_s();
  return pen;
}

Status CheckToolOfMachine(const Course& course, const MachineSpec& machine) {
  const CourseToolKind kind = machine.course_tool().kind();
  if (kind == COURSE_TOOL_LASER && !course.has_power_ratio()) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("course.power_ratio: is missing; the tool of {} is a laser: "
                            "give its power, 0..1, in place of a depth",
                            machine.name()));
  }
  if (SwitchesBeamOnly(machine) && course.has_power_ratio() &&
      course.power_ratio() != 1) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("course.power_ratio: {:g}: the output of {} is on or off; "
                            "give 1, and set the power at the laser",
                            course.power_ratio(), machine.name()),
                fmt::format("{:g}", course.power_ratio()));
  }
  if (SwitchesBeamOnly(machine) && course.speed_mm_s() > CourseFeedOf(machine)) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("course.speed_mm_s: {:g} is more than the {:g} mm/s of the "
                            "axes x and y of {}; reduce it",
                            course.speed_mm_s(), CourseFeedOf(machine), machine.name()),
                fmt::format("{:g}", course.speed_mm_s()));
  }
  if (kind == COURSE_TOOL_SPINDLE && course.has_power_ratio()) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("course.power_ratio: {:g} is of a laser, and {} has a "
                            "spindle: give depth_mm in its place",
                            course.power_ratio(), machine.name()),
                fmt::format("{:g}", course.power_ratio()));
  }
  const double safe_mm = SafeHeightOf(machine.course_tool());
  if (kind == COURSE_TOOL_SPINDLE && course.safe_height_mm() > safe_mm) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("course.safe_height_mm: {:g} is more than the {:g} mm of "
                            "course_tool.safe_height_mm of {}, which it moves at; reduce "
                            "it, or raise that of the profile",
                            course.safe_height_mm(), safe_mm, machine.name()),
                fmt::format("{:g}", course.safe_height_mm()));
  }
  return {};
}

/// What is wider than the tool stays above the sheet, whose face is at 0 (the room of
/// engrave/machine/clearance.h, with the tip in the place of the focus).
Status CheckFreeLength(const mark::MarkSet& set, const MachineSpec& machine) {
  const CourseTool& tool = machine.course_tool();
  if (tool.kind() != COURSE_TOOL_SPINDLE || !tool.has_free_length_mm()) return {};
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const Box3 sheet{Vec3::Constant(-kInfinite), Vec3(kInfinite, kInfinite, 0)};
  const machine::Clearance clearance({{tool.free_length_mm()}}, {sheet});
  for (const mark::Pen& pen : set.pens) {
    const auto collision = clearance.At(Vec3(0, 0, -pen.depth_mm));
    if (!collision) continue;
    return Fail(ErrorCode::kOutsideBlock,
                fmt::format("{}: {:g} mm deep, the spindle of {} would be {:.2f} mm "
                            "inside the sheet, for its tool is free over {:g} mm "
                            "(course_tool.free_length_mm); make them less deep, or let "
                            "the tool stand out further",
                            pen.name, pen.depth_mm, machine.name(), collision->overlap_mm,
                            tool.free_length_mm()),
                fmt::format("{:g}", pen.depth_mm));
  }
  return {};
}

/// A spindle holds one tool.
Status RequireOneTool(const ContourWork& work) {
  const std::size_t tools = work.rounds.size() + (work.paths.empty() ? 0 : 1);
  if (tools <= 1) return {};
  std::vector<double> diameters_mm;
  for (const post::DrillRound& round : work.rounds)
    diameters_mm.push_back(round.diameter_mm);
  return Fail(
      ErrorCode::kUnsupported,
      fmt::format("course.drill_diameter_mm: is missing; the files hold the work of {} "
                  "tools{} and holes of {:g} mm, and a job on a machine is that of one: "
                  "give one of these diameters for its holes{}",
                  tools, work.paths.empty() ? "," : ", contours",
                  fmt::join(diameters_mm, ", "),
                  work.paths.empty() ? "" : ", or 0 for the contours"));
}

Status AddCutHoles(const Course& course, const ContourWork& work, mark::MarkSet& set) {
  for (const post::DrillRound& round : work.rounds) {
    const double diameter_mm = round.diameter_mm - course.tool_diameter_mm();
    if (!(diameter_mm > 0)) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("course.tool_diameter_mm: a kerf of {:g} mm cuts no holes "
                              "of {:g} mm; correct it",
                              course.tool_diameter_mm(), round.diameter_mm),
                  fmt::format("{:g}", course.tool_diameter_mm()));
    }
    for (const Vec2& place_mm : round.places_mm)
      set.marks.push_back(CircleOf(place_mm, diameter_mm, 0));
  }
  return {};
}

void AddDrilledHoles(const Course& course, const ContourWork& work, mark::MarkSet& set) {
  for (const post::DrillRound& round : work.rounds) {
    const auto pen = static_cast<std::uint32_t>(set.pens.size());
    set.pens.push_back(DrillPen(course, round.diameter_mm));
    for (const Vec2& place_mm : round.places_mm) {
      mark::Mark hole;
      hole.pen = pen;
      hole.places.push_back({place_mm});
      set.marks.push_back(std::move(hole));
    }
  }
}

std::vector<std::string_view> TextsOf(const std::vector<FileBytes>& files) {
  std::vector<std::string_view> texts;
  for (const FileBytes& file : files)
    texts.emplace_back(reinterpret_cast<const char*>(file.data()), file.size());
  return texts;
}

Status Report(const ProgressSink& progress, std::uint64_t done) {
  if (!progress || progress(done, 3)) return {};
  return Fail(ErrorCode::kCancelled, "the making of the contours was cancelled");
}

}  // namespace

std::vector<std::string> CourseMarkFilesOf(const JobSpec& job) {
  return {job.course().files().begin(), job.course().files().end()};
}

Result<mark::MarkSet> MakeCourseMarks(const JobSpec& job, const MachineSpec& machine,
                                      std::vector<FileBytes> files,
                                      const ReadLimits& limits, Warnings& warnings,
                                      const ProgressSink& progress) {
  const Course course = WithDefaults(job.course());
  INTAGLIO_TRY(CheckToolOfMachine(course, machine));
  const CourseFiles read =
      INTAGLIO_TRY(CourseFilesOf(course, TextsOf(files), limits, warnings));
  INTAGLIO_TRY(Report(progress, 1));
  const ContourWork work = INTAGLIO_TRY(MakeContourWork(course, read, Vec2::Zero()));
  INTAGLIO_TRY(Report(progress, 2));
  mark::MarkSet set;
  const bool laser = course.has_power_ratio();
  if (!work.paths.empty() || laser) set.pens.push_back(ContourPen(course));
  // Holes of a laser first: they are in the parts that contours cut loose.
  if (laser) {
    INTAGLIO_TRY(AddCutHoles(course, work, set));
  } else {
    INTAGLIO_TRY(RequireOneTool(work));
  }
  for (const post::ToolPath& path : work.paths) AddPath(path, course, set);
  if (!laser) AddDrilledHoles(course, work, set);
  INTAGLIO_TRY(mark::CheckMarks(set));
  INTAGLIO_TRY(CheckFreeLength(set, machine));
  INTAGLIO_TRY(Report(progress, 3));
  return set;
}

Result<mark::MarkSet> OrderCourseMarks(const JobSpec&, const MachineSpec&,
                                       mark::MarkSet marks) {
  INTAGLIO_TRY(mark::CheckMarks(marks));
  return marks;
}

}  // namespace intaglio
