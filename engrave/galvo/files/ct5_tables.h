#pragma once

// What the tables of a .ct5 file mean in mm and rad, and such tables made anew.

#include "engrave/galvo/correction_table.h"
#include "engrave/galvo/files/ct5.h"
#include "engrave/galvo/head.h"

namespace intaglio::galvo {

/// Outputs minus targets of tables 0 and 1, mm at the file's calibration: what is added
/// to a target, for CorrectionTable. Bilinear: files of others are often kinked.
FieldGrid GridOf(const Ct5& file);

/// A file whose outputs are the targets plus `commands` (commands minus targets), each in
/// mm at `bit_per_mm`. Outputs outside 0..2^20 - 1 are put to its ends, for the head
/// cannot reach them. `like`: header of the file with which the field was measured; its
/// calibration is replaced. kInvalidValue: bit_per_mm outside 1..2^20 or `commands` that
/// have no inverse.
Result<Ct5> Ct5Of(const CorrectionTable& commands, int bit_per_mm, const Ct5* like);

/// The tables of an ideal head with a lens behind its mirrors: angles in bits, where
/// `calibration_angle_deg` (mechanical) is 96 % of 2^19. Errors as of CheckHead and
/// AnglesFor; kInvalidValue for numbers outside their ranges.
Result<Ct5> Ct5OfHead(const Head& head, int bit_per_mm, double calibration_angle_deg);

}  // namespace intaglio::galvo
