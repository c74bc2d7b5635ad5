#pragma once

// The axes of a machine profile: its kinematics, and limits and tolerances as they are on
// the axes (mm or rad) and at the focus (mm). All take profiles that CheckMachine passes.

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engrave/machine/axes_from_glass.h"
#include "engrave/motion/axis/limits.h"
#include "proto/machine.pb.h"
#include "proto/task.pb.h"

namespace intaglio {

/// What MachineSpec.kinematics chooses; absent: three linear axes that move the head. Of
/// a scan head without a block.
machine::KinematicsOptions KinematicsOptionsOf(const MachineSpec& machine);
/// Of the block at the first station.
std::shared_ptr<const machine::Kinematics> KinematicsOf(const MachineSpec& machine);
/// Of the block at the job's station, in whose frame the places are: that of the machine,
/// turned with the block. `frame`: of the block that the places are in; a scan head's
/// beams bend at its top face.
std::shared_ptr<const machine::Kinematics> KinematicsOf(
    const MachineSpec& machine, const JobSpec& job,
    const optics::MachineFromGlass& frame);

/// Whether the axes are the focus' own coordinates: linear, the head moves, all count up,
/// no corrections.
bool AreHeadCoordinates(const MachineSpec& machine);

/// The machine's own limits and its travel, of each axis in its unit: for one that turns
/// the fields ending in _mm hold rad. Limits of lengths are those of linear axes. The
/// travel is that within the taught soft limits.
motion::Limits AxisLimitsOf(const MachineSpec& machine);

/// AxisLimits.steps_per_mm of the axes, which are set to whole steps; 0: not known.
Vec3 StepsPerMm(const MachineSpec& machine);
/// How far these steps may set the focus beside its place, by axis: half a step, mm.
Vec3 HalfStepsMm(const MachineSpec& machine);
/// The same as one distance, in the glass, where a move in depth is longer than in air.
double HalfStepInGlassMm(const FrozenJob& job);

/// The greatest speed and acceleration that one axis alone gives the focus, anywhere the
/// machine reaches, mm/s and mm/s^2: what a job's limits are bounded by.
struct FocusLimits {
  double speed_mm_s = 0;
  double acceleration_mm_s2 = 0;
};
FocusLimits FocusLimitsOf(const MachineSpec& machine);

/// Glass frame to axes, focus depth included, in the first of the job's channels.
machine::AxesFromGlass AxesFromGlassOf(const FrozenJob& job);
/// The same of a job that nobody has checked, as of a recording or a folder; nullopt: its
/// values make no axes, or it has no block.
std::optional<machine::AxesFromGlass> AxesFromGlassOfAny(const FrozenJob& job);
/// By model of the job, in the channels of the model; one of a job without models.
std::vector<machine::AxesFromGlass> AxesFromGlassOfModels(const FrozenJob& job);

/// What of a box, glass frame, can lie under the field of the mirrors, with the block's
/// corner at `origin_mm` of the machine frame: all of it, unless a stage carries the
/// block, which is wider than the field then. Inverted in x or y: nothing.
Box3 PartInField(const MachineSpec& machine, const Box3& box_mm, const Vec3& origin_mm);

/// How far the focus moves in air for a unit of the axes, at most, in the job's block.
machine::ScaleBounds ScaleBoundsOf(const FrozenJob& job);

/// Of the machine's axes, capped so that no axis alone moves the focus anywhere in the
/// block faster than the job's limits. Without limits of jerk and lengths.
motion::Limits CappedAxisLimitsOf(const FrozenJob& job);

/// The same in the glass, along x, y, z: how fast the focus may go there in the middle of
/// the block. The order of points is computed with it; where axes turn it differs over
/// the block, and the motion itself is planned with the axes' limits.
motion::Limits GlassLimitsOf(const FrozenJob& job);

/// The same along a horizontal direction, counterclockwise from x, seen from above.
FocusLimits GlassLimitsAlong(const FrozenJob& job, double turn_rad);

/// The move of the axes, as one vector, that moves no focus in the block by more than
/// `tolerance_mm`, in the glass.
double AxisToleranceOf(const FrozenJob& job, double tolerance_mm);
/// The same of a move of the third axis alone.
double AxisDepthOf(const FrozenJob& job, double tolerance_mm);

}  // namespace intaglio
