#pragma once

// Latin letters with marks, as names of people have them: which letter and which mark,
// and the strokes of the mark.

#include <optional>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::render {

enum class Mark {
  kAcute,
  kGrave,
  kCircumflex,
  kCaron,
  kDiaeresis,
  kTilde,
  kRing,
  kBreve,
  kMacron,
  kDot,
  kDoubleAcute,
  kCedilla,
  kOgonek,
  kSlash,  ///< across the letter
  kBar     ///< across the stem
};

struct AccentedLetter {
  char base;
  Mark mark;
};

/// Of Latin-1 and Latin Extended-A; nullopt for all other characters.
std::optional<AccentedLetter> SplitAccent(char32_t sign);

/// Polylines in font units (9 for the height of a capital, y up), for a letter of this
/// width and height that stands on y = 0. A point is a line of two equal ends.
std::vector<std::vector<Vec2>> StrokesOfMark(Mark mark, double width, double height);

}  // namespace intaglio::render
