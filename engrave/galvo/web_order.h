#pragma once

// The order in which marks on a moving web are made, so that the web may run fastest.

#include "engrave/core/geometry.h"
#include "engrave/core/progress.h"
#include "engrave/galvo/web_speed.h"

namespace intaglio::galvo {

/// A mark on a web: a hole, a letter. Frame of the web: x along it, larger arrives later;
/// y across.
struct WebMark {
  Vec2 centre_mm = Vec2::Zero();
  double extent_mm = 0;  ///< along the web, >= 0 and less than the field
  double mark_s = 0;     ///< marking with its delays, without the jump to it, > 0
};

struct WebHead {
  double field_mm = 0;   ///< width of the square field, > 0
  double jump_mm_s = 0;  ///< speed of a move with the laser off, > 0
};

struct WebOrder {
  std::vector<std::size_t> order;  ///< indices of the marks
  std::vector<TimedMark> timed;    ///< in that order, with the jumps
  double max_mm_s = 0;             ///< largest speed of the web in that order
};

/// In the order of arrival (equal places: as given). Errors as of MaxSpeed.
Result<WebOrder> ArrivalOrder(std::span<const WebMark> marks, const WebHead& head);

/// The fastest of: arrival; strips across the web, up one and down the next, of 24
/// lengths; and look-ahead: of the marks in the field the one with the shortest jump is
/// next, unless one of the marks behind it would then leave before it is made, at speeds
/// that are raised while such an order is found. Never slower than ArrivalOrder. Errors
/// as of MaxSpeed; kCancelled when `progress`, which counts the orders that are tried,
/// returns that. O(n) marks times 25 speeds times 60 marks ahead.
Result<WebOrder> FastestOrder(std::span<const WebMark> marks, const WebHead& head,
                              const ProgressSink& progress = {});

}  // namespace intaglio::galvo
