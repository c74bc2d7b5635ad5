#pragma once

// Text as closed curves in a given font. TrueType, OpenType and Type 1 outlines; letters
// are placed and joined by HarfBuzz, kerned by the font's GPOS or kern table. A line has
// one direction: one that mixes scripts of both directions is to be divided.

#include <memory>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/drawing/drawing.h"
#include "engrave/drawing/font_source.h"

namespace intaglio::drawing {

enum class TextAlignment { kLeft, kCentre, kRight };

struct TextOptions {
  FontSource font;
  /// Tried one after another for a character that the font does not have; its letter is
  /// scaled to the height of the font's capitals.
  std::vector<FontSource> fallbacks;
  /// Height of a capital H, mm; 0.1 .. 1000.
  double cap_height_mm = 5;
  /// From baseline to baseline, as a multiple of the font's own distance; 0.5 .. 5.
  double line_spacing_ratio = 1;
  TextAlignment alignment = TextAlignment::kLeft;
  bool kerning = true;
  std::size_t max_characters = 10'000;  ///< beyond is kTooLarge
};

/// UTF-8 text, lines divided by \n. The first line's baseline is y = 0, further ones lie
/// below; x = 0 is the left, the middle or the right of the lines. Letters that overlap,
/// as those of joined scripts do, are one outline (united_letters.h). To be filled with
/// non-zero winding: letters may overlap themselves. Errors: kNotFound (font),
/// kUnreadable (a file that is not a font, a bitmap font, a text that is not UTF-8),
/// kMissing (a character that no font has, named; a text without a visible character),
/// kTooLarge. Broken preconditions: numbers outside their ranges.
Result<Drawing> TextOutline(std::string_view utf8, const TextOptions& options);

class Typesetter;

/// TextOutline of many texts, whose fonts are opened once. One thread at a time.
class TextOutliner {
 public:
  /// The bytes of the fonts outlive it. Errors as of TextOutline, of the fonts.
  static Result<TextOutliner> Open(TextOptions options);
  ~TextOutliner();
  TextOutliner(TextOutliner&&) noexcept;
  TextOutliner& operator=(TextOutliner&&) noexcept;

  /// Errors as of TextOutline.
  Result<Drawing> Outline(std::string_view utf8) const;

 private:
  TextOutliner(TextOptions options, std::unique_ptr<Typesetter> typesetter);

  TextOptions options_;
  std::unique_ptr<Typesetter> typesetter_;
};

}  // namespace intaglio::drawing
