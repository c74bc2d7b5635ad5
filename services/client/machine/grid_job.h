#pragma once

// The job that marks the grid by which the field of a scan head is measured
// (engrave/galvo/calibration_grid.h): hatched discs, whose middles are found in a scan to
// a fraction of a pixel.

#include <filesystem>
#include <optional>
#include <string>

#include "engrave/core/result.h"

namespace intaglio::client {

struct GridJob {
  std::filesystem::path machine_file;  ///< absolute
  int nodes = 9;                       ///< a side: odd, 5..65
  std::optional<double> pitch_mm;      ///< default: 96 % of the field is covered
  double mark_um = 300;                ///< diameter of a disc
};

struct WrittenGrid {
  std::filesystem::path job_file;
  double pitch_mm = 0;
  /// The profile's correction, with which the marks are made; "": with none.
  std::string correction_file;
};

/// Writes grid.svg, grid.textproto and grid.csv (the commands, with room for the measured
/// places) into `folder`, and makes it. Errors: of the profile, of the disk; kUnsupported
/// without a scan head; kInvalidValue for a grid that is none or exceeds the field.
Result<WrittenGrid> WriteGridJob(const GridJob& job, const std::filesystem::path& folder);

}  // namespace intaglio::client
