#pragma once

#include "engrave/mesh/import/mesh_import.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

/// The usual limits, and meshes of all formats read in this process.
inline ReadLimits AllFormats() {
  ReadLimits limits;
  limits.read_mesh = mesh::ImportMeshFromMemory;
  return limits;
}

}  // namespace intaglio
