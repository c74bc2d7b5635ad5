#include "engrave/sort/local_samples.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "engrave/core/check.h"

namespace intaglio::sort {
namespace {

using Indices = std::vector<std::uint32_t>;

/// Every point's index, in no order.
Indices AllOf(const PointList& points_mm) {
  Indices all(points_mm.size());
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

Indices NearestTo(const Vec3& place_mm, const PointList& points_mm, std::size_t size,
                  bool by_height) {
  std::vector<std::pair<double, std::uint32_t>> near(points_mm.size());
  for (std::uint32_t i = 0; i < points_mm.size(); ++i) {
    const Vec3 away_mm = points_mm[i] - place_mm;
    near[i] = {by_height ? std::abs(away_mm.z()) : away_mm.squaredNorm(), i};
  }
  std::nth_element(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(size) - 1,
                   near.end());
  Indices nearest(size);
  for (std::size_t i = 0; i < size; ++i) nearest[i] = near[i].second;
  std::sort(nearest.begin(), nearest.end());
  return nearest;
}

}  // namespace

std::vector<Indices> LocalSamples(const PointList& points_mm, std::size_t count,
                                  std::size_t size, bool by_height) {
  Require(count >= 1 && size >= 1, "{} samples of {} points", count, size);
  Indices all = AllOf(points_mm);
  if (all.size() <= count * size) return {std::move(all)};
  const auto lower = [&](std::uint32_t a, std::uint32_t b) {
    const Vec3 &p = points_mm[a], &q = points_mm[b];
    return std::tuple(p.z(), p.y(), p.x(), a) < std::tuple(q.z(), q.y(), q.x(), b);
  };
  std::vector<Indices> samples;
  for (std::size_t k = 0; k < count; ++k) {
    const auto middle =
        all.begin() + static_cast<std::ptrdiff_t>(all.size() * (2 * k + 1) / (2 * count));
    std::nth_element(all.begin(), middle, all.end(), lower);
    samples.push_back(NearestTo(points_mm[*middle], points_mm, size, by_height));
  }
  return samples;
}

}  // namespace intaglio::sort
