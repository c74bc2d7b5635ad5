#pragma once

// The answer of the process that reads a mesh to the process that asked: the mesh, or why
// there is none. Both are programs of one build on one computer.
//
//   offset  size
//   0       8     "IMESH1\0\0"
//   8       8     0: a mesh; else 1 + ErrorCode
//   16      8     mesh: vertices; else bytes of the sentence
//   24      8     mesh: triangles; else bytes of the value
//   32            mesh: 3 doubles a vertex, then 3 uint32 a triangle; else both texts

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::mesh_reader {

using Answer = Result<mesh::TriangleMesh>;

std::vector<std::byte> EncodeAnswer(const Answer& answer);

/// Nothing when it is no whole answer: too short or too long, of another version, a
/// corner that is no vertex, a vertex that is no place.
std::optional<Answer> ParseAnswer(std::span<const std::byte> bytes);

}  // namespace intaglio::mesh_reader
