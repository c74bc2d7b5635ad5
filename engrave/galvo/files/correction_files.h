#pragma once

// Correction files of other control boards, as grids for CorrectionTable; they are to be
// interpolated bilinear, for they are made by quadrants and kinked along the axes.
//   .ctb  (SCANLAB, RTC2 to RTC4) uint16 [x, y][65 rows][65 columns], little-endian:
//         outputs of 16 bits, 32768 is 0; targets 1024 bits apart, the last 65535
//   .cor  (LMC boards) version 2: "JCZ_COR_2_1", float64 unit/mm at 28, int32 {dx, dy}
//         [65 rows][65 columns] at 36; version 1: "LMC1COR_1.0", 63 float64 at 24, of
//         which the 44th is unit/mm, float64 {dx, dy} at 528. Units of 1/65536 of the
//         field, 32768 units from its centre to its border.
// Published by their makers' manuals and by programs that read them; the offsets were
// checked on files in use.

#include <string_view>

#include "engrave/galvo/field_grid.h"

namespace intaglio::galvo {

/// Outputs minus targets, in mm of `bit_per_mm` (16 bits); the file does not have it.
/// Errors begin with the name: kUnreadable (another size); kInvalidValue (bit_per_mm).
Result<FieldGrid> ReadCtb(std::string_view bytes, std::string_view name,
                          double bit_per_mm);

/// What is added to a target, mm. Errors begin with the name: kUnreadable (no such file,
/// another size), kInvalidValue (a scale, a node: no number, or more than the field).
Result<FieldGrid> ReadCor(std::string_view bytes, std::string_view name);

}  // namespace intaglio::galvo
