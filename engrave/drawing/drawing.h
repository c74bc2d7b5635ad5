#pragma once

// A drawing as curves, read from DXF, SVG, HPGL, NCI or made of text. Frame: drawing, mm,
// x to the right, y up, z towards the viewer; flat files lie at z = 0. Pieces are exact
// and stay so under every affine transform, so they are flattened only at their final
// place.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "engrave/core/findings.h"
#include "engrave/core/geometry.h"

namespace intaglio::drawing {

/// Straight from point to point; at least one point. A single one is a point of the
/// drawing.
struct Polyline {
  PointList points_mm;
};

/// center + axis_u cos t + axis_v sin t, t from begin_rad over sweep_rad, |sweep| <= 2
/// pi. The axes are conjugate, not always at right angles: so affine images are exact.
struct EllipticArc {
  Vec3 center_mm = Vec3::Zero();
  Vec3 axis_u_mm = Vec3::Zero();
  Vec3 axis_v_mm = Vec3::Zero();
  double begin_rad = 0;
  double sweep_rad = 0;
};

struct CubicBezier {
  std::array<Vec3, 4> control_mm;
};

/// Of drawings of other programs: CAD writes 3, rarely 5.
inline constexpr int kMaxSplineDegree = 15;

/// From knots[degree] to knots[control count]. Knots ascend, one more than the control
/// points and the degree together; the weights are positive, none: all are 1.
struct Nurbs {
  int degree = 3;
  std::vector<double> knots;
  PointList control_mm;
  std::vector<double> weights;
};

using Piece = std::variant<Polyline, EllipticArc, CubicBezier, Nurbs>;

/// Pieces one behind the other; where an end and the next beginning differ, a straight
/// line joins them.
struct Curve {
  std::vector<Piece> pieces;
  bool closed = false;  ///< the end is joined to the beginning
  std::uint32_t layer =
      0;  ///< into Drawing::names; DXF layer, SVG group, HPGL pen, NCI tool
  std::uint32_t color = 0;  ///< into Drawing::names; DXF colour number, SVG stroke
};

struct Drawing {
  std::vector<Curve> curves;
  std::vector<std::string> names{std::string()};  ///< the first is "no name"
  /// Length of a unit of the file's numbers, mm, by which they are multiplied already.
  double unit_mm = 1;
  /// What the file holds and the curves do not obey: "TEXT", "image", "LB", "mask".
  FileFindings findings;
};

/// Limits on the time and memory of reading; beyond them: ErrorCode::kTooLarge. The
/// defaults keep the reading of any file under 2 s and 512 MB.
struct DrawingLimits {
  std::uint64_t max_file_bytes = std::uint64_t{64} << 20;
  /// Entities after blocks and references are unfolded; SVG: also elements of the file.
  std::uint64_t max_entities = 500'000;
  /// Points and control points of all curves.
  std::uint64_t max_points = 3'000'000;
  /// Blocks within blocks, groups and references within each other.
  int max_nesting = 64;
  /// Unfolding reads the bytes of a block or reference again each time; this is the limit
  /// of their sum.
  std::uint64_t max_unfolded_bytes = std::uint64_t{128} << 20;
  /// Farthest coordinate from the origin, mm.
  double max_coordinate_mm = 1e9;
};

}  // namespace intaglio::drawing
