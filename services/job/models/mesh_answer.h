#pragma once

// The answer of the process that reads a mesh to the process that asked: the mesh, or why
// there is none. Both are programs of one build on one computer.
//
//   offset  size
//   0       8     "IMESH2\0\0"
//   8       8     0: a mesh; else 1 + ErrorCode
//   16      8     mesh: vertices; else bytes of the sentence
//   24      8     mesh: triangles; else bytes of the value
//   32      8     mesh: bytes of its findings; else 0
//   40      8     mesh: its declared unit, mm, a double; else 0
//   48            mesh: 3 doubles a vertex, 3 uint32 a triangle, its findings; else both
//                 texts
//
// A finding is the bytes of its three texts (what, where, remedy), its count and its
// effect, 8 bytes each; its area, mm^2, a double; and the texts.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/mesh/imported_mesh.h"

namespace intaglio::mesh_reader {

using Answer = Result<mesh::ImportedMesh>;

std::vector<std::byte> EncodeAnswer(const Answer& answer);

/// Nothing when it is no whole answer: too short or too long, of another version, a
/// corner that is no vertex, a vertex that is no place, or else not as EncodeAnswer
/// writes it.
std::optional<Answer> ParseAnswer(std::span<const std::byte> bytes);

}  // namespace intaglio::mesh_reader
