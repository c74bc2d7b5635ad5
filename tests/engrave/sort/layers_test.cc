#include "engrave/sort/layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "engrave/sort/shadow.h"
#include "tests/engrave/sort/clouds.h"
#include "tests/engrave/sort/shadow_oracle.h"

namespace intaglio::sort {
namespace {

Order MakeLayers(const PointList& points_mm, double thickness_mm) {
  OrderOptions options;
  options.method = Method::kLayers;
  options.layers.layer_thickness_mm = thickness_mm;
  return MakeOrder(points_mm, options).value();
}

/// Slab by slab, every remaining point of the slab compared at every step.
Order BruteForceLayers(const PointList& points_mm, double thickness_mm) {
  double lowest_mm = std::numeric_limits<double>::infinity();
  for (const Vec3& p : points_mm) lowest_mm = std::min(lowest_mm, p.z());
  std::map<long, std::vector<std::uint32_t>> slabs;
  for (std::uint32_t i = 0; i < points_mm.size(); ++i) {
    const double height = (points_mm[i].z() - lowest_mm) / thickness_mm;
    slabs[static_cast<long>(std::floor(height + 1e-6))].push_back(i);
  }
  Order order;
  for (auto& [slab, left] : slabs) {
    while (!left.empty()) {
      const auto cost_of = [&](std::uint32_t i) {
        const Vec3& p = points_mm[i];
        double cost = 0;
        if (!order.empty()) {
          const Vec3& now = points_mm[order.back()];
          cost = std::max(std::abs(p.x() - now.x()), std::abs(p.y() - now.y()));
        }
        return std::tuple(cost, p.z(), p.y(), p.x(), i);
      };
      const auto best = std::min_element(
          left.begin(), left.end(),
          [&](std::uint32_t a, std::uint32_t b) { return cost_of(a) < cost_of(b); });
      order.push_back(*best);
      left.erase(best);
    }
  }
  return order;
}

TEST(Layers, IsTheGreedyOfItsDefinition) {
  for (const auto& [name, points_mm] : Clouds(800)) {
    for (const double thickness_mm : {0.1, 0.37, 100.0}) {
      EXPECT_EQ(MakeLayers(points_mm, thickness_mm),
                BruteForceLayers(points_mm, thickness_mm))
          << name << ", " << thickness_mm << " mm";
    }
  }
}

TEST(Layers, KeepsTheLayersOfALayeredCloudApart) {
  // Multiples of 0.1 are not exact in binary; still each layer is a slab of its own.
  const PointList points_mm = Grid(6, 6, 200, 0.3, 0.1, 3);
  const Order order = MakeLayers(points_mm, 0.1);
  for (std::size_t i = 0; i < order.size(); ++i) {
    EXPECT_EQ(std::lround(points_mm[order[i]].z() / 0.1), static_cast<long>(i / 36));
  }
}

TEST(Layers, FiresThroughNothingWhenASlabIsALayer) {
  const PointList points_mm = SlicedVase(60, 0.1, 0.1);
  EXPECT_EQ(CountShadowViolations(points_mm, MakeLayers(points_mm, 0.1), 0.7), 0);
  // A slab of many layers is not safe, and the checker reports that.
  EXPECT_GT(CountShadowViolations(points_mm, MakeLayers(points_mm, 3), 0.7), 0);
}

}  // namespace
}  // namespace intaglio::sort
