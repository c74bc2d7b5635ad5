#pragma once

// What is mounted (mounted_parts.h) as a sample of the bus, and back. The one place of
// this.

#include "idl/job.h"
#include "services/job/machine/mounted_parts.h"

namespace intaglio {

/// It only borrows the texts: `parts` has to live until the sample is written.
intaglio_MountedParts SampleOf(const MountedParts& parts);
/// kInvalidValue: a number that is no size, index or lens.
Result<MountedParts> PartsOf(const intaglio_MountedParts& sample);

}  // namespace intaglio
