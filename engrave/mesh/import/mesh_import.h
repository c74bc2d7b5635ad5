#pragma once

// Reads a model file, held in memory, into a welded triangle mesh, in the model frame.
//
// What is read: STL (ascii, binary), OBJ, PLY, 3MF, glTF (.gltf, .glb), DAE and 3DS.
// The kind is taken from the file name's extension, in any case.
//
// What is done with it:
// - node transforms are applied and all nodes are put into one mesh; a transform that
//   mirrors also reverses the corners, so that faces still point outward;
// - polygons become triangles; points, lines and vertices that no triangle uses are left
//   out, which is a finding, and a file of nothing else is an error;
// - skins and morph targets are a finding: the model is read as its vertices are written;
// - vertices are welded by exact coordinates (weld_vertices.h), which also joins what
//   the format splits by normal, texture or material. Disconnected parts are kept;
// - coordinates are 32-bit floats, converted exactly: those of the file, or the nearest
//   to its decimals in an STL; in an OBJ and a 3MF they are doubles, so that a model at
//   map coordinates keeps its shape; the import library, which reads all other formats,
//   may be off by the last bit of a decimal.
//
// Units and axes:
// - STL, OBJ, PLY, 3DS carry no unit and are taken as they are (a 3DS is z-up);
// - 3MF declares one (millimetre by default), and is brought to mm by it;
// - DAE may declare one, and is then brought to mm by it; one without is taken as it is;
// - glTF is in metres and y-up by its standard, and is taken as it is: unit_mm = 1000
//   shows it in true size. The up axis of a DAE is left as it is, too.
// Which axis is up: up_axis.h; the placement turns it. plausible_size.h detects a
// forgotten unit.

#include <cstddef>
#include <span>
#include <string_view>

#include "engrave/core/result.h"
#include "engrave/mesh/imported_mesh.h"
#include "engrave/mesh/mesh_formats.h"

namespace intaglio::mesh {

/// Errors name the file, the problem and the remedy: kUnsupported (extension),
/// kUnreadable (empty, damaged, or not of its extension's format), kMissing (no
/// triangles), kInvalidValue (a coordinate is not a finite number), kTooLarge. What the
/// import library throws becomes kUnreadable. kUnsupported also: an extension of glTF or
/// 3MF, a beam lattice, or a free form of OBJ, without which the shape would be wrong.
/// `extension` is "stl", ".STL" or the like; `name` is what errors call the model. A
/// .gltf with buffers in other files is kUnreadable: services/job/models/model_file.h
/// writes them into it before.
Result<ImportedMesh> ImportMeshFromMemory(std::span<const std::byte> bytes,
                                          std::string_view extension,
                                          const ImportOptions& options = {},
                                          std::string_view name = "model");

}  // namespace intaglio::mesh
