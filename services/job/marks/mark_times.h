#pragma once

// How long a head needs for marks, and how fast a web may run under it.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/galvo/field_window.h"
#include "engrave/galvo/mark_ticks.h"
#include "engrave/galvo/web_speed.h"
#include "engrave/mark/mark.h"

namespace intaglio {

/// What of a scan head decides times.
struct HeadFigures {
  /// Where in its square field it can mark, with its correction.
  galvo::FieldWindow window{100};
  /// How it makes ticks; the speed of a mark is that of its pen.
  galvo::MarkTickOptions ticks = {.jump_mm_s = 5000, .run_in_s = 0.0006};

  double field_mm() const { return window.field_mm(); }
  /// Where marks of a web are made, along it.
  double web_field_mm() const;
};

struct MarkTimes {
  double mark_mm = 0;  ///< of all passes, where the beam is on
  double jump_mm = 0;
  double time_s = 0;  ///< of all, one behind the other
};

/// In their order, from the first on; jumps along a web are those within the field. Times
/// are those of the ticks that the driver sends.
MarkTimes TimesOf(const mark::MarkSet& set, const HeadFigures& head);

/// As marks of a web, in their order, with the jumps to them: of a field of web_field_mm.
/// Where the window is narrower at the places of a mark, the mark counts as so much
/// longer. `times`, where it is wanted: those of TimesOf.
std::vector<galvo::TimedMark> TimedMarksOf(const mark::MarkSet& set,
                                           const HeadFigures& head,
                                           MarkTimes* times = nullptr);

/// kOutsideBlock: a mark that no place of the web brings into the window wholly, by its
/// number, place and size; on a piece at rest, one that lies outside the window.
Status CheckField(const mark::MarkSet& set, bool on_web, const HeadFigures& head);
/// The same of some marks, the first of which has this number, from 0.
Status CheckField(std::span<const mark::Mark> marks, std::size_t first,
                  std::span<const mark::Pen> pens, bool on_web, const HeadFigures& head);

/// The marks of one repeat on a web by their jumps: what lies at the right arrives first.
std::vector<mark::Mark> OrderRepeat(std::vector<mark::Mark> marks, bool may_reverse);

/// The order in which the web may run fastest (engrave/galvo/web_order.h): of each repeat
/// the marks are ordered by their jumps, parts of that order become units of a sixteenth
/// of the field, and the units are ordered. `progress` counts marks. Errors as of
/// CheckField; kCancelled when `progress` returns that.
Result<mark::MarkSet> OrderForWeb(mark::MarkSet set, const HeadFigures& head,
                                  bool may_reverse, const ProgressSink& progress = {});

}  // namespace intaglio
