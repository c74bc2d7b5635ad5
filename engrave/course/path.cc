#include "engrave/course/path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/core/check.h"
#include "engrave/core/try.h"

// An arc from a to b over the angle w has the radius |b - a| / (2 |sin(w / 2)|); its
// centre lies on the perpendicular through the middle m of the chord,
//   c = m + n / (2 tan(w / 2)),  n the chord turned left by 90 degrees.

namespace intaglio::course {
namespace {

Vec2 Left(const Vec2& v) { return {-v.y(), v.x()}; }

double Cross(const Vec2& p, const Vec2& q) { return p.x() * q.y() - p.y() * q.x(); }

Vec2 Turned(const Vec2& v, double angle_rad) {
  return std::cos(angle_rad) * v + std::sin(angle_rad) * Left(v);
}

Status CheckPiece(const Vec2& begin_mm, const Piece& piece, std::size_t number) {
  const auto refuse = [number](const std::string& what, double value) {
    return Fail(ErrorCode::kInvalidValue, fmt::format("piece {}: {}", number, what),
                fmt::format("{}", value));
  };
  for (const double x : {piece.end_mm.x(), piece.end_mm.y()}) {
    if (std::isfinite(x) && std::abs(x) <= kMaxCoordinateMm) continue;
    return refuse(fmt::format("the coordinate {} mm is outside -{}..{}", x,
                              kMaxCoordinateMm, kMaxCoordinateMm),
                  x);
  }
  if (!(piece.feed_mm_s >= kMinFeedMmS && piece.feed_mm_s <= kMaxFeedMmS)) {
    return refuse(fmt::format("feed_mm_s {} is outside {}..{}", piece.feed_mm_s,
                              kMinFeedMmS, kMaxFeedMmS),
                  piece.feed_mm_s);
  }
  if (!(std::abs(piece.sweep_rad) < 2 * std::numbers::pi)) {
    return refuse(fmt::format("sweep_rad {} is not within 2 pi", piece.sweep_rad),
                  piece.sweep_rad);
  }
  const double chord_mm = (piece.end_mm - begin_mm).norm();
  if (chord_mm < kMinSegmentMm) {
    return refuse(
        fmt::format("is {} mm long, less than {}; leave it out", chord_mm, kMinSegmentMm),
        chord_mm);
  }
  return {};
}

void AppendArc(const Vec2& begin_mm, const Piece& piece, std::vector<Segment>& out) {
  const Vec2 chord_mm = piece.end_mm - begin_mm;
  const double half_rad = piece.sweep_rad / 2;
  Segment arc;
  arc.center_mm = begin_mm + chord_mm / 2 +
                  Left(chord_mm) * (std::cos(half_rad) / std::sin(half_rad) / 2);
  arc.radius_mm = chord_mm.norm() / (2 * std::abs(std::sin(half_rad)));
  arc.feed_mm_s = piece.feed_mm_s;
  const auto count =
      std::max(1.0, std::ceil(std::abs(piece.sweep_rad) / kMaxSegmentTurnRad));
  arc.sweep_rad = piece.sweep_rad / count;
  arc.length_mm = arc.radius_mm * std::abs(arc.sweep_rad);
  Vec2 from_mm = begin_mm;
  for (int i = 1; i <= static_cast<int>(count); ++i) {
    arc.begin_mm = from_mm;
    arc.end_mm =
        i == static_cast<int>(count)
            ? piece.end_mm
            : Vec2(arc.center_mm + Turned(begin_mm - arc.center_mm, arc.sweep_rad * i));
    out.push_back(arc);
    from_mm = arc.end_mm;
  }
}

// Below it an arc deviates from its chord by less than a rounding error.
constexpr double kStraightSweepRad = 1e-9;

}  // namespace

Vec2 Segment::PointAt(double at_mm) const {
  if (straight()) return begin_mm + (end_mm - begin_mm) * (at_mm / length_mm);
  if (at_mm < 0) return begin_mm + DirectionAt(0) * at_mm;
  if (at_mm > length_mm) return end_mm + DirectionAt(length_mm) * (at_mm - length_mm);
  return center_mm + Turned(begin_mm - center_mm, sweep_rad * at_mm / length_mm);
}

Vec2 Segment::DirectionAt(double at_mm) const {
  if (straight()) return (end_mm - begin_mm) / length_mm;
  const double inside_mm = std::clamp(at_mm, 0.0, length_mm);
  const Vec2 from_center =
      Turned(begin_mm - center_mm, sweep_rad * inside_mm / length_mm) / radius_mm;
  return sweep_rad > 0 ? Left(from_center) : Vec2(-Left(from_center));
}

Foot NearestOn(const Segment& segment, const Vec2& point_mm) {
  if (segment.straight()) {
    const Vec2 along = (segment.end_mm - segment.begin_mm) / segment.length_mm;
    const Vec2 from_begin = point_mm - segment.begin_mm;
    const double at_mm = std::clamp(along.dot(from_begin), 0.0, segment.length_mm);
    return {(from_begin - at_mm * along).norm(), at_mm};
  }
  const Vec2 begin = segment.begin_mm - segment.center_mm;
  const Vec2 point = point_mm - segment.center_mm;
  const double sign = segment.sweep_rad > 0 ? 1 : -1;
  const double angle_rad = std::atan2(sign * Cross(begin, point), begin.dot(point));
  const double at_mm = angle_rad * segment.radius_mm;
  if (at_mm >= 0 && at_mm <= segment.length_mm) {
    return {std::abs(point.norm() - segment.radius_mm), at_mm};
  }
  const double to_begin_mm = (point_mm - segment.begin_mm).norm();
  const double to_end_mm = (point_mm - segment.end_mm).norm();
  return to_begin_mm <= to_end_mm ? Foot{to_begin_mm, 0}
                                  : Foot{to_end_mm, segment.length_mm};
}

Result<Path> Path::Make(const Vec2& begin_mm, std::span<const Piece> pieces) {
  if (pieces.empty()) {
    return Fail(ErrorCode::kMissing, "the path has no piece; give one line or arc");
  }
  if (!begin_mm.allFinite() || begin_mm.cwiseAbs().maxCoeff() > kMaxCoordinateMm) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("the begin {}, {} mm of the path is outside -{}..{}", begin_mm.x(),
                    begin_mm.y(), kMaxCoordinateMm, kMaxCoordinateMm));
  }
  std::vector<Segment> segments;
  segments.reserve(pieces.size());
  Vec2 from_mm = begin_mm;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Piece& piece = pieces[i];
    INTAGLIO_TRY(CheckPiece(from_mm, piece, i + 1));
    if (std::abs(piece.sweep_rad) > kStraightSweepRad) {
      AppendArc(from_mm, piece, segments);
    } else {
      Segment line;
      line.begin_mm = from_mm;
      line.end_mm = piece.end_mm;
      line.length_mm = (piece.end_mm - from_mm).norm();
      line.feed_mm_s = piece.feed_mm_s;
      segments.push_back(line);
    }
    from_mm = piece.end_mm;
  }
  return Path(std::move(segments));
}

Path::Path(std::vector<Segment> segments) : segments_(std::move(segments)) {
  node_s_mm_.reserve(segments_.size() + 1);
  node_s_mm_.push_back(0);
  for (const Segment& segment : segments_) {
    node_s_mm_.push_back(node_s_mm_.back() + segment.length_mm);
  }
}

double Path::greatest_feed_mm_s() const {
  return std::ranges::max_element(segments_, {}, &Segment::feed_mm_s)->feed_mm_s;
}

double Path::TurnAt(std::size_t node) const {
  const Vec2 before = DirectionBefore(node), behind = DirectionBehind(node);
  return std::atan2(Cross(before, behind), before.dot(behind));
}

Path Path::Part(std::size_t first, std::size_t last) const {
  Require(first < last && last <= segments_.size(), "part {}..{} of {} segments", first,
          last, segments_.size());
  return Path({segments_.begin() + static_cast<std::ptrdiff_t>(first),
               segments_.begin() + static_cast<std::ptrdiff_t>(last)});
}

Vec2 PathCursor::PointAt(double s_mm) {
  const auto& node_s_mm = path_.node_s_mm();
  const std::size_t last = path_.segment_count() - 1;
  if (segment_ < last && s_mm >= node_s_mm[segment_ + 1]) ++segment_;
  const bool here = (segment_ == 0 || s_mm >= node_s_mm[segment_]) &&
                    (segment_ == last || s_mm < node_s_mm[segment_ + 1]);
  if (!here) {
    const auto behind =
        std::upper_bound(node_s_mm.begin() + 1, node_s_mm.end() - 1, s_mm);
    segment_ = static_cast<std::size_t>(behind - node_s_mm.begin()) - 1;
  }
  return path_.segments()[segment_].PointAt(s_mm - node_s_mm[segment_]);
}

}  // namespace intaglio::course
