#pragma once

// The job that makes the test cube of a scan head over a block
// (engrave/calibrate/cube_pattern.h).

#include <filesystem>
#include <string>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::client {

struct CubeJob {
  std::filesystem::path machine_file;  ///< absolute; a profile with head_over_block
  Vec3 block_mm = Vec3(50, 50, 50);
  std::string glass = "N-BK7";  ///< by a name of the material base
  int nodes = 5;                ///< of a side of a level
  int levels = 2;
};

/// Writes cube.ply, cube.csv (the marks by number, with room for what is measured) and
/// cube.textproto into `folder`, and makes it; returns the job file. The marks fill the
/// block but for 5 mm, as far as the field goes and the laser makes cracks at the lowest
/// level, at one depth and not at either of two. Errors: of the profile, of
/// MakeCubePattern, of the disk; kUnsupported for a machine without head_over_block;
/// kOutsideBlock where there are no cracks.
Result<std::filesystem::path> WriteCubeJob(const CubeJob& job,
                                           const std::filesystem::path& folder);

}  // namespace intaglio::client
