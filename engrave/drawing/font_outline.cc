#include "engrave/drawing/font_outline.h"

#include <fmt/format.h>
#include <ft2build.h>
#include FT_OUTLINE_H

#include <algorithm>
#include <utility>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/drawing/drawing_builder.h"
#include "engrave/drawing/font_face.h"
#include "engrave/drawing/pieces.h"
#include "engrave/drawing/utf8_characters.h"

namespace intaglio::drawing {
namespace {

/// Appends the outline that FreeType walks, at an offset, in units of the first font.
struct Pen {
  std::vector<Curve>& curves;
  double shift_x = 0;
  double scale = 1;                // of the font's units
  FT_UInt last = 0;                // glyph before this one,
  const FontFace* face = nullptr;  // and its font
  Vec3 at = Vec3::Zero();

  Vec3 Point(const FT_Vector* p) const {
    return {scale * static_cast<double>(p->x) + shift_x,
            scale * static_cast<double>(p->y), 0};
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

class Typesetter {
 public:
  explicit Typesetter(const TextOptions& options) : options_(options) {}

  Status Open() {
    auto first = INTAGLIO_TRY(FontFace::Open(options_.font));
    faces_.push_back(std::move(first));
    for (const FontSource& font : options_.fallbacks) {
      auto next = INTAGLIO_TRY(FontFace::Open(font));
      faces_.push_back(std::move(next));
    }
    return {};
  }

  Result<Drawing> Set(std::u32string_view text) {
    if (text.size() > options_.max_characters) {
      return Fail(ErrorCode::kTooLarge,
                  fmt::format("the text has more than {} characters; divide it",
                              options_.max_characters));
    }
    Drawing drawing;
    const FontFace& first = faces_.front();
    const double step = options_.line_spacing_ratio * first.line_height();
    double baseline = 0;
    for (std::u32string_view rest = text;; baseline -= step) {
      const auto end = rest.find(U'\n');
      INTAGLIO_TRY(SetLine(rest.substr(0, end), baseline, drawing));
      if (end == rest.npos) break;
      rest.remove_prefix(end + 1);
    }
    std::erase_if(drawing.curves,
                  [](const Curve& curve) { return curve.pieces.empty(); });
    if (drawing.curves.empty()) {
      return Fail(ErrorCode::kMissing, "the text has no visible character");
    }
    Transform(options_.cap_height_mm / first.cap_height() * Mat3::Identity(),
              Vec3::Zero(), drawing);
    return drawing;
  }

 private:
  /// The first that has it, or the first of all.
  const FontFace& FaceOf(char32_t character) const {
    const auto found =
        std::find_if(faces_.begin(), faces_.end(),
                     [&](const FontFace& face) { return face.Has(character); });
    return found == faces_.end() ? faces_.front() : *found;
  }

  /// In units of the first font.
  Status SetLine(std::u32string_view text, double baseline, Drawing& drawing) const {
    const std::size_t first = drawing.curves.size();
    Pen pen{drawing.curves};
    for (const char32_t character : text) {
      if (character != '\r') INTAGLIO_TRY(SetCharacter(character, pen));
    }
    const double share = options_.alignment == TextAlignment::kLeft     ? 0
                         : options_.alignment == TextAlignment::kCentre ? 0.5
                                                                        : 1;
    const Vec3 shift(-share * pen.shift_x, baseline, 0);
    for (std::size_t i = first; i < drawing.curves.size(); ++i) {
      for (Piece& piece : drawing.curves[i].pieces) {
        Transform(Mat3::Identity(), shift, piece);
      }
    }
    return {};
  }

  Status SetCharacter(char32_t character, Pen& pen) const {
    const FontFace& face = FaceOf(character);
    const FT_UInt glyph = face.GlyphOf(character);
    if (glyph == 0 || FT_Load_Glyph(face.get(), glyph, FT_LOAD_NO_SCALE) != 0) {
      return Fail(
          ErrorCode::kMissing,
          fmt::format("the font {} has no letter for {}; use another font or text",
                      face.Name(), NameOfCharacter(character)),
          Utf8Of({&character, 1}));
    }
    // Letters of another font are as high as those beside them.
    pen.scale = faces_.front().cap_height() / face.cap_height();
    FT_Vector kerning{0, 0};
    if (options_.kerning && pen.last != 0 && pen.face == &face) {
      FT_Get_Kerning(face.get(), pen.last, glyph, FT_KERNING_UNSCALED, &kerning);
    }
    pen.shift_x += pen.scale * static_cast<double>(kerning.x);
    FT_Outline_Funcs walk{MoveTo, LineTo, ConicTo, CubicTo, 0, 0};
    FT_Outline_Decompose(&face.get()->glyph->outline, &walk, &pen);
    pen.shift_x += pen.scale * static_cast<double>(face.get()->glyph->advance.x);
    pen.last = glyph;
    pen.face = &face;
    return {};
  }

  const TextOptions& options_;
  std::vector<FontFace> faces_;
};

}  // namespace

Result<Drawing> TextOutline(std::string_view utf8, const TextOptions& options) {
  Require(options.cap_height_mm >= 0.1 && options.cap_height_mm <= 1000,
          "cap_height_mm must be 0.1 .. 1000, is {}", options.cap_height_mm);
  Require(options.line_spacing_ratio >= 0.5 && options.line_spacing_ratio <= 5,
          "line_spacing_ratio must be 0.5 .. 5, is {}", options.line_spacing_ratio);
  Typesetter typesetter(options);
  const auto text = INTAGLIO_TRY(CharactersOf(utf8));
  INTAGLIO_TRY(typesetter.Open());
  return typesetter.Set(text);
}

}  // namespace intaglio::drawing
