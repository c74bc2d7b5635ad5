#include "engrave/drawing/typesetter.h"

#include <fmt/format.h>
#include FT_OUTLINE_H

#include <algorithm>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/drawing/utf8_characters.h"

namespace intaglio::drawing {
namespace {

/// Appends the outline that FreeType walks, at an offset, in units of the first font.
struct Pen {
  std::vector<Curve>& curves;
  double shift_x = 0, shift_y = 0;
  double scale = 1;  // of the font's units
  Vec3 at = Vec3::Zero();

  Vec3 Point(const FT_Vector* p) const {
    return {scale * static_cast<double>(p->x) + shift_x,
            scale * static_cast<double>(p->y) + shift_y, 0};
  }
  void Cubic(const Vec3& c1, const Vec3& c2, const Vec3& end) {
    curves.back().pieces.push_back(CubicBezier{{at, c1, c2, end}});
    at = end;
  }
};

int MoveTo(const FT_Vector* to, void* user) {
  Pen& pen = *static_cast<Pen*>(user);
  pen.curves.push_back({{}, true});
  pen.at = pen.Point(to);
  return 0;
}
int LineTo(const FT_Vector* to, void* user) {
  Pen& pen = *static_cast<Pen*>(user);
  const Vec3 end = pen.Point(to);
  pen.curves.back().pieces.push_back(Polyline{{pen.at, end}});
  pen.at = end;
  return 0;
}
int ConicTo(const FT_Vector* control, const FT_Vector* to, void* user) {
  Pen& pen = *static_cast<Pen*>(user);
  const Vec3 c = pen.Point(control), end = pen.Point(to);
  pen.Cubic(pen.at + 2.0 / 3 * (c - pen.at), end + 2.0 / 3 * (c - end), end);
  return 0;
}
int CubicTo(const FT_Vector* c1, const FT_Vector* c2, const FT_Vector* to, void* user) {
  Pen& pen = *static_cast<Pen*>(user);
  pen.Cubic(pen.Point(c1), pen.Point(c2), pen.Point(to));
  return 0;
}

}  // namespace

Result<Typesetter> Typesetter::Open(const FontSource& font,
                                    std::span<const FontSource> fallbacks) {
  Typesetter typesetter;
  auto first = INTAGLIO_TRY(FontFace::Open(font));
  typesetter.faces_.push_back(std::move(first));
  for (const FontSource& fallback : fallbacks) {
    auto next = INTAGLIO_TRY(FontFace::Open(fallback));
    typesetter.faces_.push_back(std::move(next));
  }
  return typesetter;
}

const FontFace* Typesetter::FaceOf(char32_t character) const {
  const auto found =
      std::find_if(faces_.begin(), faces_.end(),
                   [&](const FontFace& face) { return face.Has(character); });
  return found == faces_.end() ? nullptr : &*found;
}

Result<TextLine> Typesetter::SetLine(std::u32string_view text, bool kerning) const {
  TextLine line;
  std::u32string run;
  const FontFace* face_of_run = nullptr;
  const auto end_run = [&]() -> Status {
    if (run.empty()) return {};
    const std::u32string ended = std::exchange(run, {});
    return AddRun(ended, *face_of_run, kerning, line);
  };
  for (const char32_t character : text) {
    if (character == '\r') continue;
    const FontFace* face = FaceOf(character);
    if (face == nullptr) {
      return Fail(
          ErrorCode::kMissing,
          fmt::format("the font {} has no letter for {}; use another font or text",
                      faces_.front().Name(), NameOfCharacter(character)),
          Utf8Of({&character, 1}));
    }
    if (face != face_of_run) INTAGLIO_TRY(end_run());
    face_of_run = face;
    run.push_back(character);
  }
  INTAGLIO_TRY(end_run());
  return line;
}

Status Typesetter::AddRun(std::u32string_view run, const FontFace& face, bool kerning,
                          TextLine& line) const {
  std::vector<PlacedGlyph> glyphs;
  const double width = face.Place(run, kerning, glyphs);
  // Letters of another font are as high as those beside them.
  const double scale = faces_.front().cap_height() / face.cap_height();
  const FT_Outline_Funcs walk{MoveTo, LineTo, ConicTo, CubicTo, 0, 0};
  for (const PlacedGlyph& placed : glyphs) {
    if (FT_Load_Glyph(face.get(), placed.glyph, FT_LOAD_NO_SCALE) != 0) {
      return Fail(ErrorCode::kUnreadable,
                  fmt::format("the letter {} of the font {} cannot be read; use another "
                              "font",
                              placed.glyph, face.Name()),
                  face.Name());
    }
    std::vector<Curve> outlines;
    Pen pen{outlines};
    pen.scale = scale;
    pen.shift_x = line.width + scale * placed.x;
    pen.shift_y = scale * placed.y;
    FT_Outline_Decompose(&face.get()->glyph->outline, &walk, &pen);
    for (Curve& outline : outlines) {
      if (outline.pieces.empty()) continue;
      line.curves.push_back(std::move(outline));
      line.letters.push_back(line.letter_count);
    }
    ++line.letter_count;
  }
  line.width += scale * width;
  return {};
}

}  // namespace intaglio::drawing
