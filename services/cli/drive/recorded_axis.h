#pragma once

// What an axis was commanded and where it was, from the recording of a job: the segments
// of a run and the positions that the stage's controller latched at every lamp sync.

#include <cstdint>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/drive/identification.h"
#include "services/platform/recording/mcap_reader.h"

namespace intaglio::cli {

struct RecordedAxis {
  std::vector<drive::DriveStep> steps;  ///< in the axis' unit, mm or rad
  std::uint32_t run = 0;                ///< of the motion
  std::uint64_t tick_count = 0;
  double rate_hz = 0;
};

/// Reads the first ticks of the recording's longest run. `axis`: 0..2. kMissing: no run,
/// or no positions of it. kUnsupported: a stage on a clock of its own, a recording whose
/// samples are not known.
Result<RecordedAxis> ReadAxis(const recording::McapReader& reader, std::size_t axis,
                              std::uint64_t max_ticks);

}  // namespace intaglio::cli
