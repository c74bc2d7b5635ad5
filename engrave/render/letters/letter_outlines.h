#pragma once

// Letters that the stroke font (text.h) does not have, by the fonts of this computer and
// the engine that sets texts in glass (engrave/drawing/font_outline.h): joined and in
// their order, as their script asks for.

#include <optional>
#include <string_view>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::render {

struct LetterOutlines {
  /// Closed; a capital is 1 high, y up, the baseline y = 0, the first letter begins at 0.
  std::vector<std::vector<Vec2>> loops;
  double width = 0;  ///< to the end of the last letter
};

/// Of one line; nothing where no font of this computer has one of the letters. May be
/// called from several threads.
std::optional<LetterOutlines> OutlinesOfLetters(std::u32string_view letters);

}  // namespace intaglio::render
