#pragma once

// The picture of a job of marks after it was made. Above all marks from above, coloured
// by what became of them, with an arrow from the middle of each that was measured, many
// times longer than its error; below it the error of every mark in the order of marking;
// then some marks alone, with the deviation of what was burnt magnified. At the right the
// verdict and the figures, as in views.h.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/render/canvas.h"
#include "engrave/render/views.h"

namespace intaglio::render {

enum class MarkState : std::uint8_t {
  kMade,
  kSkipped,
  kMissed,
  kIncomplete,
  kDoubled,
  kUncertain
};

/// Frame: of the piece or the web, mm, x to the right, y up.
struct ShownMark {
  std::vector<Vec2> way_mm;  ///< of a closed one with its first place repeated
  Vec2 middle_mm = Vec2::Zero();
  MarkState state = MarkState::kMade;
  std::optional<Vec2> offset_mm;  ///< of what was burnt; none: not measured
  /// Of each place: the beam is off on the way to the next; empty: on none.
  std::vector<bool> dark = {};

  /// The way that ends at this place, from 1.
  bool IsLitTo(std::size_t place) const { return dark.empty() || !dark[place - 1]; }
};

/// The error of one mark; of all marks in their order.
struct MarkError {
  double error_um = 0;  ///< of one that was not measured: 0
  MarkState state = MarkState::kMade;
};

struct BurntStroke {
  Vec2 from_mm = Vec2::Zero(), to_mm = Vec2::Zero();
};

/// One mark alone.
struct CloseUp {
  std::string title;               ///< "mark 17"
  std::vector<std::string> lines;  ///< what is known of it
  ShownMark mark;
  std::vector<BurntStroke> burnt;
};

struct MarkViews {
  ViewsCaption caption;
  std::string heading;  ///< of the upper view
  std::vector<ShownMark> marks;
  double field_mm = 0;  ///< width of a square about the origin that is shown; 0: none
  double tolerance_um = 0;
  std::vector<MarkError> errors;   ///< empty: nothing was measured
  std::vector<CloseUp> close_ups;  ///< at most kMaxCloseUps
};

inline constexpr std::size_t kMaxCloseUps = 3;

/// How much longer arrows are than the offsets, in a view where 1 mm is so many pixels: a
/// round number (1, 2 or 5 times a power of ten) at which the longest, or one of 0.1 um
/// if all are shorter, is 60 pixels or less; 1 or more.
double OffsetMagnification(const std::vector<ShownMark>& marks, double px_per_mm);

/// How much larger deviations are drawn in a close-up: a round number at which the
/// tolerance is a twelfth of the mark's extent or less, and the largest deviation a
/// quarter; 1 or more.
double CloseUpMagnification(const CloseUp& close_up, double tolerance_um);

/// kViewsWidth x kViewsHeight. The same input gives the same picture.
Canvas DrawMarkViews(const MarkViews& views);

}  // namespace intaglio::render
