#include "engrave/proof/nearest_distances.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/engrave/proof/proof_shapes.h"

namespace intaglio::proof {
namespace {

NearestDistances Measure(const PointList& points_mm, const NearestOptions& options) {
  const DistinctPlaces places = DistinctPlacesOf(points_mm);
  const PointTree tree(places.places_mm);
  return MeasureNearest(places, tree, options);
}

struct BruteForce {
  std::vector<double> distance_mm;
  std::uint64_t near_pairs = 0, near_points = 0;
  double min_scaled_mm = INFINITY;
};

BruteForce Brute(const PointList& p, double min_spacing_mm, double height_ratio) {
  BruteForce brute;
  for (std::size_t i = 0; i < p.size(); ++i) {
    double nearest_mm = INFINITY;
    bool near = false;
    for (std::size_t j = 0; j < p.size(); ++j) {
      if (i == j) continue;
      Vec3 apart = p[i] - p[j];
      nearest_mm = std::min(nearest_mm, apart.norm());
      apart.z() /= height_ratio;
      brute.min_scaled_mm = std::min(brute.min_scaled_mm, apart.norm());
      const bool too_near = apart.norm() < min_spacing_mm;
      near = near || too_near;
      brute.near_pairs += too_near && i < j;
    }
    brute.near_points += near;
    brute.distance_mm.push_back(nearest_mm);
  }
  return brute;
}

TEST(DistinctPlaces, HasEveryPlaceOnce) {
  PointList points = RandomPoints(300, 10, 1);
  for (std::size_t i = 0; i < 100; ++i) points.push_back(Vec3(points[i]));
  points.push_back(Vec3(points[7]));
  points.push_back(Vec3(0.0, -0.0, 0.0));
  points.push_back(Vec3::Zero());
  const DistinctPlaces places = DistinctPlacesOf(points);
  EXPECT_EQ(places.places_mm.size(), 301u);
  EXPECT_EQ(places.doubled_count(), 102u);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(places.places_mm[places.place_of_point[i]], points[i]);
    EXPECT_LE(places.first_point[places.place_of_point[i]], i);
  }
  EXPECT_EQ(places.first_point[places.place_of_point[307]], 7u);
  EXPECT_TRUE(DistinctPlacesOf({}).places_mm.empty());
}

TEST(NearestDistances, EqualsBruteForce) {
  const PointList points = RandomPoints(1500, 5, 2);
  for (const double ratio : {1.0, 2.5}) {
    const BruteForce brute = Brute(points, 0.35, ratio);
    const NearestDistances measured = Measure(points, {0.35, ratio, {}});
    ASSERT_EQ(measured.distance_mm.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_EQ(measured.distance_mm[i], brute.distance_mm[i]) << i;
    }
    EXPECT_EQ(measured.near_pair_count, brute.near_pairs);
    EXPECT_EQ(measured.near_point_count, brute.near_points);
    EXPECT_FALSE(measured.more_pairs);
    EXPECT_NEAR(measured.min_scaled.distance_mm, brute.min_scaled_mm, 1e-15);
    const auto smallest =
        std::min_element(brute.distance_mm.begin(), brute.distance_mm.end());
    EXPECT_EQ(measured.smallest.distance_mm, *smallest);
    const NearestPair& pair = measured.smallest;
    EXPECT_EQ((points[pair.first_point] - points[pair.second_point]).norm(), *smallest);
    EXPECT_EQ(points[pair.first_point], pair.first_mm);
    EXPECT_EQ(points[pair.second_point], pair.second_mm);
  }
}

TEST(NearestDistances, FiguresAreThoseOfTheTextbook) {
  // Distances 1, 1, 2, 4: mean 2, deviation sqrt(6 / 4).
  const PointList points = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(3, 0, 0), Vec3(7, 0, 0)};
  const NearestDistances measured = Measure(points, {});
  EXPECT_DOUBLE_EQ(measured.mean_mm, 2);
  EXPECT_DOUBLE_EQ(measured.variation_ratio, std::sqrt(1.5) / 2);
  EXPECT_DOUBLE_EQ(measured.largest_mm, 4);
  EXPECT_EQ(measured.smallest.first_point, 0u);
  EXPECT_EQ(measured.smallest.second_point, 1u);
  EXPECT_EQ(measured.near_pair_count, 0u);
}

TEST(NearestDistances, ALatticeOfTheMinimumSpacingKeepsIt) {
  PointList points;
  for (int i = 0; i < 1000; ++i) points.emplace_back(7.3 + i * 0.1, 2, 4);
  // Rounding alone brings pairs of such a lattice below 0.1 mm, and that is no fault.
  const NearestDistances measured = Measure(points, {0.1, 1, {}});
  EXPECT_LT(measured.smallest.distance_mm, 0.1);
  EXPECT_EQ(measured.near_pair_count, 0u);
  points.emplace_back(points[500] + Vec3(0, 0, 0.0999));
  const NearestDistances spoiled = Measure(points, {0.1, 1, {}});
  EXPECT_EQ(spoiled.near_pair_count, 1u);
  EXPECT_EQ(spoiled.near_point_count, 2u);
  EXPECT_EQ(spoiled.smallest.first_point, 500u);
  EXPECT_EQ(spoiled.smallest.second_point, 1000u);
}

TEST(NearestDistances, HeightsCountByTheRatio) {
  const PointList points = {Vec3(0, 0, 0), Vec3(0, 0, 0.15), Vec3(0.12, 0, 0)};
  EXPECT_EQ(Measure(points, {0.1, 1, {}}).near_pair_count, 0u);
  const NearestDistances measured = Measure(points, {0.1, 1.6, {}});
  EXPECT_EQ(measured.near_pair_count, 1u);
  EXPECT_EQ(measured.min_scaled.second_point, 1u);
  EXPECT_NEAR(measured.min_scaled.distance_mm, 0.15 / 1.6, 1e-15);
  EXPECT_EQ(measured.smallest.distance_mm, 0.12);
}

TEST(NearestDistances, DoubledPointsAreCountedAndDoNotTakeForever) {
  PointList points = {Vec3(0, 0, 0), Vec3(5, 0, 0)};
  for (int i = 0; i < 200000; ++i) points.emplace_back(3, 3, 3);
  const NearestDistances measured = Measure(points, {0.1, 1, {}});
  EXPECT_EQ(measured.doubled_count, 199999u);
  EXPECT_EQ(measured.near_point_count, 200000u);
  EXPECT_EQ(measured.near_pair_count, 200000ull * 199999 / 2);
  EXPECT_EQ(measured.smallest.first_point, 2u);
  EXPECT_EQ(measured.smallest.second_point, 3u);
  EXPECT_EQ(measured.smallest.distance_mm, 0);
  EXPECT_EQ(measured.distance_mm[2], 0);
  EXPECT_EQ(measured.distance_mm[1], std::sqrt(22.0));
}

TEST(NearestDistances, NoPointsAndOnePoint) {
  EXPECT_TRUE(Measure({}, {0.1, 1, {}}).distance_mm.empty());
  const NearestDistances alone = Measure({Vec3(1, 2, 3)}, {0.1, 1, {}});
  EXPECT_TRUE(std::isinf(alone.distance_mm.at(0)));
  EXPECT_EQ(alone.mean_mm, 0);
}

TEST(NearestDistances, DoNotDependOnTheWorkers) {
  const PointList points = RandomPoints(30000, 5, 3);
  const NearestDistances one = Measure(points, {0.1, 2, {}});
  const NearestDistances many = Measure(points, {0.1, 2, Scattered()});
  EXPECT_EQ(one.distance_mm, many.distance_mm);
  EXPECT_EQ(one.near_pair_count, many.near_pair_count);
  EXPECT_EQ(one.variation_ratio, many.variation_ratio);
}

TEST(HistogramOf, PutsALatticeIntoTheBinOfItsSpacing) {
  const Histogram histogram =
      HistogramOf({0.1, 0.1 - 1e-15, 0.0999, 0, 0.5, INFINITY}, 0.1);
  EXPECT_DOUBLE_EQ(histogram.bin_mm, 0.005);
  ASSERT_EQ(histogram.counts.size(), 60u);
  EXPECT_EQ(histogram.counts[20], 2u);
  EXPECT_EQ(histogram.counts[19], 1u);
  EXPECT_EQ(histogram.counts[0], 1u);
  EXPECT_EQ(histogram.counts[59], 2u);
}

}  // namespace
}  // namespace intaglio::proof
