#pragma once

// What a tool does for a course: contours in their order, and holes by tool. Frame: that
// of the files, mm.

#include <optional>
#include <string>
#include <vector>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/post/cutting.h"
#include "engrave/post/drill_program.h"
#include "engrave/post/tool_path.h"
#include "proto/job.pb.h"
#include "services/job/course/course_files.h"

namespace intaglio {

struct ContourWork {
  std::vector<post::ToolPath> paths;     ///< in their order
  std::vector<int> passes;               ///< of each path its pass, from 0
  std::vector<post::DrillRound> rounds;  ///< by growing diameter
  std::vector<contour::Edges> copper;    ///< outlines of what the files hold
  std::size_t element_count = 0, hole_count = 0;
  std::optional<std::size_t> net_count;  ///< of an isolation
  std::size_t piece_count = 0;           ///< of copper that an isolation leaves
  /// Of boards whose file has the nets: how many the copper that is left has, all of them
  /// as drawn.
  std::optional<std::size_t> proved_net_count;
  double left_mm2 = 0;         ///< of pockets: corners and necks that stay
  double left_at_wall_mm = 0;  ///< of pockets: how wide that may be along the walls
  double isolated_mm = 0;      ///< width that is cut around the copper
  double work_mm = 0, idle_mm = 0, drill_idle_mm = 0;
  double nearest_idle_mm = 0;  ///< of the published order, contours
};

/// Receivers of the progress, in shares of the work of a stage; each may be empty.
struct CourseProgress {
  ProgressSink contours;  ///< areas are united, grown, cleared or cut
  ProgressSink order;     ///< the order of holes, contours and curves
};

/// `course` with its defaults filled in. `start_mm`: where the tool comes from. Errors as
/// of Isolate, Unite, ClearAreas, CutAreas and PathWithTabs, each with the place, and
/// kCancelled by the progress.
Result<ContourWork> MakeContourWork(const Course& course, const CourseFiles& files,
                                    const Vec2& start_mm,
                                    const CourseProgress& progress = {});

/// Depths of the passes and the top of tabs of `course` with its defaults filled in; the
/// rest is cutting.h's.
post::Cutting PassesOf(const Course& course);

}  // namespace intaglio
