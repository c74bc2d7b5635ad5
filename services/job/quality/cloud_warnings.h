#pragma once

// What a measurement that is independent of how the points were made finds in the cloud
// of a job: points too near, places where the glass may break.

#include <optional>
#include <vector>

#include "engrave/core/channels.h"
#include "engrave/core/executor.h"
#include "engrave/core/geometry.h"
#include "engrave/core/warning.h"
#include "engrave/proof/crack_risk.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"

namespace intaglio {

struct CloudFindings {
  Warnings warnings;               ///< of several blocks each begins with its channel
  double measured_spacing_mm = 0;  ///< the least of the blocks; 0: a point has no other
  /// Of the block where it is greatest; nothing when the lens's cracks are not known.
  std::optional<proof::CrackRisk> crack_risk;
};

/// Of each block that has points of its own. `job` and `machine` with their defaults
/// filled in; `masks`: one a point. The same for any executor.
CloudFindings FindInCloud(const JobSpec& job, const MachineSpec& machine,
                          const PointCloud& cloud, const std::vector<ChannelMask>& masks,
                          const Executor& executor);

}  // namespace intaglio
