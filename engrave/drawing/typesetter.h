#pragma once

// Letters beside each other, as closed curves. For the sources of this folder and its
// readers: FontFace names the types of FreeType.

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/drawing/drawing.h"
#include "engrave/drawing/font_face.h"
#include "engrave/drawing/font_source.h"

namespace intaglio::drawing {

/// In units of the first font; the baseline is y = 0, the line begins at x = 0.
struct TextLine {
  std::vector<Curve> curves;
  std::vector<std::uint32_t> letters;  ///< of each curve, the number of its letter
  std::uint32_t letter_count = 0;      ///< also of those without a curve
  double width = 0;                    ///< with blanks at its ends
};

class Typesetter {
 public:
  /// Errors as FontFace::Open.
  static Result<Typesetter> Open(const FontSource& font,
                                 std::span<const FontSource> fallbacks = {});

  /// One line; a character comes from the first font that has it, and letters of another
  /// font are scaled to the capitals of the first. kMissing: a character that no font
  /// has.
  Result<TextLine> SetLine(std::u32string_view text, bool kerning) const;
  /// Whether one of the fonts has the character.
  bool Has(char32_t character) const { return FaceOf(character) != nullptr; }

  double cap_height() const { return faces_.front().cap_height(); }
  /// From baseline to baseline.
  double line_height() const { return faces_.front().line_height(); }

 private:
  const FontFace* FaceOf(char32_t character) const;
  Status AddRun(std::u32string_view run, const FontFace& face, bool kerning,
                TextLine& line) const;

  std::vector<FontFace> faces_;
};

}  // namespace intaglio::drawing
