#include "engrave/discretize/mesh/surface_lattice.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

// Scan conversion. Row j of a triangle runs between the two of its edges that have one
// end at or below and the other above it. Where an edge crosses the row is computed from
// its lower end, and a node on the crossing belongs to its right side: two triangles that
// share the edge compute the same number, and exactly one of them gets the node.

namespace intaglio::discretize {
namespace {

constexpr double kRowRatio = std::numbers::sqrt3 / 2;
// The position of node (0, 0), in steps and rows: one on which the edges of a model
// hardly ever lie.
constexpr double kShiftU = 0.318, kShiftV = 0.273;

std::array<LatticeFrame, kLatticeFrames> MakeFrames() {
  const std::array<Vec3, kLatticeFrames> directions = {
      Vec3(0, 0, 1),  Vec3(0, 1, 0),  Vec3(1, 0, 0), Vec3(0, 1, 1),  Vec3(0, 1, -1),
      Vec3(1, 0, 1),  Vec3(1, 0, -1), Vec3(1, 1, 0), Vec3(1, -1, 0), Vec3(1, 1, 1),
      Vec3(1, 1, -1), Vec3(1, -1, 1), Vec3(-1, 1, 1)};
  std::array<LatticeFrame, kLatticeFrames> frames;
  for (std::size_t k = 0; k < kLatticeFrames; ++k) {
    const Vec3 w = directions[k].normalized();
    // Rows are horizontal: the front of the thinning, which rises, meets them evenly.
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

struct Span {
  double low, high;

  void Extend(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};
constexpr Span kNothing{std::numeric_limits<double>::infinity(),
                        -std::numeric_limits<double>::infinity()};

/// Between which values the `value`s at the corners lie where their heights are in the
/// range, which some are; a little more.
Span Within(const HeightRange& range, const Vec3& heights, const Vec3& values) {
  Span all = kNothing;
  const auto add = [&all](double value) {
    all.Extend(value - 1);
    all.Extend(value + 1);
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

/// One triangle in its frame.
class Scan {
 public:
  Scan(const Corners& corners, const Vec3& normal, const LatticeFrame& frame,
       double step_mm, const HeightRange& range)
      : turn_(frame.uvw_from_glass), step_mm_(step_mm), range_(range) {
    for (int i = 0; i < 3; ++i) {
      const Vec3 q = turn_ * corners[i];
      at_[i] = Vec2(q.x() / step_mm - kShiftU, q.y() / (kRowRatio * step_mm) - kShiftV);
      if (i == 0) first_mm_ = q;
      w_span_.Extend(q.z());
      z_span_.Extend(corners[i].z());
      z_mm_[i] = corners[i].z();
    }
    const Vec3 n = turn_ * normal;
    if (n.z() != 0) slope_ = Vec2(n.x() / n.z(), n.y() / n.z());
    z_rise_mm_ = (turn_(0, 2) - turn_(2, 2) * slope_.x()) * step_mm;
    whole_ = range.Contains(z_span_.low) && range.Contains(z_span_.high);
  }

  template <typename Visit>
  void ForEach(const Visit& visit) const {
    const Side sides[3] = {{at_[0], at_[1]}, {at_[1], at_[2]}, {at_[2], at_[0]}};
    const auto [from, to] = Rows();
    const double end_row = std::ceil(to);
    for (double row = std::ceil(from); row < end_row; ++row) {
      Span span = kNothing;
      for (const Side& side : sides) {
        if (side.Meets(row)) span.Extend(side.At(row));
      }
      if (!(span.low < span.high)) continue;
      if (!whole_) Narrow(row, span);
      const double shift = 0.5 * row;
      const auto j = static_cast<std::int64_t>(row);
      const auto end = static_cast<std::int64_t>(std::ceil(span.high - shift));
      for (auto i = static_cast<std::int64_t>(std::ceil(span.low - shift)); i < end;
           ++i) {
        const Vec3 p = Place(static_cast<double>(i) + shift, row);
        if (whole_ || range_.Contains(p.z())) visit(p, i, j);
      }
    }
  }

 private:
  /// Those that may have nodes in the range.
  Span Rows() const {
    const Vec3 rows(at_[0].y(), at_[1].y(), at_[2].y());
    const Span all{rows.minCoeff(), rows.maxCoeff()};
    if (whole_) return all;
    const Span within = Within(range_, z_mm_, rows);
    return {std::max(all.low, within.low), std::min(all.high, within.high)};
  }

  /// Removes the parts that are outside the range by more than a step.
  void Narrow(double row, Span& span) const {
    if (!(std::abs(z_rise_mm_) > 1e-6 * step_mm_)) return;
    const double z_mm = Place(span.low, row).z();
    const double a = span.low + (range_.low_mm - z_mm) / z_rise_mm_;
    const double b = span.low + (range_.high_mm - z_mm) / z_rise_mm_;
    span.low = std::max(span.low, std::floor(std::min(a, b)) - 1);
    span.high = std::min(span.high, std::ceil(std::max(a, b)) + 1);
  }

  /// On the triangle's plane, and within the heights of its corners whatever rounding
  /// does: w falls by slope_ for each mm of u and v.
  Vec3 Place(double step, double row) const {
    const double u = (step + kShiftU) * step_mm_;
    const double v = (row + kShiftV) * kRowRatio * step_mm_;
    const double w = first_mm_.z() - slope_.x() * (u - first_mm_.x()) -
                     slope_.y() * (v - first_mm_.y());
    Vec3 p = turn_.transpose() * Vec3(u, v, std::clamp(w, w_span_.low, w_span_.high));
    p.z() = std::clamp(p.z(), z_span_.low, z_span_.high);
    return p;
  }

  Mat3 turn_;
  double step_mm_;
  HeightRange range_;
  std::array<Vec2, 3> at_;  // corners, in steps and rows
  Vec3 first_mm_;           // the first corner in the frame
  Vec3 z_mm_;
  Span w_span_ = kNothing, z_span_ = kNothing;
  Vec2 slope_ = Vec2::Zero();
  double z_rise_mm_;  // for each step along a row
  bool whole_;        // in the range
};

}  // namespace

const std::array<LatticeFrame, kLatticeFrames>& LatticeFrames() {
  static const std::array<LatticeFrame, kLatticeFrames> frames = MakeFrames();
  return frames;
}

const LatticeFrame& FrameFor(const Vec3& normal) {
  const auto& frames = LatticeFrames();
  std::size_t best = 0;
  double largest = -1;
  for (std::size_t k = 0; k < kLatticeFrames; ++k) {
    const double along = std::abs(frames[k].uvw_from_glass.row(2).dot(normal));
    if (along > largest) {
      largest = along;
      best = k;
    }
  }
  return frames[best];
}

void ForEachNode(
    const Corners& corners, const Vec3& normal, const LatticeFrame& frame, double step_mm,
    const HeightRange& range,
    const std::function<void(const Vec3&, std::int64_t, std::int64_t)>& visit) {
  Scan(corners, normal, frame, step_mm, range).ForEach(visit);
}

}  // namespace intaglio::discretize
