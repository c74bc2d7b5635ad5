#pragma once

// The outlines of one font, by character. For the sources of this folder: it names the
// types of FreeType.

#include <ft2build.h>

#include <memory>
#include <string>
#include FT_FREETYPE_H

#include "engrave/core/result.h"
#include "engrave/drawing/closer.h"
#include "engrave/drawing/font_source.h"

namespace intaglio::drawing {

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

 private:
  using Library = std::unique_ptr<FT_LibraryRec_, Closer<FT_Done_FreeType>>;
  using Face = std::unique_ptr<FT_FaceRec_, Closer<FT_Done_Face>>;

  FontFace(Library library, Face face);
  Status FindCapHeight(const std::string& file);

  Library library_;
  Face face_;
  double cap_height_ = 0;
};

}  // namespace intaglio::drawing
