#pragma once

// Where the points of a test pulse and of a focus series lie in a block, and what the
// series shows of the zero. Pure. Frames `glass` and `machine`, mm.
//
// A focus series is a row of points from the top face down, point i (from 1) at the
// nominal depth i * step. The zero is set too high at its beginning, so that the first
// points are in the air above the block and leave no crack. Let the first crack be that
// of point i: the true face is then between the nominal depths (i - 1) * step and
// i * step, in the middle at (i - 1/2) * step. The nominal face is too high by as much;
// the focus in air, and so the zero, by k times that, where k is the stage's way over
// that of the focus in the glass (engrave/optics/focus.h). The zero moves by
//   dz = -k (d_i - step / 2),
// and is then right within k * step / 2.

#include <cstdint>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/optics/machine_frame.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// For a block of this size, at the zero of the channel and lens.
optics::MachineFromGlass TestFrame(const MachineSpec& machine, std::uint32_t channel,
                                   const std::string& lens, const Vec3& block_mm,
                                   double stage_per_glass_ratio);

/// Of the block where the focus is with the axes at `axes`. kOutsideBlock, with the way
/// that is missing.
Result<Vec3> PointUnderFocus(const MachineSpec& machine, const Vec3& axes,
                             const optics::MachineFromGlass& frame);

struct FocusSeries {
  double step_mm = 0.05;     ///< between the depths, in the glass; > 0
  std::uint32_t count = 20;  ///< 2..1000
  double pitch_mm = 0.5;     ///< along x, so that no crack shadows another; > 0
};

/// From the x and y of the focus on, towards +x; point i at the depth i * step.
/// kOutsideBlock when the row does not fit into the block, kInvalidValue.
Result<PointList> FocusSeriesPoints(const MachineSpec& machine, const Vec3& axes,
                                    const optics::MachineFromGlass& frame,
                                    const FocusSeries& series);

/// dz of above for the points of a series; `first`: number of the first visible crack,
/// from 1. kInvalidValue: no such point, or the first one: the series began in the glass.
Result<double> ZeroMoveOfFirstCrack(const PointList& points_mm, double block_height_mm,
                                    double stage_per_glass_ratio, std::uint32_t first);

}  // namespace intaglio
