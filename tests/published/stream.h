#pragma once

// The plan of a contour while it is still being read: pieces go in, phases of the speed
// law come out, a bounded length behind. What came out does not change any more.
//
// The speed of a node depends on what lies a braking distance before it, and on the
// memory of axes and kernel. So a look-ahead of known path suffices; until it is known
// that the path goes on, its last known node is a stop.

#include <vector>

#include "engrave/course/correction.h"

namespace intaglio::course {

class CourseStream {
 public:
  /// As of PlanCourse, for pieces whose feed is at most `max_feed_mm_s`. A compensated
  /// course needs options.kernel_s, and acceleration_mm_s2 as it is: the fastest cannot
  /// be chosen before the path is known. kInvalidValue, kMissing.
  static Result<CourseStream> Make(const Vec2& begin_mm, const AxisPair& axes,
                                   const PlanOptions& options, double max_feed_mm_s);

  /// Appends what has become final to `out`; times and arc lengths from the begin of the
  /// whole. Errors as of Path::Make, and kInvalidValue for a greater feed; the piece is
  /// then left out.
  Status Append(const Piece& piece, std::vector<Phase>& out);
  /// The rest, to the stop at the end. No piece may follow.
  void Finish(std::vector<Phase>& out);

  /// Path behind the last final node, at most: pending_mm() <= max_pending_mm() after
  /// each call, but for a piece that is longer.
  double pending_mm() const;
  double max_pending_mm() const { return look_ahead_mm_ + block_mm_; }

  /// So far: whether everything allowed was kept, and the law's duration.
  bool holds() const { return holds_; }
  double duration_s() const { return duration_s_; }
  /// Speeds of all final nodes, from the first.
  const std::vector<double>& node_speed_mm_s() const { return node_speed_mm_s_; }
  const TrackingOptions& tracking() const { return tracking_.options(); }

 private:
  CourseStream(const Vec2& begin_mm, const AxisPair& axes, const PlanOptions& options,
               const TrackingOptions& tracking, double max_feed_mm_s);

  Corrected Correct(const Path& path) const;
  /// The phases from the last final node to node `last`, and their speeds.
  void Emit(const Path& path, const SpeedLaw& law, std::size_t last,
            std::vector<Phase>& out);
  /// Corrects what is known and makes nodes up to `keep_mm` before its end final.
  void Plan(double keep_mm, std::vector<Phase>& out);
  /// The window begins `segments` later.
  void Forget(std::size_t segments);

  Tracking tracking_;
  Allowed allowed_;
  double acceleration_mm_s2_, max_feed_mm_s_;
  int rounds_;
  double memory_mm_, look_ahead_mm_, block_mm_;
  Vec2 end_mm_;

  // Segments that are known: first those that are final and still act, then the rest.
  std::vector<Segment> segments_;
  Speeds speeds_;  ///< of segments_ and their nodes
  std::size_t final_count_ = 0;
  double duration_s_ = 0, final_mm_ = 0;
  double window_begin_s_ = 0;  ///< of segments_.front()
  bool holds_ = true, begun_ = false;
  std::vector<double> node_speed_mm_s_;
};

}  // namespace intaglio::course
