#include "services/cli/galvo/drawing_strokes.h"

#include "engrave/core/try.h"
#include "services/cli/course/course_job.h"
#include "services/cli/flags/size_limits_flag.h"
#include "services/cli/terminal/complain.h"

namespace intaglio::cli {
namespace {

constexpr double kAnyFeedMmS = 1;  // strokes have no speed of their own

}  // namespace

void AddDrawingOptions(command_line::Command command, DrawingOptions& options) {
  command.AddOption("FILE", options.file, "drawing: .dxf, .svg, .hpgl, .plt or .nci")
      .Require();
  command.AddOption("--mark-speed", options.mark_mm_s, "mm/s with the laser on")
      .Within(0.1, 1e5)
      .ShowDefault();
  command.AddOption("--jump-speed", options.jump_mm_s, "mm/s with the laser off")
      .Within(0.1, 1e6)
      .ShowDefault();
  AddSizeLimitsFlag(command, options.size_limits);
}

Result<std::vector<galvo::MarkStroke>> ReadMarkStrokes(const DrawingOptions& options) {
  Warnings warnings;
  const auto paths = INTAGLIO_TRY(
      ReadContours(options.file, kAnyFeedMmS, options.size_limits, warnings));
  PrintWarningLines(warnings);
  std::vector<galvo::MarkStroke> strokes;
  Box3 box;
  for (const course::Path& path : paths) {
    galvo::MarkStroke stroke;
    for (std::size_t node = 0; node < path.node_count(); ++node)
      stroke.points_mm.push_back(path.node_mm(node));
    stroke.closed = stroke.points_mm.size() > 2 &&
                    stroke.points_mm.front() == stroke.points_mm.back();
    if (stroke.closed) stroke.points_mm.pop_back();
    box.Extend(ExtentOfStroke(stroke));
    strokes.push_back(std::move(stroke));
  }
  if (strokes.empty())
    return Fail(ErrorCode::kMissing, options.file + ": has no contour to mark; draw one",
                options.file);
  const Vec2 middle_mm = box.center_mm().head<2>();
  for (galvo::MarkStroke& stroke : strokes)
    for (Vec2& point_mm : stroke.points_mm) point_mm -= middle_mm;
  return strokes;
}

Box3 ExtentOfStroke(const galvo::MarkStroke& stroke) {
  Box3 box;
  for (const Vec2& p : stroke.points_mm) box.Extend(Vec3(p.x(), p.y(), 0));
  return box;
}

double LengthOfStroke(const galvo::MarkStroke& stroke) {
  const std::vector<Vec2> outline = OutlineOf(stroke);
  double length_mm = 0;
  for (std::size_t i = 1; i < outline.size(); ++i)
    length_mm += (outline[i] - outline[i - 1]).norm();
  return length_mm;
}

std::vector<Vec2> OutlineOf(const galvo::MarkStroke& stroke) {
  std::vector<Vec2> outline = stroke.points_mm;
  if (stroke.closed) outline.push_back(outline.front());
  return outline;
}

}  // namespace intaglio::cli
