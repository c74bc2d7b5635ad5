#pragma once

#include "services/job/models/read_limits.h"

namespace intaglio::mesh_reader {

/// ReadLimitsTimes(factor) for a program: meshes are read by intaglio-mesh-reader, which
/// lies beside it.
ReadLimits LimitsOfProgram(double factor);

}  // namespace intaglio::mesh_reader
