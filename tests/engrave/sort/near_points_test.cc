#include "engrave/sort/near/near_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "engrave/core/check.h"
#include "tests/engrave/sort/clouds.h"

namespace intaglio::sort {
namespace {

std::vector<Scaled> AsFloats(const PointList& points_mm) {
  std::vector<Scaled> points;
  for (const Vec3& p : points_mm) {
    const Vec3 d = p - points_mm.front();
    points.push_back({static_cast<float>(d.x()), static_cast<float>(d.y()),
                      static_cast<float>(d.z())});
  }
  return points;
}

float Distance(const Scaled& a, const Scaled& b) {
  const Scaled d = a - b;
  return std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
}

/// All others, the nearest first, equal distances by index.
std::vector<std::pair<float, std::uint32_t>> Others(const std::vector<Scaled>& points,
                                                    std::uint32_t point) {
  std::vector<std::pair<float, std::uint32_t>> others;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (i != point) others.emplace_back(Distance(points[i], points[point]), i);
  }
  std::sort(others.begin(), others.end());
  return others;
}

/// The median distance of points to their nearest one elsewhere.
float TypicalDistance(const std::vector<Scaled>& points) {
  std::vector<float> nearest;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    for (const auto& [distance, other] : Others(points, i)) {
      if (distance == 0) continue;
      nearest.push_back(distance);
      break;
    }
  }
  if (nearest.empty()) return 1;
  std::sort(nearest.begin(), nearest.end());
  return nearest[nearest.size() / 2];
}

/// Whether each list is of other points, none twice, the nearest first, at most `count`.
void ExpectLists(const std::vector<Scaled>& points, const NearPoints& near,
                 std::size_t count) {
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const auto list = near.Of(i);
    ASSERT_LE(list.size(), count);
    const std::set<std::uint32_t> once(list.begin(), list.end());
    ASSERT_EQ(once.size(), list.size());
    ASSERT_EQ(once.count(i), 0);
    for (std::size_t k = 1; k < list.size(); ++k) {
      ASSERT_LE(std::pair(Distance(points[list[k - 1]], points[i]), list[k - 1]),
                std::pair(Distance(points[list[k]], points[i]), list[k]));
    }
  }
}

// One ring of cells reaches 1.5 typical distances in every direction, so of what is that
// near nothing nearer than what is listed is left out, and the list is full if there are
// enough. (A cell is larger where the cloud is wider than a million of them.)
TEST(NearPoints, MissNothingWithinACell) {
  std::vector<NamedCloud> clouds = Clouds(400);
  for (NamedCloud& cloud : DegenerateClouds()) clouds.push_back(std::move(cloud));
  for (const auto& [name, points_mm] : clouds) {
    const std::vector<Scaled> points = AsFloats(points_mm);
    const float typical = TypicalDistance(points);
    for (const std::size_t count : {std::size_t{1}, std::size_t{8}, std::size_t{40}}) {
      SCOPED_TRACE(name + ", " + std::to_string(count));
      const NearPoints near(points, count, typical);
      ExpectLists(points, near, count);
      for (std::uint32_t i = 0; i < points.size(); ++i) {
        std::vector<std::uint32_t> expected;
        for (const auto& [distance, other] : Others(points, i)) {
          // Rounding decides about points that are exactly one cell away.
          if (distance >= 1.49F * typical || expected.size() == count) break;
          expected.push_back(other);
        }
        const auto list = near.Of(i);
        ASSERT_GE(list.size(), expected.size());
        ASSERT_TRUE(std::equal(expected.begin(), expected.end(), list.begin()));
      }
    }
  }
}

TEST(NearPoints, SearchFartherWhereFewAreNear) {
  // Cells of 0.375: the neighbours at 1 are in the third ring.
  const std::vector<Scaled> points = AsFloats(Grid(10, 10, 1, 1, 1, 1));
  const NearPoints near(points, 8, 0.25F);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    ASSERT_GE(near.Of(i).size(), 3) << "a corner has three";
    ASSERT_EQ(Distance(points[near.Of(i).front()], points[i]), 1);
  }
}

TEST(NearPoints, OfALonePointAreNone) {
  const NearPoints far_apart(AsFloats(Row(5, {100, 0, 0})), 8, 1);
  for (std::uint32_t i = 0; i < 5; ++i) EXPECT_TRUE(far_apart.Of(i).empty());
  EXPECT_TRUE(NearPoints(AsFloats({Vec3(1, 2, 3)}), 8, 1).Of(0).empty());
}

TEST(NearPoints, TakeAnySizes) {
  const std::vector<Scaled> points = AsFloats(RandomBox(200, {1, 1, 1}, 3));
  std::vector<Scaled> tiny = points;
  for (Scaled& p : tiny) p = {p.x * 1e-40F, p.y * 1e-40F, p.z * 1e-40F};
  std::vector<Scaled> huge = points;
  for (Scaled& p : huge) p = {p.x * 1e30F, p.y * 1e30F, p.z * 1e30F};
  for (const auto& cloud : {points, tiny, huge}) {
    for (const float typical : {1e-42F, 1e-30F, 0.1F, 1e30F}) {
      ExpectLists(cloud, NearPoints(cloud, 8, typical), 8);
    }
  }
}

TEST(NearPoints, WrongArgumentsThrow) {
  for (const float wrong :
       {0.0F, -1.0F, std::nanf(""), std::numeric_limits<float>::infinity()}) {
    EXPECT_THROW(NearPoints({}, 8, wrong), PreconditionError);
  }
}

}  // namespace
}  // namespace intaglio::sort
