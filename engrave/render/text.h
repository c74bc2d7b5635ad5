#pragma once

// Text in a built-in stroke font: ASCII, the Latin letters with marks that names of
// people have, and the symbols used with numbers (µ ° ± × · – ² ³). Strokes scale to any
// size without a font file at run time; digits have equal widths, so that columns of
// numbers are aligned. Letters of other scripts are those of the computer's fonts
// (letters/letter_outlines.h), as high as its capitals.

#include <string>
#include <string_view>
#include <vector>

#include "engrave/render/canvas.h"

namespace intaglio::render {

enum class Align { kLeft, kCenter, kRight };

struct TextStyle {
  double cap_height_px = 11.0;  ///< Height of an H; 9 is the smallest that is easy to
                                ///< read.
  Color color = {1.0F, 1.0F, 1.0F};
  float alpha = 1.0F;
  double weight = 1.0;  ///< Of the strokes; 1 is regular, 1.5 bold.
  Align align = Align::kLeft;
};

/// Width of a UTF-8 text in pixels, from the first stroke to the last.
double TextWidth(std::string_view text, double cap_height_px);

/// Draws a line of UTF-8 text; `at_px` is on the baseline, at the side that `align`
/// names. A character that no font has is drawn as its number, "<5C71>", a byte that is
/// not UTF-8 as a box.
void DrawText(Canvas& canvas, const Vec2& at_px, std::string_view text,
              const TextStyle& style);

/// The text in lines no wider than `width_px`, broken at blanks; a token that is wider
/// alone is broken anywhere. No line of an empty text.
std::vector<std::string> WrapText(std::string_view text, double cap_height_px,
                                  double width_px);

/// The same text at a size at which it is no wider than `width_px`.
TextStyle FittingStyle(std::string_view text, TextStyle style, double width_px);

}  // namespace intaglio::render
