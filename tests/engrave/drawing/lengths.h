#pragma once

#include <fstream>
#include <iterator>
#include <string>

#include "engrave/drawing/flatten.h"

namespace intaglio::drawing {

inline double LengthOf(const FlatCurve& curve) {
  double length_mm = 0;
  for (std::size_t i = 1; i < curve.points_mm.size(); ++i) {
    length_mm += (curve.points_mm[i] - curve.points_mm[i - 1]).norm();
  }
  if (curve.closed)
    length_mm += (curve.points_mm.front() - curve.points_mm.back()).norm();
  return length_mm;
}

/// Length of t -> (x, y, z) over 0..1 by chords much finer than any flattening.
template <typename At>
double DenseLength(const At& at, int steps = 200'000) {
  double length = 0;
  Vec3 last = at(0.0);
  for (int i = 1; i <= steps; ++i) {
    const Vec3 next = at(static_cast<double>(i) / steps);
    length += (next - last).norm();
    last = next;
  }
  return length;
}

/// The extent of all points, mm; empty when there are none.
inline Box3 ExtentOf(const FlatDrawing& flat) {
  Box3 box;
  for (const FlatCurve& curve : flat.curves) {
    for (const Vec3& p : curve.points_mm) box.Extend(p);
  }
  return box;
}

/// Shoelace area in the plane z = const, counter-clockwise positive.
inline double AreaOf(const FlatCurve& curve) {
  double twice = 0;
  const auto& p = curve.points_mm;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vec3& q = p[(i + 1) % p.size()];
    twice += p[i].x() * q.y() - q.x() * p[i].y();
  }
  return twice / 2;
}

/// Empty when the file is absent.
inline std::string FileText(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace intaglio::drawing
