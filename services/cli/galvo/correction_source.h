#pragma once

#include <optional>
#include <string>

#include "engrave/galvo/correction_table.h"
#include "engrave/galvo/files/ct5.h"

namespace intaglio::cli {

/// The correction with which a field was measured.
struct CorrectionSource {
  galvo::CorrectionTable commands;  ///< added to a target, mm
  std::optional<galvo::Ct5> ct5;    ///< when the file is one
};

/// A .ct5, .ctb or .cor file. `bit_per_mm`: of a .ctb file, whose calibration is not in
/// it. Errors name the file, and --bits where it is missing.
Result<CorrectionSource> ReadCorrection(const std::string& file,
                                        std::optional<double> bit_per_mm);

}  // namespace intaglio::cli
