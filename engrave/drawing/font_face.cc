#include "engrave/drawing/font_face.h"

#include <fmt/format.h>
#include FT_OUTLINE_H

#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/drawing/font_list.h"

namespace intaglio::drawing {

FontFace::FontFace(Library library, Face face)
    : library_(std::move(library)), face_(std::move(face)) {}

Result<FontFace> FontFace::Open(const FontSource& font) {
  std::string file = font.name;
  if (font.bytes.empty() && !IsFontFile(file)) {
    auto found = INTAGLIO_TRY(FindFontFile(file));
    file = std::move(found);
  }
  FT_Library library = nullptr;
  Require(FT_Init_FreeType(&library) == 0, "FreeType cannot be initialized");
  Library owned_library(library);
  FT_Face face = nullptr;
  const FT_Error failure =
      font.bytes.empty()
          ? FT_New_Face(library, file.c_str(), 0, &face)
          : FT_New_Memory_Face(library,
                               reinterpret_cast<const FT_Byte*>(font.bytes.data()),
                               static_cast<FT_Long>(font.bytes.size()), 0, &face);
  if (failure == FT_Err_Cannot_Open_Resource) {
    return Fail(ErrorCode::kNotFound,
                fmt::format("the font file {} cannot be opened; check its path", file),
                file);
  }
  if (failure != 0) {
    return Fail(
        ErrorCode::kUnreadable,
        fmt::format("{} cannot be read as a font; use a TrueType or OpenType file", file),
        file);
  }
  FontFace opened(std::move(owned_library), Face(face));
  if (!FT_IS_SCALABLE(face) || FT_Select_Charmap(face, FT_ENCODING_UNICODE) != 0) {
    return Fail(
        ErrorCode::kUnreadable,
        fmt::format("{} has no outlines of Unicode characters; use another font", file),
        file);
  }
  INTAGLIO_TRY(opened.FindCapHeight(file));
  return opened;
}

std::string FontFace::Name() const {
  const std::string family = face_->family_name != nullptr ? face_->family_name : "";
  const std::string style = face_->style_name != nullptr ? face_->style_name : "";
  const bool plain = style.empty() || style == "Regular" || style == "Book";
  return plain ? family : family + " " + style;
}

Status FontFace::FindCapHeight(const std::string& file) {
  const FT_UInt glyph = GlyphOf('H');
  FT_BBox box{};
  if (glyph != 0 && FT_Load_Glyph(face_.get(), glyph, FT_LOAD_NO_SCALE) == 0) {
    FT_Outline_Get_CBox(&face_->glyph->outline, &box);
  }
  // A font of symbols has no H: then its ascent is the measure.
  cap_height_ = static_cast<double>(box.yMax > 0 ? box.yMax : face_->ascender);
  if (cap_height_ > 0) return {};
  return Fail(
      ErrorCode::kUnreadable,
      fmt::format("{} does not give the height of its letters; use another font", file),
      file);
}

}  // namespace intaglio::drawing
