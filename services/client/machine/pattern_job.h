#pragma once

// The job that makes the test pattern of a machine (engrave/calibrate/test_pattern.h).

#include <filesystem>
#include <string>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::client {

struct PatternJob {
  std::filesystem::path machine_file;  ///< absolute
  Vec3 block_mm = Vec3(50, 50, 20);
  std::string glass = "N-BK7";  ///< by a name of the material base
};

/// Writes pattern.ply and pattern.textproto into `folder`, and makes it; returns the job
/// file. The lamp's rate is the highest at which the fast rows stay below the speed of x
/// and y. Errors: of the profile, of MakeTestPattern, of the disk; kUnsupported for a
/// machine whose axes turn, or without such a rate.
Result<std::filesystem::path> WritePatternJob(const PatternJob& job,
                                              const std::filesystem::path& folder);

}  // namespace intaglio::client
