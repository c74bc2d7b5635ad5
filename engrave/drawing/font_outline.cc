#include "engrave/drawing/font_outline.h"

#include <fmt/format.h>
#include <fontconfig/fontconfig.h>
#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_OUTLINE_H

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/drawing/drawing_builder.h"
#include "engrave/drawing/pieces.h"

namespace intaglio::drawing {
namespace {

template <auto Done>
struct Closer {
  template <typename T>
  void operator()(T* object) const {
    Done(object);
  }
};
using Library = std::unique_ptr<FT_LibraryRec_, Closer<FT_Done_FreeType>>;
using Face = std::unique_ptr<FT_FaceRec_, Closer<FT_Done_Face>>;
using FontConfig = std::unique_ptr<FcConfig, Closer<FcConfigDestroy>>;
using FontPattern = std::unique_ptr<FcPattern, Closer<FcPatternDestroy>>;
using FontObjects = std::unique_ptr<FcObjectSet, Closer<FcObjectSetDestroy>>;
using FontSet = std::unique_ptr<FcFontSet, Closer<FcFontSetDestroy>>;

/// Appends the outline that FreeType walks, at an offset, in font units.
struct Pen {
  std::vector<Curve>& curves;
  double shift_x = 0;
  Vec3 at = Vec3::Zero();

  Vec3 Point(const FT_Vector* p) const {
    return {static_cast<double>(p->x) + shift_x, static_cast<double>(p->y), 0};
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

/// The next character of UTF-8 text; none when the bytes are wrong (RFC 3629).
std::optional<char32_t> NextCharacter(std::string_view& text) {
  const auto lead = static_cast<unsigned char>(text.front());
  const std::size_t length = lead < 0x80 ? 1 : lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if ((lead >= 0x80 && lead < 0xC2) || lead > 0xF4 || text.size() < length) {
    return std::nullopt;
  }
  char32_t code = length == 1 ? lead : lead & (0xFFU >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if ((byte & 0xC0U) != 0x80) return std::nullopt;
    code = (code << 6) | (byte & 0x3FU);
  }
  constexpr char32_t kMin[] = {0, 0, 0x80, 0x800, 0x10000};
  if (code < kMin[length] || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) {
    return std::nullopt;
  }
  text.remove_prefix(length);
  return code;
}

bool MayBeFile(std::string_view font) {
  if (font.find('/') != font.npos) return true;
  constexpr std::string_view kEndings[] = {".ttf", ".otf", ".ttc",
                                           ".pfb", ".TTF", ".OTF"};
  return std::ranges::any_of(kEndings, [&](auto end) { return font.ends_with(end); });
}

class Typesetter {
 public:
  explicit Typesetter(const TextOptions& options) : options_(options) {}

  Status Open() {
    std::string file = options_.font;
    const std::string_view bytes = options_.font_bytes;
    if (bytes.empty() && !MayBeFile(file)) {
      auto found = INTAGLIO_TRY(FindFontFile(file));
      file = std::move(found);
    }
    FT_Library library = nullptr;
    Require(FT_Init_FreeType(&library) == 0, "FreeType cannot be initialized");
    library_.reset(library);
    FT_Face face = nullptr;
    const FT_Error failure =
        bytes.empty()
            ? FT_New_Face(library, file.c_str(), 0, &face)
            : FT_New_Memory_Face(library, reinterpret_cast<const FT_Byte*>(bytes.data()),
                                 static_cast<FT_Long>(bytes.size()), 0, &face);
    if (failure == FT_Err_Cannot_Open_Resource) {
      return Fail(ErrorCode::kNotFound,
                  fmt::format("the font file {} cannot be opened; check its path", file),
                  file);
    }
    if (failure != 0) {
      return Fail(
          ErrorCode::kUnreadable,
          fmt::format("{} cannot be read as a font; use a TrueType or OpenType file",
                      file),
          file);
    }
    face_.reset(face);
    if (!FT_IS_SCALABLE(face) || FT_Select_Charmap(face, FT_ENCODING_UNICODE) != 0) {
      return Fail(
          ErrorCode::kUnreadable,
          fmt::format("{} has no outlines of Unicode characters; use another font", file),
          file);
    }
    return FindCapHeight(file);
  }

  Result<Drawing> Set(std::string_view text) {
    std::vector<std::string_view> lines;
    for (std::string_view rest = text;;) {
      const auto end = rest.find('\n');
      lines.push_back(rest.substr(0, end));
      if (end == rest.npos) break;
      rest.remove_prefix(end + 1);
    }
    Drawing drawing;
    const double step = options_.line_spacing_ratio * static_cast<double>(face_->height);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      INTAGLIO_TRY(SetLine(lines[i], -step * static_cast<double>(i), drawing));
    }
    std::erase_if(drawing.curves,
                  [](const Curve& curve) { return curve.pieces.empty(); });
    if (drawing.curves.empty()) {
      return Fail(ErrorCode::kMissing, "the text has no visible character");
    }
    Transform(options_.cap_height_mm / cap_height_ * Mat3::Identity(), Vec3::Zero(),
              drawing);
    return drawing;
  }

 private:
  Status FindCapHeight(const std::string& file) {
    const FT_UInt glyph = FT_Get_Char_Index(face_.get(), 'H');
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

  Status SetLine(std::string_view text, double baseline, Drawing& drawing) {
    const std::size_t first = drawing.curves.size();
    Pen pen{drawing.curves};
    FT_UInt last = 0;
    while (!text.empty()) {
      const std::optional<char32_t> code = NextCharacter(text);
      if (!code) {
        return Fail(ErrorCode::kUnreadable, "the text is not UTF-8; save it as UTF-8",
                    Shown(text));
      }
      if (*code == '\r') continue;
      if (auto ok = SetCharacter(*code, last, pen); !ok) return ok;
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

  Status SetCharacter(char32_t code, FT_UInt& last, Pen& pen) {
    if (++characters_ > options_.max_characters) {
      return Fail(ErrorCode::kTooLarge,
                  fmt::format("the text has more than {} characters; divide it",
                              options_.max_characters));
    }
    const FT_UInt glyph = FT_Get_Char_Index(face_.get(), code);
    if (glyph == 0 || FT_Load_Glyph(face_.get(), glyph, FT_LOAD_NO_SCALE) != 0) {
      const auto name = fmt::format("U+{:04X}", static_cast<std::uint32_t>(code));
      return Fail(
          ErrorCode::kMissing,
          fmt::format("the font {} has no character {}; use another font or text",
                      face_->family_name != nullptr ? face_->family_name : "", name),
          name);
    }
    FT_Vector kerning{0, 0};
    if (options_.kerning && last != 0) {
      FT_Get_Kerning(face_.get(), last, glyph, FT_KERNING_UNSCALED, &kerning);
    }
    pen.shift_x += static_cast<double>(kerning.x);
    FT_Outline_Funcs walk{MoveTo, LineTo, ConicTo, CubicTo, 0, 0};
    FT_Outline_Decompose(&face_->glyph->outline, &walk, &pen);
    pen.shift_x += static_cast<double>(face_->glyph->advance.x);
    last = glyph;
    return {};
  }

  const TextOptions& options_;
  Library library_;
  Face face_;
  double cap_height_ = 0;
  std::size_t characters_ = 0;
};

}  // namespace

Result<Drawing> TextOutline(std::string_view utf8, const TextOptions& options) {
  Require(options.cap_height_mm >= 0.1 && options.cap_height_mm <= 1000,
          "cap_height_mm must be 0.1 .. 1000, is {}", options.cap_height_mm);
  Require(options.line_spacing_ratio >= 0.5 && options.line_spacing_ratio <= 5,
          "line_spacing_ratio must be 0.5 .. 5, is {}", options.line_spacing_ratio);
  Typesetter typesetter(options);
  INTAGLIO_TRY(typesetter.Open());
  return typesetter.Set(utf8);
}

Result<std::string> FindFontFile(std::string_view family) {
  const auto colon = family.find(':');
  const std::string name(family.substr(0, colon));
  const std::string style(colon == family.npos ? "" : family.substr(colon + 1));
  const auto text = [](const std::string& s) {
    return reinterpret_cast<const FcChar8*>(s.c_str());
  };
  const FontConfig config(FcInitLoadConfigAndFonts());
  const FontPattern pattern(FcPatternCreate());
  FcPatternAddString(pattern.get(), FC_FAMILY, text(name));
  if (!style.empty()) FcPatternAddString(pattern.get(), FC_STYLE, text(style));
  const FontObjects objects(FcObjectSetBuild(FC_FILE, FC_STYLE, nullptr));
  const FontSet fonts(FcFontList(config.get(), pattern.get(), objects.get()));
  std::string best;
  bool best_preferred = false;
  for (int i = 0; fonts != nullptr && i < fonts->nfont; ++i) {
    FcChar8* file = nullptr;
    FcChar8* of_style = nullptr;
    if (FcPatternGetString(fonts->fonts[i], FC_FILE, 0, &file) != FcResultMatch) continue;
    const std::string path(reinterpret_cast<const char*>(file));
    const bool regular =
        FcPatternGetString(fonts->fonts[i], FC_STYLE, 0, &of_style) == FcResultMatch &&
        (std::string(reinterpret_cast<const char*>(of_style)) == "Regular" ||
         std::string(reinterpret_cast<const char*>(of_style)) == "Book");
    // The first by path, regular fonts first: the same result in whatever order the fonts
    // are listed.
    const bool preferred = regular && style.empty();
    if (best.empty() || std::pair(!preferred, path) < std::pair(!best_preferred, best)) {
      best = path;
      best_preferred = preferred;
    }
  }
  if (!best.empty()) return best;
  return Fail(ErrorCode::kNotFound,
              fmt::format("the font \"{}\" is not installed; install it, correct its "
                          "name or give its file",
                          family),
              std::string(family));
}

}  // namespace intaglio::drawing
