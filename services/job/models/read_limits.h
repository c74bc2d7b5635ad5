#pragma once

// How large the files of a job may be that a process reads: bounds on what reading costs,
// by kind of file. A file beyond them is kTooLarge, with the way to raise them. Also
// holds the reader of mesh files (read_mesh), because the library that reads them is not
// to be trusted with them.

#include <cstdint>

#include "engrave/core/result.h"
#include "engrave/drawing/drawing.h"
#include "engrave/formats/point_file.h"
#include "engrave/image/image_file.h"
#include "engrave/mesh/files/own_formats.h"

namespace intaglio {

struct ReadLimits {
  double factor = 1;  ///< by which all that follow are multiplied
  /// Of a file, and of all files of a job together, bytes. 1 GiB is 21 million triangles
  /// of binary STL; more does not fit into the memory of a usual machine beside the mesh
  /// made from it.
  std::uint64_t max_file_bytes = std::uint64_t{1} << 30;
  mesh::ImportOptions meshes;
  drawing::DrawingLimits drawings;
  image::ImageLimits images;
  formats::PointFileLimits points;
  mesh::MeshReader read_mesh = mesh::ReadOwnFormat;
};

/// Of the factors that --size-limits takes.
inline constexpr double kMinSizeLimits = 0.001, kGreatestSizeLimits = 1000;
/// In the environment of a service, and of what it starts.
inline constexpr const char* kSizeLimitsVariable = "INTAGLIO_SIZE_LIMITS";

/// The default limits, all times `factor`: bytes, entities, points, pixels and triangles;
/// not the depth of nesting, nor coordinates.
ReadLimits ReadLimitsTimes(double factor);

/// A kTooLarge of a reader with the option that raises its limits; others as they are.
Error WithRemedy(Error error, const ReadLimits& limits);

}  // namespace intaglio
