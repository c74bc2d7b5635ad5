#pragma once

// The places of a cloud, each once, so ordered that neighbours in the list are mostly
// neighbours in space. Searches over a list in this order find in the cache the data of
// the previous search; and a cloud of a million points at one place costs no more than
// one point.

#include <cstdint>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::proof {

struct DistinctPlaces {
  PointList places_mm;                     ///< along the curve of Morton 1966
  std::vector<std::uint32_t> first_point;  ///< of each place, the lowest index
  std::vector<std::uint32_t> place_of_point;

  /// Points beyond the first of their place.
  std::uint64_t doubled_count() const { return place_of_point.size() - places_mm.size(); }
};

/// Places are the same when their coordinates compare equal. Fewer than 2^32 points,
/// finite.
DistinctPlaces DistinctPlacesOf(const PointList& points_mm);

/// Of each place, the number of points there.
std::vector<std::uint32_t> PointsPerPlace(const DistinctPlaces& places);

}  // namespace intaglio::proof
