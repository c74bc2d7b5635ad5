#pragma once

// The course of one axis over a step of whole ticks, in pieces of constant jerk that
// begin and end on the grid (step_limits.h).

#include <array>
#include <cstdint>

#include "engrave/motion/axis/axis_reach.h"
#include "engrave/motion/step_limits.h"

namespace intaglio::motion {

/// One axis between two points. Both speeds are such that the step is feasible within
/// the planned limits, and within SpeedsAt.
struct AxisStep {
  double start_mm = 0;
  double distance_mm = 0;
  double start_mm_s = 0;
  double end_mm_s = 0;
  std::uint64_t subticks = 0;
};

class StepCourse {
 public:
  /// The cubic, where it keeps the limits: it has the least integral of the squared
  /// acceleration. Else the course that needs the least acceleration (and jerk), or, if
  /// that went beyond the travel, the one that brakes hardest.
  StepCourse(const AxisStep& step, int axis, const StepLimits& limits, double rate_hz);

  /// Pieces an axis may have.
  static constexpr std::size_t kMaxPieces = 9;

  /// Ends of the pieces, in subticks after the step's start; the last is its end.
  std::size_t piece_count() const { return count_; }
  std::uint64_t knot(std::size_t piece) const { return pieces_[piece].end; }

  struct State {
    double gone_mm;  ///< since the step's start
    double speed_mm_s;
  };
  State At(std::uint64_t subticks) const;

 private:
  struct Piece {
    std::uint64_t end;
    State at_end;
  };
  /// A piece in powers of the time since it began.
  struct Cubic {
    std::uint64_t begin;
    State from;
    double seconds;
    double acceleration;  ///< at its begin, mm/s^2
    double jerk;          ///< mm/s^3

    State At(double t) const;
  };

  struct ArcTimes {
    std::uint64_t first, last;
  };
  /// On the grid, subticks; together at most the step.
  ArcTimes ArcsOnGrid(const Arcs& arcs) const;
  void TakeArcs(const Limits& planned, int axis, bool hardest);
  void TakePulses(const StepLimits& limits, int axis, bool hardest);
  /// The speed that takes the axis the whole way when the first and the last arc or
  /// pulse are this long.
  double CruiseFor(std::uint64_t first, std::uint64_t last) const;
  void Add(std::uint64_t end, State at_end);
  /// The next duration on a grid.
  std::uint64_t OnGrid(double seconds, std::uint64_t grid) const;
  double Seconds(std::uint64_t subticks) const;
  Cubic CubicOf(std::size_t piece) const;
  bool StaysWithin(double lo_mm, double hi_mm) const;

  AxisStep step_;
  double subtick_s_;
  std::uint64_t grid_;
  std::array<Piece, kMaxPieces> pieces_;
  std::size_t count_ = 0;
};

}  // namespace intaglio::motion
