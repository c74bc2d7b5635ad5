#include "engrave/drawing/flatten.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/core/check.h"
#include "engrave/drawing/control_polygon.h"
#include "engrave/drawing/pieces.h"

namespace intaglio::drawing {
namespace {

// Below a thousandth of the finest tolerance two points are one.
constexpr double kSamePoint_mm = 1e-9;
// Ends of pieces come from different formulas: they are one point within rounding.
constexpr double kSameEnd_mm = 1e-6;
constexpr int kMaxHalvings = 20;

/// Whether the turn from u to v is at most an angle below a right one, of this tangent.
/// The tangents decide it but where they are equal to rounding, where the angles do.
bool TurnsAtMost(const Vec3& u, const Vec3& v, double angle_rad, double tangent) {
  constexpr double kRounding = 1e-9;
  const double across = u.cross(v).norm(), along = u.dot(v);
  if (across < (1 - kRounding) * tangent * along) return true;
  if (across > (1 + kRounding) * tangent * along) return false;
  return std::atan2(across, along) <= angle_rad;
}

class Flattener {
 public:
  explicit Flattener(const FlattenOptions& options)
      : options_(options), max_tangent_(std::tan(options.max_turn_rad)) {}

  FlatCurve Flat(const Curve& curve) {
    flat_ = FlatCurve{{}, curve.closed, curve.layer, curve.color};
    for (const Piece& piece : curve.pieces) {
      std::visit([&](const auto& p) { Add(p); }, piece);
      if (too_many()) break;
    }
    auto& points = flat_.points_mm;
    if (points.size() > 3 && (points.front() - points.back()).norm() <= kSameEnd_mm) {
      flat_.closed = true;
    }
    while (flat_.closed && points.size() > 1 &&
           (points.front() - points.back()).norm() <= kSameEnd_mm) {
      points.pop_back();
    }
    // Two points have no inside; a line in both directions would double its points.
    if (points.size() < 3) flat_.closed = false;
    total_ += points.size();
    return std::move(flat_);
  }

  bool too_many() const { return total_ + flat_.points_mm.size() > options_.max_points; }

 private:
  void Push(const Vec3& p, double same_mm = kSamePoint_mm) {
    auto& points = flat_.points_mm;
    if (points.empty() || (points.back() - p).norm() > same_mm) points.push_back(p);
  }

  void Add(const Polyline& line) {
    Push(line.points_mm.front(), kSameEnd_mm);
    for (std::size_t i = 1; i < line.points_mm.size(); ++i) Push(line.points_mm[i]);
  }
  void Add(const EllipticArc& arc) {
    const double eighths = std::abs(arc.sweep_rad) / (std::numbers::pi / 4);
    Follow([&](double t) { return PointAt(arc, t); }, 0, 1,
           std::clamp(static_cast<int>(std::ceil(eighths)), 1, 8), ArcPart(arc, 0, 1));
  }
  void Add(const CubicBezier& bezier) {
    Follow([&](double t) { return PointAt(bezier, t); }, 0, 1, 4, ControlPolygon(bezier));
  }
  void Add(const Nurbs& nurbs) {
    const auto degree = static_cast<std::size_t>(nurbs.degree);
    const auto at = [&](double u) { return PointAtKnot(nurbs, u); };
    Push(at(nurbs.knots[degree]), kSameEnd_mm);
    for (std::size_t i = degree; i < nurbs.control_mm.size(); ++i) {
      if (nurbs.knots[i + 1] <= nurbs.knots[i]) continue;
      if (too_many()) return;
      // The span's last value belongs to the next span, whose curve may begin elsewhere
      // only when a knot is as manifold as the degree plus one.
      Follow(at, nurbs.knots[i], nurbs.knots[i + 1],
             nurbs.degree == 1 ? 1 : nurbs.degree + 1, ControlPolygon(nurbs, i));
    }
  }

  /// From t = begin to end in `parts` equal parts, each halved until it is straight
  /// enough. `rest`: the control of the whole, ControlPolygon or ArcPart.
  template <typename At, typename Control>
  void Follow(const At& at, double begin, double end, int parts, Control rest) {
    Vec3 from = at(begin);
    Push(from, kSameEnd_mm);
    double low = begin;
    for (int i = 1; i <= parts; ++i) {
      const double high = i == parts ? end : begin + (end - begin) * i / parts;
      const Vec3 to = at(high);
      const auto [part, others] = rest.SplitAt(1.0 / (parts - i + 1));
      Halve(at, low, from, high, to, part, 0);
      rest = others;
      low = high;
      from = to;
    }
  }

  template <typename At, typename Control>
  void Halve(const At& at, double low, const Vec3& from, double high, const Vec3& to,
             const Control& control, int halvings) {
    const double middle = 0.5 * (low + high);
    const Vec3 between = at(middle);
    const Vec3 first = between - from, second = to - between;
    // At a cusp the turn never becomes small: there the tolerance alone decides. A bend
    // that is narrow shows in the control alone: the middle can lie on the chord of a
    // part that goes beyond its end and comes back.
    const double tolerance_mm = options_.chord_tolerance_mm;
    const bool straight =
        (first.norm() + second.norm() <= tolerance_mm &&
         control.IsWithin(tolerance_mm)) ||
        (TurnsAtMost(first, second, options_.max_turn_rad, max_tangent_) &&
         control.FollowsChord(tolerance_mm));
    if (straight || halvings == kMaxHalvings || too_many()) {
      Push(between);
      Push(to);
      return;
    }
    const auto [left, right] = control.SplitAt(0.5);
    Halve(at, low, from, middle, between, left, halvings + 1);
    Halve(at, middle, between, high, to, right, halvings + 1);
  }

  FlattenOptions options_;
  double max_tangent_;
  FlatCurve flat_;
  std::uint64_t total_ = 0;
};

}  // namespace

Result<FlatDrawing> Flatten(const Drawing& drawing, const FlattenOptions& options) {
  Require(options.chord_tolerance_mm >= 1e-6 && options.chord_tolerance_mm <= 1,
          "chord_tolerance_mm must be 1e-6 .. 1, is {}", options.chord_tolerance_mm);
  Require(options.max_turn_rad >= 0.01 && options.max_turn_rad <= 1,
          "max_turn_rad must be 0.01 .. 1, is {}", options.max_turn_rad);
  FlatDrawing flat;
  flat.curves.reserve(drawing.curves.size());
  Flattener flattener(options);
  for (const Curve& curve : drawing.curves) {
    FlatCurve next = flattener.Flat(curve);
    if (flattener.too_many()) {
      return Fail(
          ErrorCode::kTooLarge,
          fmt::format(
              "the drawing's curves need more than {} points at a chord tolerance of {} "
              "mm; make the drawing smaller or the tolerance larger",
              options.max_points, options.chord_tolerance_mm));
    }
    if (!next.points_mm.empty()) flat.curves.push_back(std::move(next));
  }
  return flat;
}

std::optional<FlatCurve> FlattenCurve(const Curve& curve) {
  Flattener flattener{FlattenOptions()};
  FlatCurve flat = flattener.Flat(curve);
  if (flattener.too_many() || flat.points_mm.empty()) return std::nullopt;
  return flat;
}

}  // namespace intaglio::drawing
