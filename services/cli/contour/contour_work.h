#pragma once

// What a tool does for a course: contours in their order, and holes by tool. Frame: that
// of the files, mm.

#include <optional>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/post/cutting.h"
#include "engrave/post/drill_program.h"
#include "engrave/post/tool_path.h"
#include "proto/job.pb.h"
#include "services/cli/contour/contour_files.h"

namespace intaglio::cli {

struct ContourWork {
  std::vector<post::ToolPath> paths;     ///< in their order
  std::vector<int> passes;               ///< of each path its pass, from 0
  std::vector<post::DrillRound> rounds;  ///< by growing diameter
  std::vector<contour::Edges> copper;    ///< outlines of what the files hold
  std::size_t element_count = 0, hole_count = 0;
  std::optional<std::size_t> net_count;  ///< of an isolation
  /// Of boards whose file has the nets: how many the copper that is left has, all of them
  /// as drawn.
  std::optional<std::size_t> proved_net_count;
  double left_mm2 = 0;     ///< of pockets: corners and necks that stay
  double isolated_mm = 0;  ///< width that is cut around the copper
  double work_mm = 0, idle_mm = 0, drill_idle_mm = 0;
  double nearest_idle_mm = 0;  ///< of the published order, contours
};

/// `course` with its defaults filled in. `start_mm`: where the tool comes from. Errors as
/// of Isolate, Unite and OutlinesOf, each with the place.
Result<ContourWork> MakeContourWork(const Course& course, const CourseFiles& files,
                                    const Vec2& start_mm);

/// Speeds, depths and power of a course; `given` by which of its fields are set in
/// `typed`, the course without its defaults.
post::Cutting MillingOf(const Course& whole, const Course& typed);
post::Cutting DrillingOf(const Course& whole, const Course& typed);

/// How long it takes at these speeds, without acceleration, s. Idle ways include those up
/// and down.
struct WorkTime {
  double work_s = 0, idle_s = 0, drill_s = 0;
  double sum_s() const { return work_s + idle_s + drill_s; }
};
WorkTime TimeOf(const ContourWork& work, const Course& whole);

/// Lines of name and value.
std::vector<std::string> FiguresOf(const ContourWork& work, const Course& whole);

}  // namespace intaglio::cli
