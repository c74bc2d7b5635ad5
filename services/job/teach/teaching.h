#pragma once

// What a person teaches at a machine, as a change of the taught positions of its profile.
// Pure. Axes in mm or rad; frames `machine` and `glass`, mm.
//
// A zero is found with the focus at a known place of the block, in air: at its lower
// corner (the table's surface), or with a block of known height at the corner of its top
// face. With the axes at `axes` the focus is at the place p = ToPlace(axes) of the
// machine frame (engrave/machine/kinematics.h), so the block's corner is at p less that
// place of the block. This holds for a table that moves, too: nothing is mirrored.
//
// Errors: kNotFound (channel, lens), kInvalidValue with the field, its value and what to
// do (CheckTaught, ranges).

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// The lens of this name; empty: the machine's, when it has just one.
Result<std::string> TaughtLens(const MachineSpec& machine, const std::string& name);

struct ZeroChoice {
  std::uint32_t channel = 1;
  std::string lens = {};            ///< as for TaughtLens
  Vec3 at_glass_mm = Vec3::Zero();  ///< where in the block the focus is, glass frame
  /// x, y, z of the machine frame; the others keep their zero.
  std::array<bool, 3> sets = {true, true, true};
};

/// The zero of a channel and lens, with the axes at `axes`.
Result<TaughtPositions> WithZero(const MachineSpec& machine, const Vec3& axes,
                                 const ZeroChoice& choice);
/// The zero moved by `by_mm`: cracks of the next job come to lie that much further along
/// the machine's x, y and z. Depths in the glass change by more than by_mm.z: see
/// optics/focus.h.
Result<TaughtPositions> WithZeroMoved(const MachineSpec& machine, const Vec3& by_mm,
                                      const ZeroChoice& choice);
/// The axes with which the focus is at `choice.at_glass_mm` by the zero of its channel
/// and lens, taught or of the profile, nearest to `axes`; `sets` is not used. Also what
/// the kinematics refuses. Limits are not checked.
Result<Vec3> AxesAtZero(const MachineSpec& machine, const Vec3& axes,
                        const ZeroChoice& choice);
/// nullopt: it is driven to no more.
Result<TaughtPositions> WithSample(const MachineSpec& machine,
                                   const std::optional<Vec3>& axes);
Result<TaughtPositions> WithPark(const MachineSpec& machine,
                                 const std::optional<Vec3>& axes);
/// nullopt: the axes' travel.
Result<TaughtPositions> WithSoftLimits(const MachineSpec& machine,
                                       const std::optional<Box3>& axes);

}  // namespace intaglio
