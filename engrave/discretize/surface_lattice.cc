#include "engrave/discretize/surface_lattice.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

// Scan conversion. Row j of a triangle runs between the two of its edges that have one
// end at or below and the other above it. Where an edge crosses the row is computed from
// its lower end, and a node on the crossing belongs to the right of it: two triangles
// that share the edge get the same number and one of them gets the node.

namespace intaglio::discretize {
namespace {

constexpr double kRowRatio = std::numbers::sqrt3 / 2;
// Where node (0, 0) lies, in steps and rows: somewhere where no model has its edges.
constexpr double kShiftU = 0.318, kShiftV = 0.273;

std::array<LatticeFrame, kLatticeFrames> MakeFrames() {
  const std::array<Vec3, kLatticeFrames> directions = {
      Vec3(0, 0, 1),  Vec3(0, 1, 0),  Vec3(1, 0, 0), Vec3(0, 1, 1),  Vec3(0, 1, -1),
      Vec3(1, 0, 1),  Vec3(1, 0, -1), Vec3(1, 1, 0), Vec3(1, -1, 0), Vec3(1, 1, 1),
      Vec3(1, 1, -1), Vec3(1, -1, 1), Vec3(-1, 1, 1)};
  std::array<LatticeFrame, kLatticeFrames> frames;
  for (std::size_t k = 0; k < kLatticeFrames; ++k) {
    const Vec3 w = directions[k].normalized();
    // Rows are horizontal: the front of the weld, which rises, meets them evenly.
    const Vec3 u = k == 0 ? Vec3(1, 0, 0) : Vec3(Vec3(0, 0, 1).cross(w).normalized());
    frames[k].uvw_from_glass << u.transpose(), w.cross(u).transpose(), w.transpose();
  }
  return frames;
}

/// Where an edge runs, in steps along u and rows along v; `low` is its lower end.
struct Side {
  Vec2 low, high;

  Side(const Vec2& a, const Vec2& b) : low(a), high(b) {
    if (b.y() < a.y()) std::swap(low, high);
  }
  bool Meets(double row) const { return low.y() <= row && row < high.y(); }
  double At(double row) const {
    return low.x() + (row - low.y()) * ((high.x() - low.x()) / (high.y() - low.y()));
  }
};

struct Interval1 {
  double low, high;
};

/// Between which values the `value`s at the corners lie where their heights are in the
/// range, which some are; a little more.
Interval1 Within(const HeightRange& range, const Vec3& heights, const Vec3& values) {
  Interval1 all{std::numeric_limits<double>::infinity(),
                -std::numeric_limits<double>::infinity()};
  const auto add = [&all](double value) {
    all.low = std::min(all.low, value - 1);
    all.high = std::max(all.high, value + 1);
  };
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    if (range.Contains(heights[a])) add(values[a]);
    for (const double z : {range.low_mm, range.high_mm}) {
      if ((heights[a] < z) == (heights[b] < z)) continue;
      const double at = (z - heights[a]) / (heights[b] - heights[a]);
      add(values[a] + at * (values[b] - values[a]));
    }
  }
  return all;
}

}  // namespace

const std::array<LatticeFrame, kLatticeFrames>& LatticeFrames() {
  static const std::array<LatticeFrame, kLatticeFrames> frames = MakeFrames();
  return frames;
}

const LatticeFrame& FrameFor(const Vec3& normal) {
  const auto& frames = LatticeFrames();
  std::size_t best = 0;
  double most = -1;
  for (std::size_t k = 0; k < kLatticeFrames; ++k) {
    const double along = std::abs(frames[k].uvw_from_glass.row(2).dot(normal));
    if (along > most) {
      most = along;
      best = k;
    }
  }
  return frames[best];
}

void ForEachNode(
    const Corners& corners, const Vec3& normal, const LatticeFrame& frame, double step_mm,
    const HeightRange& range,
    const std::function<void(const Vec3&, std::int64_t, std::int64_t)>& visit) {
  const Mat3& turn = frame.uvw_from_glass;
  std::array<Vec2, 3> at;
  Vec3 w_mm, rows, z_mm;
  for (int i = 0; i < 3; ++i) {
    const Vec3 q = turn * corners[i];
    at[i] = Vec2(q.x() / step_mm - kShiftU, q.y() / (kRowRatio * step_mm) - kShiftV);
    w_mm[i] = q.z();
    rows[i] = at[i].y();
    z_mm[i] = corners[i].z();
  }
  Interval1 row_range{rows.minCoeff(), rows.maxCoeff()};
  const double z_low = z_mm.minCoeff(), z_high = z_mm.maxCoeff();
  const bool whole = range.Contains(z_low) && range.Contains(z_high);
  if (!whole) {
    const Interval1 within = Within(range, z_mm, rows);
    row_range.low = std::max(row_range.low, within.low);
    row_range.high = std::min(row_range.high, within.high);
  }
  if (!(row_range.low < row_range.high)) return;
  const Side sides[3] = {{at[0], at[1]}, {at[1], at[2]}, {at[2], at[0]}};
  // The plane: w falls by slope for each mm of u and v.
  const Vec3 n = turn * normal;
  const Vec2 slope = n.z() == 0 ? Vec2(0, 0) : Vec2(n.x() / n.z(), n.y() / n.z());
  const double w_low = w_mm.minCoeff(), w_high = w_mm.maxCoeff();
  const Vec3 first = turn * corners[0];
  const double u0 = first.x(), v0 = first.y();
  // z rises by this for each step along a row.
  const double z_rise = (turn(0, 2) - turn(2, 2) * slope.x()) * step_mm;
  const auto place = [&](double step, double row) {
    const double u = (step + kShiftU) * step_mm;
    const double v = (row + kShiftV) * kRowRatio * step_mm;
    const double w = w_mm[0] - slope.x() * (u - u0) - slope.y() * (v - v0);
    Vec3 p = turn.transpose() * Vec3(u, v, std::clamp(w, w_low, w_high));
    p.z() = std::clamp(p.z(), z_low, z_high);
    return p;
  };
  const auto last = static_cast<std::int64_t>(std::ceil(row_range.high)) - 1;
  for (auto j = static_cast<std::int64_t>(std::ceil(row_range.low)); j <= last; ++j) {
    const auto row = static_cast<double>(j);
    double left = std::numeric_limits<double>::infinity(), right = -left;
    for (const Side& side : sides) {
      if (!side.Meets(row)) continue;
      const double x = side.At(row);
      left = std::min(left, x);
      right = std::max(right, x);
    }
    if (!(left < right)) continue;
    if (!whole && std::abs(z_rise) > 1e-6 * step_mm) {
      const double z_left = place(left, row).z();
      const double a = left + (range.low_mm - z_left) / z_rise;
      const double b = left + (range.high_mm - z_left) / z_rise;
      left = std::max(left, std::floor(std::min(a, b)) - 1);
      right = std::min(right, std::ceil(std::max(a, b)) + 1);
    }
    const double shift = 0.5 * row;
    const auto end = static_cast<std::int64_t>(std::ceil(right - shift));
    for (auto i = static_cast<std::int64_t>(std::ceil(left - shift)); i < end; ++i) {
      const Vec3 p = place(static_cast<double>(i) + shift, row);
      if (whole || range.Contains(p.z())) visit(p, i, j);
    }
  }
}

}  // namespace intaglio::discretize
