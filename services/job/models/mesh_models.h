#pragma once

// Meshes of a job, read and placed, as sources of points by their method, and what a
// person should know of them before they are engraved. `job` with its defaults filled in.

#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/mesh/mesh.h"
#include "services/job/methods/point_maker.h"
#include "services/job/models/model_sources.h"

namespace intaglio {

struct PlacedMesh {
  mesh::TriangleMesh mesh;  ///< of the objects that the model asks for
  Box3 file_mm;             ///< of the whole file, which is what is fitted and centred
};

/// The mesh in its block, glass frame. Objects of a file keep their places among each
/// other: size and place are those of the whole file. Errors name the model's file; what
/// its reader met and did not obey is added to `warnings`. The unit that the file
/// declares becomes that of `input.placement`; a unit of the job replaces it, with a
/// note.
Result<PlacedMesh> PlaceMesh(MethodInput& input, const FileBytes& file,
                             const ReadLimits& limits, Warnings& warnings);

/// Its diagnosis and its warnings are added to `made`. A mesh whose bounding box cannot
/// be engraved (plausible_size.h) is refused before anything is made of it.
MadePoints MakeMesh(const Method& method, MethodInput& input, const FileBytes& file,
                    const ReadLimits& limits, JobSources& made);

}  // namespace intaglio
