#pragma once

// What of a mark decides when it can be made and how long that takes, measured once,
// wherever the beam comes from.
//
// Frame: of the material as it moves with the web, mm; the web moves along +x: a place x
// of a mark of web_mm enters the field later the larger web_mm - x is.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "engrave/galvo/field_window.h"
#include "engrave/galvo/web_speed.h"
#include "engrave/mark/mark.h"
#include "services/job/marks/mark_times.h"

namespace intaglio {

/// Where marks lie, and at which displacements of the web they can be made.
struct MarkExtent {
  Vec2 min_mm, max_mm;
  galvo::Span made_at;
};

MarkExtent ExtentOf(const mark::Mark& mark, const mark::Pen& pen,
                    const HeadFigures& head);

/// Where a mark begins, and how long it takes from there.
struct MarkStart {
  Vec2 begin_mm = Vec2::Zero();
  std::optional<galvo::StrokeTicks>
      ticks;                    ///< none: no head makes it, its driver names it
  double time_s = 0;            ///< without ticks
  Vec2 rest_mm = Vec2::Zero();  ///< where the beam rests behind it
};

struct MeasuredMark {
  MarkExtent extent;
  MarkStart start;
  Vec2 end_mm = Vec2::Zero();
  double length_mm = 0;  ///< of all passes, where the beam is on
};

MeasuredMark Measure(const mark::Mark& mark, const mark::Pen& pen,
                     const HeadFigures& head);

std::vector<MeasuredMark> MeasureAll(std::span<const mark::Mark> marks,
                                     std::span<const mark::Pen> pens,
                                     const HeadFigures& head);

/// The jump to a mark and all of its passes. A beam that would have to jump farther than
/// the field waits within it for the web.
double TimeFrom(const Vec2& from_mm, const MarkStart& start, const HeadFigures& head);

/// What a jump adds to MarkTimes::jump_mm.
double JumpMm(const Vec2& from_mm, const MarkStart& start, const HeadFigures& head);

/// In the middle of its displacements, and as long as they leave of the field.
galvo::TimedMark TimedBy(const galvo::Span& made_at, const HeadFigures& head,
                         double time_s);

/// Commands lead the mirrors by so much at each end of a mark, and have to be in the
/// field.
double LeadMm(const mark::Pen& pen, const HeadFigures& head);

}  // namespace intaglio
