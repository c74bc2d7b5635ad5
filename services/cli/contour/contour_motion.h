#pragma once

// A course in time: where the tool is, and how fast. Frame: that of the files, mm.

#include <optional>
#include <string>
#include <vector>

#include "engrave/course/plan.h"
#include "proto/machine.pb.h"
#include "services/job/course/course_work.h"

namespace intaglio::cli {

enum class LegKind { kIdle, kDown, kWork, kDrill };

/// "idle", "down", "work", "drill".
const char* NameOf(LegKind kind);

/// A part of the motion. In kDown and kDrill the tool moves along z alone, at its place.
struct MotionLeg {
  LegKind kind = LegKind::kIdle;
  double begin_s = 0, duration_s = 0;
  contour::Edges edges;  ///< of kIdle and kWork
  double length_mm = 0;
  Vec2 begin_mm = Vec2::Zero();
  std::size_t number = 0;               ///< of the path or the drill round, from 0
  std::optional<course::SpeedLaw> law;  ///< of kWork on a machine
};

struct ToolState {
  std::size_t leg = 0;
  Vec2 place_mm = Vec2::Zero();
  double way_mm = 0;      ///< along the leg
  double speed_mm_s = 0;  ///< in the plane
};

struct ContourMotion {
  std::vector<MotionLeg> legs;
  double duration_s = 0;
  double work_s = 0;         ///< of it at work
  std::size_t not_held = 0;  ///< paths whose tolerance cannot be kept

  /// time_s: 0..duration_s.
  ToolState At(double time_s) const;
};

/// Contours, then holes. Without a machine the tool has the speeds of the course at once.
/// With one the speed along each path is planned (engrave/course) so that what its drive
/// makes stays within its position tolerance; between paths the tool has the speed of
/// travel. Errors as of CourseAxesOf and PlanCourse.
Result<ContourMotion> MotionOf(const ContourWork& work, const Course& whole,
                               const MachineSpec* machine, const Vec2& start_mm);

}  // namespace intaglio::cli
