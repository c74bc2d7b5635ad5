#pragma once

// Correction files of a scan head's field: of a head that marks
// (ScanHead.correction_file), for its driver and for what is known of a job before it
// starts, and of a head over a block (services/job/machine/head_over_block.h).

#include <optional>
#include <string>

#include "engrave/core/result.h"
#include "engrave/galvo/correction_table.h"
#include "engrave/galvo/field_window.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// What the file adds to the command of each place, by the ending of its name: .ct5, .ctb
/// or .cor. `field_mm`: the width that the 16 bits of a .ctb file are, > 0; others have
/// their own scale.
Result<galvo::FieldGrid> ReadCorrectionFile(const std::string& file, double field_mm);

/// The table of scan_head.correction_file; nothing when there is none. Errors begin with
/// "scan_head.correction_file".
Result<std::optional<galvo::CorrectionTable>> LoadCorrection(const ScanHead& head);

/// Where the head can mark: its field, less what the correction needs. `head` with a
/// field_mm above 0. Errors as of LoadCorrection.
Result<galvo::FieldWindow> WindowOf(const ScanHead& head);

/// For a sentence with the field's width: ", with its correction a square of 94.21 mm",
/// or nothing when the correction does not narrow it.
std::string NarrowedText(const galvo::FieldWindow& window);

}  // namespace intaglio
