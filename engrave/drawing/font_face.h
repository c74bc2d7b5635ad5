#pragma once

// The outlines of one font, by character, and where they go in a run. For the sources of
// this folder: it names the types of FreeType and HarfBuzz.

#include <ft2build.h>
#include <hb.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>
#include FT_FREETYPE_H

#include "engrave/core/result.h"
#include "engrave/drawing/closer.h"
#include "engrave/drawing/font_source.h"

namespace intaglio::drawing {

/// A letter of a run, from the run's begin to its origin, in font units.
struct PlacedGlyph {
  FT_UInt glyph = 0;
  double x = 0, y = 0;
};

class FontFace {
 public:
  /// kNotFound: there is no such font; kUnreadable: it is no font, or has no outlines of
  /// Unicode characters or no height of its letters.
  static Result<FontFace> Open(const FontSource& font);

  /// 0: the font does not have the character.
  FT_UInt GlyphOf(char32_t character) const {
    return FT_Get_Char_Index(face_.get(), character);
  }
  bool Has(char32_t character) const { return GlyphOf(character) != 0; }
  /// "DejaVu Sans Bold", for people.
  std::string Name() const;
  /// Of a capital H, in font units; of a font of symbols, its ascent.
  double cap_height() const { return cap_height_; }
  double line_height() const { return static_cast<double>(face_->height); }
  FT_Face get() const { return face_.get(); }
  /// Places the letters of characters that the font has, by its tables GPOS and GSUB or,
  /// without them, kern; a run has one direction, that of its first letter. Ligatures are
  /// not used, except where a script requires them. Fonts without tables (Type 1): by the
  /// widths of the letters alone. Returns the width of the run, font units.
  double Place(std::u32string_view run, bool kerning,
               std::vector<PlacedGlyph>& glyphs) const;

 private:
  using Library = std::unique_ptr<FT_LibraryRec_, Closer<FT_Done_FreeType>>;
  using Face = std::unique_ptr<FT_FaceRec_, Closer<FT_Done_Face>>;
  using Shaper = std::unique_ptr<hb_font_t, Closer<hb_font_destroy>>;

  FontFace(Library library, Face face);
  Status FindCapHeight(const std::string& file);

  Library library_;
  Face face_;
  Shaper shaper_;  ///< null: the font has no tables
  double cap_height_ = 0;
};

}  // namespace intaglio::drawing
