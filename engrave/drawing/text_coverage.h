#pragma once

// Which font of a list has the characters of a text.

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/drawing/font_source.h"

namespace intaglio::drawing {

struct MissingCharacter {
  char32_t character = 0;
  std::size_t line = 1;  ///< of the text, the first in which it occurs
};

struct TextCoverage {
  std::vector<std::string> fonts;         ///< their names, in the order of the list
  std::vector<MissingCharacter> missing;  ///< in none of the fonts; each once
  std::map<std::size_t, std::u32string>
      borrowed;  ///< by a font behind the first, each once
};

/// UTF-8 text with lines divided by \n; \r has no letter. At least one font. Errors:
/// those of FontFace::Open (font_face.h), and kUnreadable: the text is not UTF-8.
Result<TextCoverage> CoverageOf(std::string_view utf8, std::span<const FontSource> fonts);

/// kMissing: names every missing character with its code point and line, and the fonts.
Status CheckCoverage(const TextCoverage& coverage);

/// Of `candidates`, font files in this order, those with a character of the text that
/// `font` and the ones before lack. What cannot be read as a font is passed over.
Result<std::vector<std::string>> NeededFallbacks(std::string_view utf8,
                                                 const std::string& font,
                                                 std::span<const std::string> candidates);

/// Those that a computer's own fonts offer (FallbackFontFiles) for what `font` lacks.
Result<std::vector<std::string>> InstalledFallbacks(std::string_view utf8,
                                                    const std::string& font);

}  // namespace intaglio::drawing
