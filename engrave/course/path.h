#pragma once

// The path of a contour that is cut or marked without a stop of the beam: straight lines
// and arcs of a circle in the plane, one behind the other, each with its feed. Frame:
// drawing or glass, whichever the caller uses for all of it; mm, mm/s, rad.
//
// Long arcs are divided, so that the speed along them can be corrected node by node: no
// segment turns by more than kMaxSegmentTurnRad. Nodes are the ends of the segments;
// node 0 is the begin of the path.

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::course {

inline constexpr double kMaxSegmentTurnRad = 0.35;
inline constexpr double kMinFeedMmS = 0.01;
inline constexpr double kMaxFeedMmS = 10000;
/// Shorter segments are rounding errors of a drawing, not a shape.
inline constexpr double kMinSegmentMm = 1e-6;
inline constexpr double kMaxCoordinateMm = 1e6;

/// From the end of the piece before.
struct Piece {
  Vec2 end_mm = Vec2::Zero();
  double feed_mm_s = 0;  ///< kMinFeedMmS..kMaxFeedMmS
  /// 0: straight. Else an arc over this angle, counter-clockwise when positive; its size
  /// is below 2 pi, and the end differs from the begin.
  double sweep_rad = 0;
};

struct Segment {
  Vec2 begin_mm = Vec2::Zero(), end_mm = Vec2::Zero();
  Vec2 center_mm = Vec2::Zero();  ///< of an arc
  double radius_mm = 0;           ///< 0: straight
  double sweep_rad = 0;
  double length_mm = 0;
  double feed_mm_s = 0;

  bool straight() const { return radius_mm <= 0; }
  /// `at_mm` behind its begin. Outside 0..length_mm it goes on straight.
  Vec2 PointAt(double at_mm) const;
  /// Of unit length, along the motion.
  Vec2 DirectionAt(double at_mm) const;
};

/// The place of a segment that is nearest to a point.
struct Foot {
  double distance_mm = 0;
  double at_mm = 0;  ///< behind the segment's begin, 0..length_mm
};
Foot NearestOn(const Segment& segment, const Vec2& point_mm);

class Path {
 public:
  /// One piece or more. kInvalidValue with the piece's number, from 1: a coordinate that
  /// is not finite or beyond kMaxCoordinateMm, a feed or a sweep outside its range, a
  /// piece shorter than kMinSegmentMm. kMissing: no piece.
  static Result<Path> Make(const Vec2& begin_mm, std::span<const Piece> pieces);

  /// Each begins where the one before ends. Not empty.
  static Path Of(std::vector<Segment> segments) { return Path(std::move(segments)); }

  const std::vector<Segment>& segments() const { return segments_; }
  std::size_t segment_count() const { return segments_.size(); }
  std::size_t node_count() const { return segments_.size() + 1; }
  double length_mm() const { return node_s_mm_.back(); }
  double greatest_feed_mm_s() const;
  /// Arc length at each node, ascending from 0.
  const std::vector<double>& node_s_mm() const { return node_s_mm_; }
  const Vec2& node_mm(std::size_t node) const {
    return node == 0 ? segments_.front().begin_mm : segments_[node - 1].end_mm;
  }
  /// The change of direction at an inner node, -pi..pi, counter-clockwise positive.
  double TurnAt(std::size_t node) const;
  Vec2 DirectionBefore(std::size_t node) const {
    return segments_[node - 1].DirectionAt(segments_[node - 1].length_mm);
  }
  Vec2 DirectionBehind(std::size_t node) const { return segments_[node].DirectionAt(0); }

  /// Segments first..last - 1 as a path of their own. Not empty.
  Path Part(std::size_t first, std::size_t last) const;

 private:
  explicit Path(std::vector<Segment> segments);

  std::vector<Segment> segments_;
  std::vector<double> node_s_mm_;
};

/// Points of a path at ascending arc lengths: remembers the segment of the last one.
class PathCursor {
 public:
  explicit PathCursor(const Path& path) : path_(path) {}
  /// Outside 0..length_mm: on the tangent at the path's begin or end.
  Vec2 PointAt(double s_mm);

 private:
  const Path& path_;
  std::size_t segment_ = 0;
};

}  // namespace intaglio::course
