#pragma once

#include "engrave/proof/cloud_quality.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// What a cloud of a job with its defaults filled in is measured against; without an
/// executor.
proof::QualityOptions QualityOptionsOf(const JobSpec& job, const MachineSpec& machine);

}  // namespace intaglio
