#include "engrave/drawing/font_face.h"

#include <fmt/format.h>
#include <hb-ft.h>
#include <hb-ot.h>
#include FT_ADVANCES_H
#include FT_OUTLINE_H

#include <array>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/drawing/font_list.h"

namespace intaglio::drawing {

FontFace::FontFace(Library library, Face face)
    : library_(std::move(library)), face_(std::move(face)) {
  if (!FT_IS_SFNT(face_.get())) return;
  hb_face_t* tables = hb_ft_face_create_referenced(face_.get());
  shaper_.reset(hb_font_create(tables));
  hb_face_destroy(tables);  // the font keeps it
  hb_ot_font_set_funcs(shaper_.get());
  hb_font_set_scale(shaper_.get(), face_->units_per_EM, face_->units_per_EM);
}

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

double FontFace::Place(std::u32string_view run, bool kerning,
                       std::vector<PlacedGlyph>& glyphs) const {
  double x = 0, y = 0;
  if (!shaper_) {
    for (const char32_t character : run) {
      const FT_UInt glyph = GlyphOf(character);
      FT_Fixed advance = 0;
      FT_Get_Advance(face_.get(), glyph, FT_LOAD_NO_SCALE, &advance);
      glyphs.push_back({glyph, x, y});
      x += static_cast<double>(advance);
    }
    return x;
  }
  const std::unique_ptr<hb_buffer_t, Closer<hb_buffer_destroy>> buffer(
      hb_buffer_create());
  hb_buffer_add_utf32(buffer.get(), reinterpret_cast<const std::uint32_t*>(run.data()),
                      static_cast<int>(run.size()), 0, static_cast<int>(run.size()));
  // Else it is that of the computer's locale, and points would depend on it.
  hb_buffer_set_language(buffer.get(), hb_language_from_string("und", -1));
  hb_buffer_guess_segment_properties(buffer.get());
  const auto feature = [](hb_tag_t tag, std::uint32_t value) {
    return hb_feature_t{tag, value, HB_FEATURE_GLOBAL_START, HB_FEATURE_GLOBAL_END};
  };
  const std::array features = {feature(HB_TAG('k', 'e', 'r', 'n'), kerning ? 1 : 0),
                               feature(HB_TAG('l', 'i', 'g', 'a'), 0),
                               feature(HB_TAG('c', 'l', 'i', 'g'), 0)};
  hb_shape(shaper_.get(), buffer.get(), features.data(), features.size());
  unsigned count = 0;
  const hb_glyph_info_t* info = hb_buffer_get_glyph_infos(buffer.get(), &count);
  const hb_glyph_position_t* at = hb_buffer_get_glyph_positions(buffer.get(), &count);
  for (unsigned i = 0; i < count; ++i) {
    glyphs.push_back({info[i].codepoint, x + at[i].x_offset, y + at[i].y_offset});
    x += at[i].x_advance;
    y += at[i].y_advance;
  }
  return x;
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
