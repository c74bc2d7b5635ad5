#include "engrave/discretize/drawing/curve_points.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/discretize/drawing/fill_outline.h"
#include "engrave/discretize/spacing/candidate_limit.h"
#include "engrave/discretize/spacing/contour_points.h"
#include "engrave/discretize/spacing/fixed_points.h"

namespace intaglio::discretize {
namespace {

using drawing::FlatCurve;
using drawing::FlatDrawing;

// Tolerance within which a curve counts as flat: a hundredth of a crack.
constexpr double kFlat_mm = 0.001;

void CheckOptions(const CurveOptions& o) {
  Require(o.distance_mm >= 0.01 && o.distance_mm <= 100,
          "distance_mm must be 0.01 .. 100, is {}", o.distance_mm);
  Require(o.layer_count >= 1 && o.layer_count <= 10, "layer_count must be 1 .. 10, is {}",
          o.layer_count);
  Require(o.layer_distance_mm >= 0 && o.layer_distance_mm <= 50,
          "layer_distance_mm must be 0 .. 50, is {}", o.layer_distance_mm);
  Require(o.layer_count == 1 || o.layer_distance_mm > 0,
          "layer_distance_mm must be positive for {} layers", o.layer_count);
  Require(o.layer_direction.allFinite() && o.layer_direction.norm() > 0,
          "layer_direction must be finite and not zero");
  Require(o.twist_phase_ratio >= 0 && o.twist_phase_ratio <= 1,
          "twist_phase_ratio must be 0 .. 1, is {}", o.twist_phase_ratio);
  Require(o.corner_rad >= 0.1 && o.corner_rad <= 3, "corner_rad must be 0.1 .. 3, is {}",
          o.corner_rad);
}

double LengthOf(const PointList& points, bool closed) {
  double length = closed ? (points.front() - points.back()).norm() : 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    length += (points[i] - points[i - 1]).norm();
  }
  return length;
}

double TurnAt(const Vec3& before, const Vec3& at, const Vec3& after) {
  const Vec3 u = at - before, v = after - at;
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

/// The points of one curve in one layer.
class CurvePoints {
 public:
  CurvePoints(const CurveOptions& options, double phase_ratio)
      : options_(options),
        spacing_{options.distance_mm, phase_ratio, options.insert_end_points} {}

  void Add(const FlatCurve& curve, PointList& points) const {
    PointList contour = curve.points_mm;
    if (!options_.keep_corners || contour.size() < 3) {
      AddContourPoints(contour, curve.closed, spacing_, points);
      return;
    }
    if (curve.closed && !BeginAtCorner(contour)) {
      AddContourPoints(contour, true, spacing_, points);
      return;
    }
    if (curve.closed) contour.push_back(contour.front());
    const std::vector<std::size_t> cuts = Cuts(contour);
    if (!curve.closed && cuts.size() == 2) {
      AddContourPoints(contour, false, spacing_, points);
    } else {
      AddRuns(contour, cuts, curve.closed, points);
    }
  }

 private:
  bool IsCorner(const Vec3& before, const Vec3& at, const Vec3& after) const {
    return TurnAt(before, at, after) >= options_.corner_rad;
  }

  /// Turns the ring so that it begins at its first corner; false: it has none.
  bool BeginAtCorner(PointList& ring) const {
    const std::size_t n = ring.size();
    for (std::size_t i = 0; i < n; ++i) {
      if (!IsCorner(ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n])) continue;
      std::rotate(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(i),
                  ring.end());
      return true;
    }
    return false;
  }

  /// Where the line is cut: its ends, and corners that keep the distance along it from
  /// the one before and from the end.
  std::vector<std::size_t> Cuts(const PointList& line) const {
    const double whole = LengthOf(line, false);
    std::vector<std::size_t> cuts{0};
    double at_mm = 0, last_mm = 0;
    for (std::size_t i = 1; i + 1 < line.size(); ++i) {
      at_mm += (line[i] - line[i - 1]).norm();
      if (at_mm - last_mm < options_.distance_mm ||
          whole - at_mm < options_.distance_mm ||
          !IsCorner(line[i - 1], line[i], line[i + 1])) {
        continue;
      }
      cuts.push_back(i);
      last_mm = at_mm;
    }
    cuts.push_back(line.size() - 1);
    return cuts;
  }

  /// Equal arc length from cut to cut. Each run has a point at its beginning, or, of a
  /// closed line, the phase's share of its step behind that. If an open line keeps no end
  /// points, its points begin and end half a distance inside.
  void AddRuns(const PointList& line, const std::vector<std::size_t>& cuts, bool closed,
               PointList& points) const {
    std::vector<double> arc_mm(line.size(), 0);
    for (std::size_t i = 1; i < line.size(); ++i) {
      arc_mm[i] = arc_mm[i - 1] + (line[i] - line[i - 1]).norm();
    }
    const bool short_ends = !closed && !options_.insert_end_points;
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      const bool last = i + 2 == cuts.size();
      const double begin_mm = arc_mm[cuts[i]];
      ContourSteps steps = StepsOfRun(arc_mm[cuts[i + 1]] - begin_mm,
                                      short_ends && i == 0, short_ends && last);
      steps.first_mm += begin_mm + (closed ? spacing_.phase_ratio * steps.step_mm : 0);
      steps.end_point = last && !closed && !short_ends;
      AddSteps({line, arc_mm}, steps, cuts[i], cuts[i + 1], points);
    }
  }

  /// A run of n steps, and half a one at each end that is short.
  ContourSteps StepsOfRun(double length_mm, bool short_begin, bool short_end) const {
    const double halves = (short_begin ? 0.5 : 0) + (short_end ? 0.5 : 0);
    const double fitting = length_mm / (options_.distance_mm * kChordAllowance) - halves;
    const double parts = std::max(1.0, std::floor(fitting));
    const double step_mm = length_mm / (parts + halves);
    return {short_begin ? step_mm / 2 : 0, step_mm,
            static_cast<std::size_t>(parts) + (short_end ? 1 : 0), false};
  }

  const CurveOptions& options_;
  ContourSpacing spacing_;
};

/// Newell's normal, as long as twice the area.
Vec3 NormalOf(const PointList& ring) {
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
    normal += (ring[i] - ring[0]).cross(ring[i + 1] - ring[0]);
  }
  return normal;
}

/// Rows along the glass's x as far as the plane has one, else along its y.
Mat3 PlaneAxes(const Vec3& normal) {
  const Vec3 z = normal.normalized();
  const Vec3 along = std::abs(z.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
  const Vec3 x = (along - along.dot(z) * z).normalized();
  Mat3 axes;
  axes << x, z.cross(x), z;
  return axes;
}

/// Fills the closed curves of a drawing, plane by plane.
class PlaneFill {
 public:
  PlaneFill(const CurveOptions& options, PointList& points)
      : options_(options), points_(points) {}

  Status Add(const FlatDrawing& placed) {
    std::vector<std::pair<double, const FlatCurve*>> rings;
    Vec3 normal = Vec3::Zero();
    for (const FlatCurve& curve : placed.curves) {
      if (!curve.closed) continue;
      const Vec3 own = NormalOf(curve.points_mm);
      if (own.norm() > normal.norm()) normal = own;
      rings.emplace_back(0, &curve);
    }
    if (!(normal.norm() > 0)) return {};
    axes_ = PlaneAxes(normal);
    for (auto& [height, ring] : rings) {
      height = axes_.col(2).dot(ring->points_mm.front());
      if (auto ok = CheckFlat(*ring, height); !ok) return ok;
    }
    std::ranges::stable_sort(rings, {}, [](const auto& ring) { return ring.first; });
    for (std::size_t i = 0; i < rings.size();) {
      std::size_t end = i;
      while (end < rings.size() && rings[end].first - rings[i].first <= kFlat_mm) ++end;
      INTAGLIO_TRY(FillPlane(std::span(rings).subspan(i, end - i)));
      i = end;
    }
    return {};
  }

 private:
  using Rings = std::span<const std::pair<double, const FlatCurve*>>;

  Status CheckFlat(const FlatCurve& ring, double height) const {
    for (const Vec3& p : ring.points_mm) {
      const double off_mm = std::abs(axes_.col(2).dot(p) - height);
      if (off_mm <= kFlat_mm) continue;
      return Fail(ErrorCode::kUnsupported,
                  fmt::format("a closed curve at ({:.3f}, {:.3f}, {:.3f}) mm leaves the "
                              "drawing's plane by {:.4f} mm and cannot be filled; turn "
                              "off the fill or flatten the drawing",
                              p.x(), p.y(), p.z(), off_mm),
                  fmt::format("{}", off_mm));
    }
    return {};
  }

  Vec2 InPlane(const Vec3& p) const { return (axes_.transpose() * p).head<2>(); }

  /// `points_` holds the points of the outlines, of every plane.
  Status FillPlane(const Rings& rings) {
    const double height = rings.front().first;
    std::vector<std::vector<Vec2>> polygons;
    for (const auto& [own_height, ring] : rings) {
      auto& polygon = polygons.emplace_back();
      for (const Vec3& p : ring->points_mm) polygon.push_back(InPlane(p));
    }
    std::vector<Vec2> kept, inner;
    for (std::size_t i = 0; i < outline_count_; ++i) {
      const double off = std::abs(axes_.col(2).dot(points_[i]) - height);
      if (off < options_.distance_mm) kept.push_back(InPlane(points_[i]));
    }
    const OutlineFill fill{options_.distance_mm, options_.fill == CurveFill::kEvenOdd};
    INTAGLIO_TRY(AddInnerPoints(polygons, kept, fill, inner));
    for (const Vec2& p : inner) {
      points_.push_back(axes_ * Vec3(p.x(), p.y(), height));
    }
    return {};
  }

  const CurveOptions& options_;
  PointList& points_;
  std::size_t outline_count_ = points_.size();
  Mat3 axes_ = Mat3::Identity();
};

double TotalLength(const FlatDrawing& placed) {
  double length_mm = 0;
  for (const FlatCurve& curve : placed.curves) {
    length_mm += LengthOf(curve.points_mm, curve.closed);
  }
  return length_mm;
}

Result<PointList> LayerPoints(const FlatDrawing& placed, const CurveOptions& options,
                              int layer) {
  const double turned = options.twist_phase_ratio * layer;
  const CurvePoints curve_points(options, turned - std::floor(turned));
  PointList points;
  for (const FlatCurve& curve : placed.curves) curve_points.Add(curve, points);
  if (options.fill != CurveFill::kNone) {
    INTAGLIO_TRY(PlaneFill(options, points).Add(placed));
  }
  const Vec3 shift =
      options.layer_direction.normalized() * (options.layer_distance_mm * layer);
  for (Vec3& p : points) p += shift;
  return points;
}

}  // namespace

Result<std::unique_ptr<PointSource>> MakeCurvePoints(const FlatDrawing& placed,
                                                     const CurveOptions& options) {
  CheckOptions(options);
  const double expected =
      options.layer_count * (TotalLength(placed) / options.distance_mm +
                             static_cast<double>(placed.curves.size()));
  INTAGLIO_TRY(CheckCandidateCount(expected));
  SpacedCloud cloud;
  MethodStatistics statistics;
  for (int layer = 0; layer < options.layer_count; ++layer) {
    const PointList points = INTAGLIO_TRY(LayerPoints(placed, options, layer));
    const double count = static_cast<double>(cloud.size() + points.size());
    INTAGLIO_TRY(CheckCandidateCount(count));
    for (const Vec3& p : points) cloud.Add(p, 0);
    ++statistics.plane_count;
    for (const FlatCurve& curve : placed.curves) {
      ++(curve.closed ? statistics.closed_contour_count : statistics.open_contour_count);
    }
  }
  return MakeFixedPoints(std::move(cloud), statistics);
}

}  // namespace intaglio::discretize
