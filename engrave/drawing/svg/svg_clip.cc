#include "engrave/drawing/svg/svg_clip.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engrave/drawing/flatten.h"
#include "engrave/drawing/pieces.h"

// Sutherland and Hodgman (1974), "Reentrant polygon clipping": a polygon is cut by one
// half-plane after the other. Where the result has several parts they hang together by
// edges along the clip, which enclose nothing. A line is cut to the interval of its
// parameter in which it is inside of all half-planes (Cyrus and Beck, 1978).

namespace intaglio::drawing {
namespace {

using Points = std::vector<Vec2>;

// Corners of a flattened circle turn by far more; of a rounding error by less.
constexpr double kConvexSlack = 1e-9;

double Cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

std::optional<FlatCurve> FlatOf(const Curve& curve) {
  Drawing one;
  one.curves.push_back(curve);
  auto flat = Flatten(one);
  if (!flat || flat->curves.size() != 1) return std::nullopt;
  return std::move(flat->curves.front());
}

/// Positive inside of the half-plane to the left of the side.
double Inside(const Vec2& from, const Vec2& to, const Vec2& p) {
  return Cross(to - from, p - from);
}

Points CutPolygon(const Points& polygon, const Vec2& from, const Vec2& to) {
  Points cut;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2& p = polygon[i];
    const Vec2& q = polygon[(i + 1) % polygon.size()];
    const double a = Inside(from, to, p), b = Inside(from, to, q);
    if (a >= 0) cut.push_back(p);
    if ((a < 0) != (b < 0)) cut.emplace_back(p + (q - p) * (a / (a - b)));
  }
  return cut;
}

/// The share of the segment within the clip; nothing when it is outside.
std::optional<std::pair<double, double>> ShareInside(const ConvexClip& clip,
                                                     const Vec2& p, const Vec2& q) {
  double begin = 0, end = 1;
  for (std::size_t i = 0; i < clip.corners_mm.size(); ++i) {
    const Vec2& from = clip.corners_mm[i];
    const Vec2& to = clip.corners_mm[(i + 1) % clip.corners_mm.size()];
    const double a = Inside(from, to, p), b = Inside(from, to, q);
    if (a < 0 && b < 0) return std::nullopt;
    if (a < 0) begin = std::max(begin, a / (a - b));
    if (b < 0) end = std::min(end, a / (a - b));
  }
  if (begin > end) return std::nullopt;
  return std::pair(begin, end);
}

Curve CurveLike(const Curve& model, const Points& points, bool closed) {
  Polyline line;
  for (const Vec2& p : points) line.points_mm.emplace_back(p.x(), p.y(), 0);
  return {{std::move(line)}, closed, model.layer, model.color};
}

void CutLine(const Curve& model, const Points& points, bool closed,
             const ConvexClip& clip, std::vector<Curve>& clipped) {
  Points open;
  const auto end_line = [&] {
    if (open.size() > 1) clipped.push_back(CurveLike(model, open, false));
    open.clear();
  };
  const std::size_t count = closed ? points.size() : points.size() - 1;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec2& p = points[i];
    const Vec2& q = points[(i + 1) % points.size()];
    const auto share = ShareInside(clip, p, q);
    if (!share || share->first > 0) end_line();
    if (!share) continue;
    if (open.empty()) open.emplace_back(p + share->first * (q - p));
    open.emplace_back(p + share->second * (q - p));
    if (share->second < 1) end_line();
  }
  end_line();
}

}  // namespace

void ToPage(const SvgTransform& t, Piece& piece) {
  Mat3 linear = Mat3::Identity();
  linear.topLeftCorner<2, 2>() << t.a, t.c, t.b, t.d;
  Transform(linear, Vec3(t.e, t.f, 0), piece);
}

Curve SvgBoxOf(const SvgTransform& transform, const Vec2& size) {
  const Vec3 right(size.x(), 0, 0), down(0, size.y(), 0);
  Curve box{{Polyline{{Vec3::Zero(), right, right + down, down}}}, true};
  ToPage(transform, box.pieces.front());
  return box;
}

std::optional<ConvexClip> ConvexClipOf(const Curve& curve) {
  const auto flat = FlatOf(curve);
  if (!flat || flat->points_mm.size() < 3) return std::nullopt;
  ConvexClip clip;
  for (const Vec3& p : flat->points_mm) clip.corners_mm.emplace_back(p.x(), p.y());
  Points& corners = clip.corners_mm;
  const std::size_t n = corners.size();
  double area = 0, turn = 0;
  for (std::size_t i = 0; i < n; ++i) area += Cross(corners[i], corners[(i + 1) % n]);
  if (area < 0) std::reverse(corners.begin(), corners.end());
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 a = corners[(i + 1) % n] - corners[i];
    const Vec2 b = corners[(i + 2) % n] - corners[(i + 1) % n];
    if (Cross(a, b) < -kConvexSlack * a.norm() * b.norm()) return std::nullopt;
    turn += std::atan2(Cross(a, b), a.dot(b));
  }
  // A star turns to one side, too, but more than once.
  if (area == 0 || turn > 7) return std::nullopt;
  return clip;
}

bool ClipCurve(const Curve& curve, bool filled, const ConvexClip& clip,
               DrawingBuilder& builder, std::vector<Curve>& clipped) {
  const auto flat = FlatOf(curve);
  if (!flat || flat->points_mm.empty()) return true;
  Points points;
  for (const Vec3& p : flat->points_mm) points.emplace_back(p.x(), p.y());
  if (!builder.CountUnfolded(points.size() * clip.corners_mm.size(), "clip-path"))
    return false;
  const bool within = std::ranges::all_of(points, [&](const Vec2& p) {
    const auto share = ShareInside(clip, p, p);
    return share.has_value();
  });
  if (within) {
    clipped.push_back(curve);
  } else if (!filled || points.size() < 3) {
    CutLine(curve, points, flat->closed, clip, clipped);
  } else {
    const std::size_t n = clip.corners_mm.size();
    for (std::size_t i = 0; i < n && !points.empty(); ++i) {
      points = CutPolygon(points, clip.corners_mm[i], clip.corners_mm[(i + 1) % n]);
    }
    if (points.size() > 2) clipped.push_back(CurveLike(curve, points, true));
  }
  return true;
}

}  // namespace intaglio::drawing
