#pragma once

// Where a cloud is so dense that the cracks grow together and the glass may break.
//
// A crack is an ellipsoid, longer along the beam (z). In a ball of two crack lengths
// around each point the cracks take a share of the volume. No limit for this share is
// published. Known to be sound is a single sheet of points at the minimum spacing
// published for the lens (Trochimczuk 2008 ch. 1: 0.09 mm for cracks of 0.095 x 0.135 mm,
// 0.13 mm for 0.135 x 0.195 mm). In its densest, hexagonal order such a sheet takes 0.25
// of the ball for both lenses, 0.29 at most around a single point. The limit is a little
// above that: two such sheets upon one another take 0.5, a solid filled at that spacing
// 0.6.

#include <cstdint>
#include <vector>

#include "engrave/core/executor.h"
#include "engrave/core/geometry.h"
#include "engrave/proof/distinct_places.h"
#include "engrave/proof/point_tree.h"

namespace intaglio::proof {

struct CrackRiskOptions {
  double crack_diameter_mm = 0;  ///< across the beam, positive
  double crack_length_mm = 0;    ///< along the beam, positive
  double max_share = 0.35;       ///< of the volume, that is still sound; positive
  std::size_t max_places = 3;    ///< that are named
  Executor executor = {};
};

struct DensePlace {
  Vec3 place_mm = Vec3::Zero();  ///< of the point in the ball's middle
  std::uint64_t cracks = 0;      ///< in the ball; of thousands not all are counted
  double points_per_mm3 = 0;
  double crack_share = 0;  ///< of the ball's volume, overlaps counted twice: may pass 1
};

struct CrackRisk {
  double ball_radius_mm = 0;
  double max_share = 0;  ///< of the options
  DensePlace densest;
  std::uint64_t risky_count = 0;  ///< points whose ball holds more than max_share
  /// The worst of them, the worst first, none within four radii of a ball, or a tenth of
  /// the cloud's diagonal, of another.
  std::vector<DensePlace> worst;
};

/// `tree` is of the places, of which there is at least one. The same for any executor.
CrackRisk MeasureCrackRisk(const DistinctPlaces& places, const PointTree& tree,
                           const CrackRiskOptions& options);

}  // namespace intaglio::proof
