#pragma once

// What a board or a plate is drawn with (Siwiec 2016, ch. 5.1: pads, tracks; free
// outlines are ours). Frame: drawing, mm, x to the right, y up.
//
// The centre of a tool of radius r that leaves an element whole moves on its outline
// grown by r: a circle of diameter d + 2r, a track of width w + 2r with round ends. The
// published program grows squares and octagons with sharp corners (Siwiec 2016, annex D,
// N556 - N558: 4.2 for 4.0 and r 0.1); the tool itself would leave round ones.

#include <span>
#include <string>
#include <variant>
#include <vector>

#include "engrave/contour/edge.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

struct Circle {
  Vec2 center_mm = Vec2::Zero();
  double diameter_mm = 0;
};

struct Square {
  Vec2 center_mm = Vec2::Zero();
  double side_mm = 0;
};

/// Regular, two of its sides parallel to x.
struct Octagon {
  Vec2 center_mm = Vec2::Zero();
  double size_mm = 0;  ///< across flats
};

/// With round ends; equal ends: a circle.
struct Track {
  Vec2 begin_mm = Vec2::Zero();
  Vec2 end_mm = Vec2::Zero();
  double width_mm = 0;
};

/// A track along an arc, with round ends; a full circle: a ring.
struct ArcTrack {
  Edge arc;
  double width_mm = 0;
};

/// A free outline: closed loops that neither cross nor touch themselves or each other.
/// Inside is what an odd number of loops encloses. Each edge begins where the one before
/// ends, to 1 um.
struct Outline {
  std::vector<Edges> loops;
};

using Shape = std::variant<Circle, Square, Octagon, Track, ArcTrack, Outline>;

struct Element {
  Shape shape;
  std::string name = {};  ///< for messages, e.g. "R1-2"; may be empty
  std::string net = {};   ///< that it belongs to; empty: not known, or none
};

enum class Corners {
  kSharp,  ///< of squares and octagons, as the published program
  kRound,  ///< what a round tool leaves
};

/// "R1-2, round pad 1.8 at (2.54, 2.54)".
std::string Describe(const Element& element);

/// Coordinates to 1 nm, and nodes (centres, ends of tracks) nearer than 0.1 um to an
/// earlier one replaced by it: two numbers for one place would leave slivers. Fails with
/// kInvalidValue: a size or a coordinate is not finite, negative, or beyond 10 m.
Result<std::vector<Element>> Rounded(std::span<const Element> elements);

}  // namespace intaglio::contour
