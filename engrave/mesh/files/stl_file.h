#pragma once

// STL, binary and text (Fabbers, "The STL format", 3D Systems 1989), read piece by piece
// straight into the welder: 12 to 24 bytes per triangle for the mesh, 13 to 26 for the
// welder, a megabyte for the file.
//
// A binary STL is 80 bytes of anything, the count of triangles, and 50 bytes a triangle:
// normal, three corners, two bytes of anything. A text is "solid NAME", then "facet
// normal x y z / outer loop / 3 times vertex x y z / endloop / endfacet", then
// "endsolid"; several solids may follow one another, and keywords may be in upper or
// lower case. A file whose size matches its count is binary, whatever it begins with.
//
// Normals, colours and attributes are not used.

#include <cstdint>

#include "engrave/core/result.h"
#include "engrave/mesh/files/byte_reader.h"
#include "engrave/mesh/files/import_source.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::mesh {

/// Errors as ImportMeshFromMemory() has them. `byte_count` is the size of the whole file.
Result<TriangleMesh> ReadStl(ByteReader& bytes, std::uint64_t byte_count,
                             const ImportSource& source);

}  // namespace intaglio::mesh
