#pragma once

// The content of a finished job's folder: job.json, the plan, the cracks and the journal.

#include <filesystem>
#include <vector>

#include "engrave/core/channels.h"
#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/formats/journal_file.h"
#include "engrave/proof/glass_comparison.h"
#include "proto/task.pb.h"

namespace intaglio::client {

struct Evidence {
  FrozenJob job;
  PointList plan_mm;
  std::vector<ChannelMask> masks;  ///< of the plan's points
  std::vector<proof::Crack> cracks;
  std::vector<formats::PointHistory> history;
};

/// Errors name the file and what is wrong with it.
Result<Evidence> ReadEvidence(const std::filesystem::path& folder);

}  // namespace intaglio::client
