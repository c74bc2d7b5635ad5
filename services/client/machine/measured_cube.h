#pragma once

// The marks of a test cube as somebody measured them: the table cube.csv of its job
// (cube_job.h), filled in.

#include <filesystem>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::client {

struct MeasuredCubeMark {
  int number = 0;                   ///< from 1
  Vec3 wanted_mm = Vec3::Zero();    ///< glass frame
  Vec3 measured_mm = Vec3::Zero();  ///< NaN: this coordinate was not measured
  std::size_t line_number = 0;
};

/// Marks of which no coordinate is filled in are left out. Errors name file, line and
/// column.
Result<std::vector<MeasuredCubeMark>> ReadMeasuredCube(const std::filesystem::path& file);

}  // namespace intaglio::client
