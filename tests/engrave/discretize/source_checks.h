#pragma once

// The guarantees of every source of points, whatever its method.

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>
#include <tuple>
#include <vector>

#include "engrave/discretize/spacing/point_source.h"

namespace intaglio::discretize {

/// Points in an order of their own, to be compared bit for bit.
inline std::vector<std::tuple<double, double, double, float>> Sorted(
    const SpacedCloud& cloud) {
  std::vector<std::tuple<double, double, double, float>> sorted;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3& p = cloud.points_mm[i];
    sorted.emplace_back(p.z(), p.y(), p.x(), cloud.spacing_mm[i]);
  }
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

inline auto AllOf(const MethodStatistics& s) {
  return std::tuple(s.point_count, s.plane_count, s.closed_contour_count,
                    s.open_contour_count, s.parallel_face_count, s.parallel_area_mm2,
                    s.small_triangle_count, s.rejected_triangle_count, s.ray_count,
                    s.odd_ray_count, s.shallow_count);
}

/// The ranges between these heights, made by threads at once, are together what the
/// source gives at once: points and statistics, bit for bit.
inline void ExpectSlabsAreTheWhole(const PointSource& source,
                                   std::vector<double> heights_mm) {
  SpacedCloud whole;
  const MethodStatistics of_whole = source.AddPoints({}, 7, {}, whole).value();
  EXPECT_EQ(of_whole.point_count, whole.size());
  const Box3 bounds = source.Bounds();
  const HeightRange heights = source.Heights();
  for (const Vec3& p : whole.points_mm) {
    EXPECT_GE(source.Rise().dot(p), heights.low_mm - 1e-9);
    EXPECT_LE(source.Rise().dot(p), heights.high_mm + 1e-9);
    EXPECT_TRUE((p.array() >= bounds.min_mm.array() - 1e-9).all() &&
                (p.array() <= bounds.max_mm.array() + 1e-9).all());
  }
  std::sort(heights_mm.begin(), heights_mm.end());
  heights_mm.insert(heights_mm.begin(), HeightRange().low_mm);
  heights_mm.push_back(HeightRange().high_mm);
  std::vector<SpacedCloud> parts(heights_mm.size() - 1);
  std::vector<MethodStatistics> counts(parts.size());
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      threads.emplace_back([&, i] {
        counts[i] =
            source.AddPoints({heights_mm[i], heights_mm[i + 1]}, 7, {}, parts[i]).value();
      });
    }
  }
  SpacedCloud together;
  MethodStatistics of_parts;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    EXPECT_EQ(counts[i].point_count, parts[i].size());
    of_parts.Add(counts[i]);
    for (std::size_t p = 0; p < parts[i].size(); ++p) {
      // Along an oblique rise the source rounds otherwise than this.
      const double height_mm = source.Rise().dot(parts[i].points_mm[p]);
      const double rounding_mm = source.Rise() == kUpward ? 0 : 1e-12;
      EXPECT_GE(height_mm, heights_mm[i] - rounding_mm);
      EXPECT_LT(height_mm, heights_mm[i + 1] + rounding_mm);
      EXPECT_EQ(parts[i].source[p], 7u);
      together.Add(parts[i].points_mm[p], 7, parts[i].spacing_mm[p]);
    }
  }
  EXPECT_EQ(Sorted(together), Sorted(whole));
  EXPECT_EQ(AllOf(of_parts), AllOf(of_whole));
}

}  // namespace intaglio::discretize
