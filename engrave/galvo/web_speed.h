#pragma once

// How fast a web may run under a scan head that marks it.
//
// A mark can be made while it is wholly in the field. Marks one after another in a given
// order, each in time t with the jump to it, all lie in the field when they are made if
// and only if for all i <= j
//   v (t_i + ... + t_j) <= s_j - s_i + L - (w_i + w_j) / 2,
// so the largest speed is the smallest ratio. Bessmeltsev, Goloshevsky, Smirnov 2009
// divide the web into frames of L / 2, each of which is in reach while the web moves by
// L / 2: v = (L / 2) / (largest time of a frame), which is half or less for uneven
// content.

#include <span>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::galvo {

/// A mark in the order in which marks are made.
struct TimedMark {
  double along_mm = 0;   ///< s: its centre along the web; larger arrives later
  double extent_mm = 0;  ///< w: along the web, >= 0
  double time_s = 0;     ///< t: jump, delays and marking, > 0
};

/// The largest speed, mm/s, at which all are made in this order, to rounding; O(n) a step
/// of few. kInvalidValue: no mark, a mark that is as long as the field, a time that is
/// not above 0, or an order in which a mark has left before an earlier one arrives.
Result<double> MaxSpeed(std::span<const TimedMark> marks, double field_mm);

/// The largest speed with the frames of the source, mm/s. Errors as of MaxSpeed.
Result<double> FrameSpeed(std::span<const TimedMark> marks, double field_mm);

/// The marks that are missed at a speed: each is made as soon as it is in the field and
/// the mark before it is done, or left out when it would have left before its end.
/// Indices, ascending.
std::vector<std::size_t> MissedMarks(std::span<const TimedMark> marks, double field_mm,
                                     double speed_mm_s);

}  // namespace intaglio::galvo
