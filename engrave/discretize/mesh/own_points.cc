#include "engrave/discretize/mesh/own_points.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace intaglio::discretize {
namespace {

constexpr std::size_t kFirstSlots = 1024;

bool IsLower(const Vec3& a, const Vec3& b) {
  return std::tuple(a.z(), a.y(), a.x()) < std::tuple(b.z(), b.y(), b.x());
}

bool IsBetter(const OnePerCube::Point& a, const OnePerCube::Point& b) {
  if (a.on_edge != b.on_edge) return b.on_edge;
  if (a.p_mm != b.p_mm) return IsLower(a.p_mm, b.p_mm);
  return a.triangle < b.triangle;
}

std::uint64_t Mixed(std::uint64_t x) {  // the last step of splitmix64
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

}  // namespace

OnePerCube::OnePerCube(double side_mm) : side_mm_(side_mm), slots_(kFirstSlots, 0) {}

OnePerCube::Cube OnePerCube::CubeOf(const Vec3& p_mm) const {
  Cube cube;
  for (int axis = 0; axis < 3; ++axis) {
    cube[axis] = static_cast<std::int64_t>(std::floor(p_mm[axis] / side_mm_));
  }
  return cube;
}

HeightRange OnePerCube::WholeCubes(const HeightRange& range) const {
  // The heights of a cube are computed by the same quotient as the cube's number, so one
  // more side at both ends is enough.
  return {(std::floor(range.low_mm / side_mm_) - 1) * side_mm_,
          (std::ceil(range.high_mm / side_mm_) + 1) * side_mm_};
}

std::size_t OnePerCube::SlotOf(const Cube& cube) const {
  std::uint64_t hash = 0;
  for (const std::int64_t n : cube) hash = Mixed(hash + static_cast<std::uint64_t>(n));
  std::size_t slot = hash & (slots_.size() - 1);
  while (slots_[slot] != 0 && cubes_[slots_[slot] - 1] != cube) {
    slot = (slot + 1) & (slots_.size() - 1);
  }
  return slot;
}

void OnePerCube::Add(const Point& point) {
  const Cube cube = CubeOf(point.p_mm);
  const std::size_t slot = SlotOf(cube);
  if (slots_[slot] == 0) {
    points_.push_back(point);
    cubes_.push_back(cube);
    slots_[slot] = static_cast<std::uint32_t>(points_.size());
    if (2 * points_.size() > slots_.size()) Grow();
  } else if (Point& there = points_[slots_[slot] - 1]; IsBetter(point, there)) {
    there = point;
  }
}

void OnePerCube::Grow() {
  slots_.assign(2 * slots_.size(), 0);
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    slots_[SlotOf(cubes_[i])] = static_cast<std::uint32_t>(i + 1);
  }
}

void AddCorners(const Corners& corners, const std::array<bool, 3>& which,
                const HeightRange& range, std::uint32_t triangle, OnePerCube& points) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (which[i] && range.Contains(corners[i].z())) {
      points.Add({corners[i], triangle, false});
    }
  }
}

void AddEdges(const Corners& corners, double step_mm, const HeightRange& range,
              std::uint32_t triangle, OnePerCube& points) {
  for (std::size_t side = 0; side < 3; ++side) {
    Vec3 a = corners[side], b = corners[(side + 1) % 3];
    if (IsLower(b, a)) std::swap(a, b);
    const double parts = std::ceil((b - a).norm() / step_mm);
    // Part i lies at a + (b - a) i / parts; those in the range, and one more on each
    // side.
    double first = 1, last = parts - 1;
    if (const double rise = b.z() - a.z(); rise > 0) {
      first = std::max(first, std::floor((range.low_mm - a.z()) / rise * parts) - 1);
      last = std::min(last, std::ceil((range.high_mm - a.z()) / rise * parts) + 1);
    }
    for (double i = first; i <= last; ++i) {
      const Vec3 p = a + (b - a) * (i / parts);
      if (range.Contains(p.z())) points.Add({p, triangle, true});
    }
  }
}

}  // namespace intaglio::discretize
