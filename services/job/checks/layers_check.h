#pragma once

#include "proto/job.pb.h"
#include "services/job/fields/findings.h"

namespace intaglio {

/// Sort by layers (Trochimczuk 2008 annex E): its layers are not thinner than those of
/// sections, curves and images. `job` with its defaults filled in.
void CheckLayers(const JobSpec& job, Findings& findings);

}  // namespace intaglio
