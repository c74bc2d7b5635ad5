#pragma once

// The job of a material test: square patches, whose points lie in rows by the energy of
// their pulses and in columns by the distance of their points, labelled in the glass. By
// its look a person chooses both for a glass. Of a head that jumps and dwells the columns
// may have the pulses of a point in place of the distance: a job has one number of
// pulses, so each column is a job of its own in the same block.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::client {

struct TestGrid {
  std::filesystem::path machine_file;  ///< absolute
  std::string glass = "N-BK7";
  /// Before a splitter (LaserHead), what a job may ask for (laser_setting.h); none: four
  /// from 40 % of the machine's largest up to it.
  std::vector<double> energies_mj;
  /// 0.02..10 each; none: 1, 1.25, 1.5 and 2 diameters of the mounted lens's crack.
  std::vector<double> spacings_mm;
  /// Pulses of a point, each 1 or more, a column and a job each; none: columns by
  /// spacing. With them at most one spacing, default 1.25 diameters of a crack.
  std::vector<int> pulses;
  double patch_mm = 4;           ///< side of a patch, 1..50
  std::optional<Vec3> block_mm;  ///< default: as large as the grid needs
};

/// Writes test_grid.textproto, or test_grid-N-pulses.textproto of each column, and
/// patch.svg into `folder`, and makes it; the job files. Errors: of the profile, of the
/// disk; kInvalidValue for no crack and no spacing, several spacings beside pulses, or a
/// patch that is too small or too large; kOutsideBlock for a block that is too small.
/// Energies, spacings and pulses are checked with the job.
Result<std::vector<std::filesystem::path>> WriteTestGrid(
    const TestGrid& asked, const std::filesystem::path& folder);

}  // namespace intaglio::client
