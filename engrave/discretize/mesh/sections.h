#pragma once

// Sections ("Cutting faces", Trochimczuk 2008 annex A): parallel planes cut the mesh, and
// every contour gets points at equal arc length. Frame glass, mm.
//
// Known weakness of the source's method: a face parallel to the planes is not cut. Here
// such faces are found, and are either filled or reported.

#include <memory>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/discretize/mesh/direction.h"
#include "engrave/discretize/spacing/point_source.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

/// Where the planes are counted from, and whose axes their direction refers to.
enum class SectionReference {
  kObject,  ///< from the model's own extent; the model's axes
  kWorld,   ///< multiples of the layer distance from the block's origin, for all models
            ///< the same; the block's axes
};

/// Faces within 0.1 degrees of the planes' direction.
enum class ParallelFaces {
  kCover,   ///< a triangular grid of points at the vertex distance, and counted
  kReport,  ///< counted
  kIgnore,
};

struct SectionOptions {
  double layer_distance_mm = 1;   ///< 0.01..100
  double vertex_distance_mm = 1;  ///< 0.01..100, along a contour
  /// First and last plane lie this share of the layer distance within the object's
  /// extent, 0..1 (Trochimczuk 2008 annex B). Of kObject both exactly: layers that do not
  /// fill the extent lie evenly further apart, each by less than a layer distance over
  /// their number. Of kWorld at least.
  double first_last_distance_ratio = 0.1;
  /// Each next layer begins shifted by this share of the vertex distance, 0..1.
  double twist_phase_ratio = 0;
  /// Keep the points at both ends of an open contour.
  bool insert_end_points = true;
  Direction normal;
  SectionReference reference = SectionReference::kObject;
  /// The model's axes in the glass frame, columns: the rotation it was placed with. For
  /// kObject; identity refers `normal` to the block's axes.
  Mat3 object_axes = Mat3::Identity();
  ParallelFaces parallel_faces = ParallelFaces::kCover;
};

/// A plane passes below a vertex that lies exactly in it, so that every contour of a
/// closed mesh is closed. A model of kObject thinner than twice the first distance gets
/// one plane, in its middle; one of kWorld gets none when it lies between two.
///
/// Planes across z are cut when a range of heights is requested; for others the contours
/// are traced at once, and the cost of a range is proportional to its points. A contour
/// is counted in the range of its first point; planes and parallel faces in the range of
/// the lowest height of the model. kTooLarge for more planes, crossings or points than
/// candidate_limit.h allows.
Result<std::unique_ptr<PointSource>> MakeSections(mesh::TriangleMesh mesh,
                                                  const SectionOptions& options);

}  // namespace intaglio::discretize
