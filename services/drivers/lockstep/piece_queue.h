#pragma once

// A run's segments as pieces of straight way, for controllers that give no time of
// execution (grbl, isel).
//
// Time of such a controller is progress: a tick is a place in the program. Of a segment
// of n ticks from knot A to knot B, tick i is reached when the stage has passed the place
// that the segment has after i ticks.
//
//   knots   A----------------B----------------C        segments, ends at ticks
//   pieces  A---+---+---+----B---+---+---+----C        chords of at most kMaxPiece_s
//
// Places are whole steps of the controller. Used from one thread.

#include <cstdint>
#include <deque>
#include <span>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/motion/segments/segment.h"

namespace intaglio::drivers {

struct Piece {
  Vec3 to_mm = Vec3::Zero();
  double speed_mm_s = 0;  ///< the highest of its segment
  double duration_s = 0;
  std::uint64_t start_subticks = 0, end_subticks = 0;
  bool pulse = false, end = false;  ///< a point, the program's end, at its end
  PointList at_ticks_mm;            ///< of the segment, at the ticks that pass
};

inline std::uint64_t TickOf(std::uint64_t subticks) {
  return subticks / motion::kSubticksPerTick;
}

class PieceQueue {
 public:
  static constexpr double kMaxPiece_s = 0.05;

  void SetStepsPerMm(const Vec3& steps_per_mm) { steps_per_mm_ = steps_per_mm; }
  const Vec3& steps_per_mm() const { return steps_per_mm_; }
  /// Of the profile, machine frame.
  void SetTravel(const Box3& travel) { travel_ = travel; }
  const Box3& travel() const { return travel_; }
  /// kInvalidValue, with the place, when it is outside the travel or no number.
  Status Check(const Vec3& place_mm) const;
  Vec3 Snapped(const Vec3& place_mm) const;

  void Begin(std::uint64_t start_tick, const Vec3& from_mm);
  /// The error of Check when any of it is outside; then nothing is taken.
  Status Append(std::span<const motion::Segment> segments, double rate_hz);
  /// What was not taken yet is forgotten; the run has its end.
  void Drop();

  bool empty() const { return pieces_.empty(); }
  std::size_t size() const { return pieces_.size(); }
  const Piece& front() const { return pieces_.front(); }
  Piece TakeFront();
  /// The front pieces, up to `decided_through` and the next pulse, as one of at most
  /// kMaxPiece_s, at their mean speed; there is a front whose first tick is decided.
  Piece TakeMerged(std::uint64_t decided_through);
  /// The segment at which the run ends has been appended.
  bool has_end() const { return has_end_; }
  std::uint64_t covered_through_tick() const { return TickOf(appended_subticks_); }

 private:
  Status Cut(const motion::KnotState& from, const motion::Segment& segment,
             double rate_hz, std::uint64_t start_subticks,
             std::deque<Piece>& pieces) const;

  Vec3 steps_per_mm_ = Vec3::Constant(100);
  Box3 travel_;
  motion::KnotState appended_;
  std::uint64_t appended_subticks_ = 0;
  std::deque<Piece> pieces_;
  bool has_end_ = true;
};

/// Where the stage is at the ticks of a piece that begins at `from_mm`: on the chord,
/// where it is nearest to the segment.
PointList PlacesOnChord(const Vec3& from_mm, const Piece& piece);

}  // namespace intaglio::drivers
