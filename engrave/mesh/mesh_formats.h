#pragma once

// The formats of meshes that are read, the bounds on what a file of them may cost, and
// the type of a function that reads one. Readers: files/own_formats.h, and
// import/mesh_import.h for all of them.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/mesh/imported_mesh.h"

namespace intaglio::mesh {

/// The extensions of files that are read, lower case.
inline constexpr std::array<std::string_view, 8> kMeshExtensions = {
    "stl", "obj", "ply", "3mf", "gltf", "glb", "dae", "3ds"};

/// Bounds on what a file may cost. A limit exceeded is ErrorCode::kTooLarge.
struct ImportOptions {
  /// Largest file, bytes. Default 1 GiB: 21 million triangles of binary STL.
  std::uint64_t max_file_bytes = std::uint64_t{1} << 30;
  /// Maximum size of an unpacked 3MF (a zip archive), as a multiple of its packed size.
  /// Default 50: models grow 4 to 20 times, a malicious megabyte 1000 times.
  std::uint64_t max_unpacked_ratio = 50;
  /// Maximum number of triangles after instancing and triangulation. Default 10 million,
  /// far more than the 2 million points that a machine engraves. While such a mesh is
  /// read it takes (measured) 0.4 GB as STL, 0.9 GB as PLY, 2.4 GB as OBJ; 0.24 GB stay.
  std::uint64_t max_triangles = 10'000'000;
  /// Only what belongs to objects of these names: nodes of the scene, which in an OBJ are
  /// its o and g, in a 3DS its objects. What lies below a node belongs to it, too. Empty:
  /// all. A name that the file does not have is kMissing; the error lists its names.
  std::vector<std::string> objects = {};
};

/// The function that reads a file held in memory; `extension` is "stl", ".STL" or the
/// like, `name` what errors call the model.
using MeshReader = std::function<Result<ImportedMesh>(
    std::span<const std::byte> bytes, std::string_view extension,
    const ImportOptions& options, std::string_view name)>;

/// Whether files of this extension may declare the unit of their coordinates.
bool MayDeclareUnit(std::string_view extension);

/// Whether files of this extension are read by a separate process: all but STL.
bool IsReadByProcess(std::string_view extension);

}  // namespace intaglio::mesh
