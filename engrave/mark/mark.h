#pragma once

// What a beam or a tool makes without a pause: a stroke of a scan head, a contour of a
// mill, a hole. Marks are to marking machines what points are to engraving ones: they are
// made in an order, each once, and journaled one by one.
//
// Frame: of the piece, mm, x to the right, y up. On a web that moves, of the piece of the
// web that begins web_mm along it.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::mark {

/// How marks are made.
struct Pen {
  std::string name;              ///< for people
  double speed_mm_s = 0;         ///< along the mark, > 0
  double power_ratio = 0;        ///< of the laser's largest, 0..1; of a mill 0
  double frequency_hz = 0;       ///< of the laser's pulses; 0: continuous
  std::uint32_t pass_count = 1;  ///< how many times each mark is made, >= 1
  double depth_mm = 0;     ///< of a tool below the surface, equal parts a pass; >= 0
  double plunge_mm_s = 0;  ///< of a tool down into the work, > 0 when it has a depth
};

struct Place {
  Vec2 at_mm = Vec2::Zero();
  /// Of the way to the next place: tangent of a quarter of its arc, positive
  /// counterclockwise; 0: straight.
  double bulge = 0;
  /// The beam is off on the way to the next place; of rows alone.
  bool dark = false;
};

struct Mark {
  std::uint32_t pen = 0;  ///< index in MarkSet::pens
  bool closed = false;    ///< its last place leads to its first
  double web_mm = 0;
  std::vector<Place> places;  ///< one: a hole
};

/// A straight line that the beam follows at one speed, switched on and off on its way: of
/// a halftone a row of dots. It is open, goes forward alone, and begins and ends lit.
bool IsRow(const Mark& mark);

/// In the order in which they are made, once they are ordered.
struct MarkSet {
  std::vector<Pen> pens;
  std::vector<Mark> marks;
};

/// Of the way along its arcs, mm; of a row with its dark ways.
double LengthOf(const Mark& mark);
/// The same without dark ways.
double LitLengthOf(const Mark& mark);

/// Arcs as chords no farther from them than `tolerance_mm` > 0; a closed one does not
/// repeat its first place.
std::vector<Vec2> PlacesOf(const Mark& mark, double tolerance_mm);

/// What the beam marks: the way of PlacesOf, of a closed mark with its first place again;
/// of a row each of its lit parts.
std::vector<std::vector<Vec2>> LitWaysOf(const Mark& mark, double tolerance_mm);
/// How many these are.
std::size_t LitWayCount(const Mark& mark);

/// Mean of a way along its chords, weighted by their lengths; of one without length its
/// first place.
Vec2 MiddleOf(std::span<const Vec2> way_mm);

/// kInvalidValue: a pen out of range, no place, a value that is not finite, dark ways in
/// a mark that is no row, by the number of the mark or the pen.
Status CheckMarks(const MarkSet& set);

}  // namespace intaglio::mark
