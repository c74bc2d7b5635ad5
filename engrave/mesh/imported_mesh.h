#pragma once

// A mesh as a reader of files gives it: the triangles, and what the reader met in the
// file and did not obey (engrave/core/findings.h).

#include <utility>

#include "engrave/core/findings.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::mesh {

struct ImportedMesh : TriangleMesh {
  ImportedMesh() = default;
  ImportedMesh(TriangleMesh mesh, FileFindings met = {})
      : TriangleMesh(std::move(mesh)), findings(std::move(met)) {}

  FileFindings findings;
  /// mm that a unit of the file is long by its own declaration, by which the vertices
  /// were multiplied; 0: it declares none, and they are those of the file.
  double declared_unit_mm = 0;
};

}  // namespace intaglio::mesh
