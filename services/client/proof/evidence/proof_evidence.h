#pragma once

// The content of a finished job's folder: job.json, the plan, the journal, and the cracks
// where the glass is known.

#include <filesystem>
#include <vector>

#include "engrave/core/channels.h"
#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/formats/journal_file.h"
#include "engrave/proof/glass_comparison.h"
#include "proto/report.pb.h"
#include "proto/task.pb.h"
#include "services/job/machine/pulse_energies.h"

namespace intaglio::client {

struct Evidence {
  FrozenJob job;
  PointList plan_mm;
  std::vector<ChannelMask> masks;  ///< of the plan's points
  PointEnergies energies;          ///< of the plan's points
  bool has_glass = false;          ///< A real machine has no record of its glass.
  proof::Cracks cracks;            ///< in the block of the job's station
  /// In blocks at other stations, where none of the job's may be.
  std::uint64_t cracks_elsewhere_count = 0;
  CollisionRecord collisions;  ///< of the machine's head
  std::vector<formats::PointHistory> history;
  std::vector<std::uint32_t> power_ups;  ///< of the journal, in their order
};

/// job.json of a job's folder. kNotFound, kIo, kUnreadable.
Result<FrozenJob> ReadFrozenJob(const std::filesystem::path& file);

/// Errors name the file and what is wrong with it.
Result<Evidence> ReadEvidence(const std::filesystem::path& folder);

}  // namespace intaglio::client
