#pragma once

// What the tool of a virtual grbl did, as its program wrote it down (virtual-grbl --way):
// the judge of jobs of contours. It shares no code with what made the job.
// Frame: the machine's axes, mm.

#include <filesystem>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::testing {

/// A straight way of the tool.
struct ToolStep {
  double begin_us = 0, end_us = 0;
  Vec3 from_mm = Vec3::Zero(), to_mm = Vec3::Zero();
  bool on = false;   ///< laser, or spindle
  double power = 0;  ///< S
  double length_mm() const { return (to_mm - from_mm).norm(); }
  double lowest_mm() const { return std::min(from_mm.z(), to_mm.z()); }
};

/// Reads the way of axes that began at zero. Steps without a way are left out.
std::vector<ToolStep> ReadToolWay(const std::filesystem::path& file);

/// The distance of `place_mm` from the step, in the plane.
double DistanceToStep(const Vec2& place_mm, const ToolStep& step);
/// That from the nearest step; 1e9 without one.
double DistanceToWay(const Vec2& place_mm, const std::vector<ToolStep>& way);
/// Places on a step, both ends among them, no farther apart than `spacing_mm`.
std::vector<Vec2> PlacesOn(const ToolStep& step, double spacing_mm);
/// How many times the tool came by: steps nearer than `near_mm` that follow each other
/// count once.
std::size_t VisitsOf(const Vec2& place_mm, const std::vector<ToolStep>& way,
                     double near_mm);

}  // namespace intaglio::testing
