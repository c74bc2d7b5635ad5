#include "engrave/proof/nearest_distances.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engrave/core/check.h"

namespace intaglio::proof {
namespace {

constexpr std::size_t kPlacesPerTask = 8192;
// More neighbours than occur even in a badly thinned cloud; without this limit the cost
// would grow with the square of the number of points.
constexpr std::uint64_t kMaxNeighbours = 4096;
constexpr std::size_t kBins = 60;
constexpr double kBinsPerUnit = 20;

void OverPlaces(const Executor& executor, std::size_t count,
                const std::function<void(std::size_t task, std::size_t place)>& visit) {
  const std::size_t tasks = (count + kPlacesPerTask - 1) / kPlacesPerTask;
  RunEach(executor, tasks, [&](std::size_t task) {
    const std::size_t end = std::min(count, (task + 1) * kPlacesPerTask);
    for (std::size_t at = task * kPlacesPerTask; at < end; ++at) visit(task, at);
  });
}

struct Neighbours {
  std::vector<double> distance_mm;   // of each place to the nearest other
  std::vector<std::uint32_t> other;  // and which
};

Neighbours NeighboursOf(const PointTree& tree, std::size_t count,
                        const Executor& executor) {
  Neighbours found;
  found.distance_mm.resize(count);
  found.other.resize(count);
  OverPlaces(executor, count, [&](std::size_t, std::size_t at) {
    const auto nearest = tree.NearestOther(static_cast<std::uint32_t>(at));
    found.distance_mm[at] = std::sqrt(nearest.square);
    found.other[at] = nearest.index;
  });
  return found;
}

NearestPair PairOf(const DistinctPlaces& places, std::uint32_t a, std::uint32_t b,
                   double distance_mm) {
  if (places.first_point[a] > places.first_point[b]) std::swap(a, b);
  return {places.first_point[a], places.first_point[b], distance_mm, places.places_mm[a],
          places.places_mm[b]};
}

/// The first point that has an earlier one at its place.
NearestPair DoubledPair(const DistinctPlaces& places) {
  for (std::uint32_t i = 0; i < places.place_of_point.size(); ++i) {
    const std::uint32_t place = places.place_of_point[i];
    if (places.first_point[place] == i) continue;
    return {places.first_point[place], i, 0, places.places_mm[place],
            places.places_mm[place]};
  }
  return {};
}

/// There are two points or more.
NearestPair SmallestOf(const DistinctPlaces& places, const Neighbours& found) {
  if (places.doubled_count() > 0) return DoubledPair(places);
  const auto smallest =
      std::min_element(found.distance_mm.begin(), found.distance_mm.end());
  const auto at = static_cast<std::uint32_t>(smallest - found.distance_mm.begin());
  return PairOf(places, at, found.other[at], *smallest);
}

void SetFigures(const DistinctPlaces& places, const Neighbours& found,
                NearestDistances& result) {
  const std::size_t count = result.distance_mm.size();
  if (count < 2) return;
  // Two passes: the sum of squares alone loses the digits of an even cloud.
  double sum_mm = 0, squares = 0;
  for (const double d : result.distance_mm) sum_mm += d;
  result.mean_mm = sum_mm / static_cast<double>(count);
  for (const double d : result.distance_mm) {
    squares += (d - result.mean_mm) * (d - result.mean_mm);
    result.largest_mm = std::max(result.largest_mm, d);
  }
  const double deviation_mm = std::sqrt(squares / static_cast<double>(count));
  result.variation_ratio = result.mean_mm > 0 ? deviation_mm / result.mean_mm : 0;
  result.smallest = SmallestOf(places, found);
}

struct NearCount {
  std::uint64_t points = 0, twice_pairs = 0;
  bool more = false;
};

/// The points too near to those of place `at`, seen from there.
void CountAround(const PointTree& tree, const Vec3& place,
                 const std::vector<std::uint32_t>& points_of, std::size_t at,
                 double limit_mm, NearCount& count) {
  const std::uint64_t here = points_of[at];
  std::uint64_t others = 0, met = 0;
  tree.ForEachWithin(place, limit_mm * limit_mm, [&](std::uint32_t other, double) {
    if (other == at) return true;
    others += points_of[other];
    return ++met < kMaxNeighbours;
  });
  count.more = count.more || met == kMaxNeighbours;
  if (others > 0 || here > 1) count.points += here;
  count.twice_pairs += here * (here - 1) + here * others;
}

void CountNear(const DistinctPlaces& places, const NearestOptions& options,
               const PointTree& tree, const PointList& scaled_mm,
               const std::vector<double>& scaled_distance_mm, NearestDistances& result) {
  const double limit_mm = options.min_spacing_mm - kSpacingToleranceMm;
  if (limit_mm <= 0) return;
  const std::vector<std::uint32_t> points_of = PointsPerPlace(places);
  const std::size_t count = scaled_mm.size();
  std::vector<NearCount> counts((count + kPlacesPerTask - 1) / kPlacesPerTask);
  OverPlaces(options.executor, count, [&](std::size_t task, std::size_t at) {
    if (points_of[at] == 1 && scaled_distance_mm[at] >= limit_mm) return;
    CountAround(tree, scaled_mm[at], points_of, at, limit_mm, counts[task]);
  });
  std::uint64_t twice_pairs = 0;
  for (const NearCount& part : counts) {
    result.near_point_count += part.points;
    twice_pairs += part.twice_pairs;
    result.more_pairs = result.more_pairs || part.more;
  }
  result.near_pair_count = twice_pairs / 2;
}

/// Counts in distances scaled by the height ratio, with a separate tree if that is not 1.
void MeasureScaled(const DistinctPlaces& places, const NearestOptions& options,
                   NearestDistances& result) {
  PointList scaled_mm = places.places_mm;
  for (Vec3& p : scaled_mm) p.z() /= options.height_ratio;
  const PointTree tree(scaled_mm);
  const Neighbours found = NeighboursOf(tree, scaled_mm.size(), options.executor);
  result.min_scaled = SmallestOf(places, found);
  CountNear(places, options, tree, scaled_mm, found.distance_mm, result);
}

}  // namespace

NearestDistances MeasureNearest(const DistinctPlaces& places, const PointTree& tree,
                                const NearestOptions& options) {
  Require(options.min_spacing_mm >= 0 && std::isfinite(options.min_spacing_mm),
          "min_spacing_mm is {}", options.min_spacing_mm);
  Require(options.height_ratio >= 1 && std::isfinite(options.height_ratio),
          "height_ratio is {}", options.height_ratio);
  NearestDistances result;
  const std::size_t point_count = places.place_of_point.size();
  result.distance_mm.assign(point_count, std::numeric_limits<double>::infinity());
  if (point_count < 2) return result;
  result.doubled_count = places.doubled_count();
  const Neighbours found = NeighboursOf(tree, places.places_mm.size(), options.executor);
  for (std::size_t i = 0; i < point_count; ++i) {
    result.distance_mm[i] = found.distance_mm[places.place_of_point[i]];
  }
  if (result.doubled_count > 0) {
    for (std::uint32_t i = 0; i < point_count; ++i) {
      const std::uint32_t first = places.first_point[places.place_of_point[i]];
      if (first != i) result.distance_mm[first] = result.distance_mm[i] = 0;
    }
  }
  SetFigures(places, found, result);
  if (options.height_ratio == 1) {
    result.min_scaled = result.smallest;
    CountNear(places, options, tree, places.places_mm, found.distance_mm, result);
  } else {
    MeasureScaled(places, options, result);
  }
  return result;
}

Histogram HistogramOf(const std::vector<double>& distance_mm, double unit_mm) {
  Require(unit_mm > 0 && std::isfinite(unit_mm), "unit_mm is {}", unit_mm);
  Histogram histogram{unit_mm / kBinsPerUnit, std::vector<std::uint64_t>(kBins, 0)};
  for (const double d : distance_mm) {
    // The lowest bin that a lattice of exactly unit_mm falls into must not depend on
    // rounding.
    const double bin = std::floor((d + kSpacingToleranceMm) / histogram.bin_mm);
    ++histogram.counts[static_cast<std::size_t>(std::min(bin, kBins - 1.0))];
  }
  return histogram;
}

}  // namespace intaglio::proof
