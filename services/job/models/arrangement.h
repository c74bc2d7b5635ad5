#pragma once

// Models and a text beside one another in a block, as seen from its front: x to the
// right, z up, y away from the viewer.

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

/// Where a text lies beside the models; centre: among them.
inline constexpr std::array<std::string_view, 7> kTextPlaces = {
    "below", "above", "left", "right", "front", "behind", "centre"};

/// Glass between two that lie side by side, mm.
inline constexpr double kArrangedGapMm = 2;

/// There is more than one, and none has a place of its own: moved, not centred, filling
/// the block, or in a block of its channel.
bool IsFreeToArrange(const JobSpec& job);

/// Moves the models side by side along x, unless one has a place of its own; then the
/// text to its place beside all of them (default below; without models nothing moves),
/// and all together to the centre of the block. Adds to `warnings` (models_overlap) the
/// volume in which the text and the models overlap. kInvalidValue: `text_place` of a job
/// with no text or several, or with models whose place the size of the block decides;
/// errors of reading the models.
Status Arrange(const std::optional<std::string>& text_place, const MachineSpec& machine,
               const ReadLimits& limits, JobSpec& job, Warnings& warnings);

}  // namespace intaglio
