#include "engrave/proof/distinct_places.h"

#include <algorithm>
#include <limits>

#include "engrave/core/check.h"

namespace intaglio::proof {
namespace {

constexpr double kCellsPerAxis = (1 << 21) - 1;

/// Two zero bits before each of the low 21.
std::uint64_t Spread(std::uint64_t bits) {
  bits = (bits | bits << 32) & 0x1F00000000FFFF;
  bits = (bits | bits << 16) & 0x1F0000FF0000FF;
  bits = (bits | bits << 8) & 0x100F00F00F00F00F;
  bits = (bits | bits << 4) & 0x10C30C30C30C30C3;
  return (bits | bits << 2) & 0x1249249249249249;
}

struct Entry {
  std::uint64_t code;
  std::uint32_t point;
};

std::vector<Entry> CodesOf(const PointList& points_mm) {
  Box3 box;
  for (const Vec3& p : points_mm) box.Extend(p);
  const double extent_mm = box.size_mm().maxCoeff();
  const double cells_per_mm = extent_mm > 0 ? kCellsPerAxis / extent_mm : 0;
  std::vector<Entry> entries(points_mm.size());
  for (std::uint32_t i = 0; i < points_mm.size(); ++i) {
    const Vec3 cell = (points_mm[i] - box.min_mm) * cells_per_mm;
    entries[i] = {Spread(static_cast<std::uint64_t>(cell.x())) << 2 |
                      Spread(static_cast<std::uint64_t>(cell.y())) << 1 |
                      Spread(static_cast<std::uint64_t>(cell.z())),
                  i};
  }
  return entries;
}

}  // namespace

DistinctPlaces DistinctPlacesOf(const PointList& points_mm) {
  Require(points_mm.size() < std::numeric_limits<std::uint32_t>::max(),
          "a cloud of {} points is too large", points_mm.size());
  std::vector<Entry> entries = CodesOf(points_mm);
  std::sort(entries.begin(), entries.end(), [&](const Entry& a, const Entry& b) {
    if (a.code != b.code) return a.code < b.code;
    const Vec3 &p = points_mm[a.point], &q = points_mm[b.point];
    for (int axis = 0; axis < 3; ++axis) {
      if (p[axis] != q[axis]) return p[axis] < q[axis];
    }
    return a.point < b.point;
  });
  DistinctPlaces distinct;
  distinct.place_of_point.resize(points_mm.size());
  distinct.places_mm.reserve(points_mm.size());
  distinct.first_point.reserve(points_mm.size());
  for (const Entry& entry : entries) {
    const Vec3& p = points_mm[entry.point];
    if (distinct.places_mm.empty() || distinct.places_mm.back() != p) {
      distinct.places_mm.push_back(p);
      distinct.first_point.push_back(entry.point);
    }
    distinct.place_of_point[entry.point] =
        static_cast<std::uint32_t>(distinct.places_mm.size() - 1);
  }
  return distinct;
}

std::vector<std::uint32_t> PointsPerPlace(const DistinctPlaces& places) {
  std::vector<std::uint32_t> points(places.places_mm.size(), 0);
  for (const std::uint32_t place : places.place_of_point) ++points[place];
  return points;
}

}  // namespace intaglio::proof
