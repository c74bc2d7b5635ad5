#pragma once

// The scan head of a machine profile over the block: its optics, what its pulses need,
// and what is wrong with it.

#include <memory>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/galvo/correction_table.h"
#include "engrave/machine/kinematics.h"
#include "engrave/sort/jump_layers.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// What is added to the commands of the mirrors: of correction_table, of the file, or of
/// the ten numbers; nullptr: nothing. Who adds it is one rule, which CheckHeadOverBlock
/// keeps: a profile has one of them, or else scan_head.correction_file, which the board
/// adds. Errors begin with the field.
Result<std::shared_ptr<const galvo::CorrectionTable>> CorrectionsOf(
    const HeadOverBlockKinematics& head);

/// The contents of head_over_block.correction_file come into the profile, so that they
/// travel with a job and do not change until it ends. Of a profile without a file, or
/// with its contents: nothing. Errors as of CorrectionsOf.
Status TakeCorrectionFile(MachineSpec& machine);

/// Lens and correction; the axis z and the block are the caller's to set. Of a head that
/// CheckHeadOverBlock passes.
machine::ScanHeadOptions HeadOptionsOf(const HeadOverBlockKinematics& head);

/// How far the focus goes in the focal plane for 1 mm of x, and of y.
Vec2 FieldScaleOf(const FieldShape& field);

/// Times of a head with jump_and_dwell for a job with its defaults; its z: the machine's
/// axis.
sort::JumpTimes JumpTimesOf(const MachineSpec& machine, const LaserOptions& laser);

/// The least pulse energy that makes a crack with an upright beam, mJ.
double CrackEnergyMj(const MachineSpec& machine);

/// Besides ranges, axes and z.
void CheckHeadOverBlock(const MachineSpec& machine, std::vector<Error>& errors);

}  // namespace intaglio
