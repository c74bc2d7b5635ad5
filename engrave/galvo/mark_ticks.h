#pragma once

// Strokes as places for each tick of a scan head, 100 kHz: micro-vectors of constant
// length v / f (Bessmeltsev, Goloshevsky, Smirnov 2009, step 2), with the delays that a
// control board knows, or with a run-in and commands that lead the servo.
//
// A stroke whose laser is on in spans alone takes the whole ticks that are nearest to its
// speed. It is lit for whole ticks, in each span one or more: spans of the same length as
// many each, at most half a tick's way from their place. The lead of the servo, or the
// delays of the laser, lay both directions of rows upon each other.
//
// Frame: of the material, mm. Tick k holds its place from k / f to (k + 1) / f; the laser
// is on for as many ticks as the stroke has micro-vectors.
//   Delays (RTC manuals): the laser is switched on and off later than the commands begin
//   and end by its delays; the mirrors rest after a jump, after a mark, and at a corner
//   by the polygon delay times 1 - cos of its angle. Run-in: the beam moves at the speed
//   of the mark before and behind it with the laser off; a closed stroke is passed over
//   its seam, an open one along its end's direction. Lead (servo_lead.h): jumps are
//   quintics without a step of speed, corners end strokes so that each side has its
//   run-in, and no delay is needed.

#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::galvo {

/// A part of a way, from its beginning.
struct LitSpan {
  double from_mm = 0, to_mm = 0;
};

struct MarkStroke {
  std::vector<Vec2> points_mm;  ///< two or more; a closed one does not repeat its first
  bool closed = false;
  /// Where the laser is on, ascending; none: everywhere. Of strokes without a corner that
  /// have a run-in or commands that lead the servo: the mirrors sweep at one speed.
  std::vector<LitSpan> lit = {};
};

struct MarkTickOptions {
  double rate_hz = 1e5;     ///< 1e3..1e6
  double mark_mm_s = 0;     ///< > 0
  double jump_mm_s = 0;     ///< largest of a jump, > 0
  double run_in_s = 0;      ///< 0..0.1, before and behind each stroke
  double lag_s = 0;         ///< tracking delay of the servo, 0..0.01
  bool lead_servo = false;  ///< commands ahead by the lag; needs lag_s > 0
  double laser_on_delay_s = 0, laser_off_delay_s = 0;              ///< 0..0.01
  double jump_delay_s = 0, mark_delay_s = 0, polygon_delay_s = 0;  ///< 0..0.01
};

struct MarkTick {
  Vec2 place_mm = Vec2::Zero();
  bool laser = false;
};

/// From `from_mm` through the strokes in their order. kInvalidValue: an option outside
/// its range, a stroke of fewer than two places, or spans of one that is not swept at one
/// speed, by name; kTooLarge: more than 100 million ticks.
Result<std::vector<MarkTick>> MakeMarkTicks(std::span<const MarkStroke> strokes,
                                            const Vec2& from_mm,
                                            const MarkTickOptions& options);

/// How many ticks MakeMarkTicks makes but for the jump to the first stroke, which alone
/// depends on where the beam comes from.
struct StrokeTicks {
  Vec2 first_mm = Vec2::Zero();  ///< where that jump ends
  std::size_t count = 0;
  Vec2 end_mm = Vec2::Zero();  ///< where the beam rests behind them, without the lead
};

/// In a time that grows with the places and not with the ticks. Errors as of
/// MakeMarkTicks, and kInvalidValue without a stroke.
Result<StrokeTicks> CountStrokeTicks(std::span<const MarkStroke> strokes,
                                     const MarkTickOptions& options);

/// Of a jump that is so long, from rest. `options` as CountStrokeTicks takes them.
std::size_t CountJumpTicks(double way_mm, const MarkTickOptions& options);

}  // namespace intaglio::galvo
