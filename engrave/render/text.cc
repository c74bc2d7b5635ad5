#include "engrave/render/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "engrave/core/segment.h"
#include "engrave/render/accents.h"
#include "engrave/render/letters/letter_outlines.h"
#include "engrave/render/letters/stroke_letters.h"

namespace intaglio::render {
namespace {

constexpr double kUnitsPerCap = 9.0;
constexpr double kTopUnits = 12.5;   ///< The marks of capitals.
constexpr double kGapUnits = 2.3;    ///< Between glyphs.
constexpr double kSpaceUnits = 4.2;  ///< A blank, gaps not counted.
constexpr int kCurveSteps = 5;       ///< Chords for each corner of a curve.

/// The signs of a UTF-8 text; a byte out of place gives U+FFFD.
std::u32string Decode(std::string_view text) {
  std::u32string signs;
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<std::uint8_t>(text[i++]);
    const int more = first < 0x80 ? 0 : first >= 0xF0 ? 3 : first >= 0xE0 ? 2 : 1;
    char32_t sign = first < 0x80 ? first : first & (0x3FU >> more);
    bool whole = first < 0x80 || first >= 0xC0;
    for (int k = 0; k < more && whole; ++k) {
      whole = i < text.size() && (static_cast<std::uint8_t>(text[i]) & 0xC0U) == 0x80U;
      if (whole) sign = (sign << 6U) | (static_cast<std::uint8_t>(text[i++]) & 0x3FU);
    }
    signs.push_back(whole ? sign : U'\uFFFD');
  }
  return signs;
}

using Polyline = std::vector<Vec2>;  ///< In font units, y up.

Polyline Smooth(const Polyline& corners, bool closed) {
  Polyline curve;
  const std::size_t n = corners.size();
  if (!closed) curve.push_back(corners.front());
  // Each inner corner bends the line from one edge's middle to the next's; the first
  // and last edges of an open curve count from their ends.
  const std::size_t first = closed ? 0 : 1;
  const std::size_t last = closed ? n : n - 1;
  for (std::size_t i = first; i < last; ++i) {
    const Vec2& corner = corners[i];
    const Vec2& before = corners[(i + n - 1) % n];
    const Vec2& after = corners[(i + 1) % n];
    const Vec2 from = !closed && i == 1 ? before : Vec2(0.5 * (before + corner));
    const Vec2 to = !closed && i == n - 2 ? after : Vec2(0.5 * (corner + after));
    for (int k = 0; k <= kCurveSteps; ++k) {
      const double u = static_cast<double>(k) / kCurveSteps;
      curve.push_back((1 - u) * (1 - u) * from + 2 * u * (1 - u) * corner + u * u * to);
    }
  }
  if (closed) curve.push_back(curve.front());
  return curve;
}

struct Glyph {
  std::vector<Polyline> strokes;
  std::vector<Polyline> loops;  ///< filled: letters of another font
  double width = 0.0;           ///< Units.
};

Glyph ParseGlyph(std::string_view strokes) {
  Glyph glyph;
  if (strokes.empty()) glyph.width = kSpaceUnits - kGapUnits;
  while (!strokes.empty()) {
    const std::size_t end = std::min(strokes.find(' '), strokes.size());
    const std::string_view stroke = strokes.substr(0, end);
    strokes.remove_prefix(std::min(end + 1, strokes.size()));
    Polyline points;
    for (std::size_t i = 1; i + 1 < stroke.size(); i += 2) {
      points.emplace_back(stroke[i] - '0', stroke[i + 1] - 'd');
      glyph.width = std::max(glyph.width, points.back().x());
    }
    glyph.strokes.push_back(stroke[0] == 'l' ? points : Smooth(points, stroke[0] == 'c'));
  }
  return glyph;
}

double HeightOf(const Glyph& glyph) {
  double height = 0.0;
  for (const Polyline& stroke : glyph.strokes) {
    for (const Vec2& p : stroke) height = std::max(height, p.y());
  }
  return height;
}

/// The mark of an accented letter lies above or below the letter, or across it.
Glyph GlyphOf(char32_t sign) {
  const auto accented = SplitAccent(sign);
  if (!accented) return ParseGlyph(StrokesOf(sign));
  const bool above = accented->mark < Mark::kCedilla;
  // The dot gives way to another mark.
  const char32_t base = above && accented->base == 'i' ? U'ı' : char32_t(accented->base);
  Glyph glyph = ParseGlyph(StrokesOf(base));
  for (Polyline& stroke : StrokesOfMark(accented->mark, glyph.width, HeightOf(glyph))) {
    glyph.strokes.push_back(std::move(stroke));
  }
  return glyph;
}

bool HasStrokes(char32_t sign) { return SplitAccent(sign) || StrokesOf(sign); }

/// "<5C71>": what no font of this computer has is drawn as its number.
std::vector<Glyph> NumberOf(char32_t sign) {
  std::vector<Glyph> glyphs;
  for (const char c : fmt::format("<{:04X}>", static_cast<std::uint32_t>(sign)))
    glyphs.push_back(GlyphOf(static_cast<char32_t>(c)));
  return glyphs;
}

/// Hebrew to Arabic Extended-A, and the presentation forms of both (Unicode 15).
bool RunsToTheLeft(char32_t sign) {
  return (sign >= 0x590 && sign <= 0x8FF) || (sign >= 0xFB1D && sign <= 0xFDFF) ||
         (sign >= 0xFE70 && sign <= 0xFEFC);
}

/// The letters at the begin of `signs` that this font does not have, of one direction.
/// Words that run to the left are one run, because their order is from the right, too.
std::u32string_view ForeignAtBegin(std::u32string_view signs) {
  const bool to_the_left = RunsToTheLeft(signs.front());
  std::size_t end = 0;
  for (std::size_t i = 0; i < signs.size(); ++i) {
    const bool foreign = !HasStrokes(signs[i]);
    if (foreign && RunsToTheLeft(signs[i]) == to_the_left)
      end = i + 1;
    else if (foreign || signs[i] != U' ' || !to_the_left)
      break;
  }
  return signs.substr(0, end);
}

Glyph GlyphOf(LetterOutlines&& outlines) {
  Glyph glyph;
  glyph.width = kUnitsPerCap * outlines.width;
  glyph.loops = std::move(outlines.loops);
  for (Polyline& loop : glyph.loops)
    for (Vec2& p : loop) p *= kUnitsPerCap;
  return glyph;
}

/// Adds as much of a foreign run as there are letters for, and returns its length: all,
/// the first word, the first letter; or the number of that.
std::size_t AddForeign(std::u32string_view run, std::vector<Glyph>& glyphs) {
  const std::size_t word = std::min(run.find(U' '), run.size());
  for (const std::size_t length : {run.size(), word, std::size_t{1}}) {
    auto outlines = OutlinesOfLetters(run.substr(0, length));
    if (!outlines) continue;
    glyphs.push_back(GlyphOf(std::move(*outlines)));
    return length;
  }
  for (Glyph& glyph : NumberOf(run.front())) glyphs.push_back(std::move(glyph));
  return 1;
}

std::vector<Glyph> GlyphsOf(std::string_view text) {
  const std::u32string decoded = Decode(text);
  std::u32string_view signs = decoded;
  std::vector<Glyph> glyphs;
  while (!signs.empty()) {
    if (HasStrokes(signs.front())) {
      glyphs.push_back(GlyphOf(signs.front()));
      signs.remove_prefix(1);
    } else {
      signs.remove_prefix(AddForeign(ForeignAtBegin(signs), glyphs));
    }
  }
  return glyphs;
}

double DistanceTo(const Polyline& line, const Vec2& p) {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    smallest = std::min(smallest, SquaredDistanceFromSegment(p, line[i], line[i + 1]));
  }
  return std::sqrt(smallest);
}

/// All strokes at once, so that joints are not painted twice.
void DrawGlyph(Canvas& canvas, const Glyph& glyph, const Vec2& origin_px, double unit_px,
               double stroke_px, const TextStyle& style) {
  if (glyph.strokes.empty()) return;
  const double margin_px = stroke_px + 1.0;
  const int left = static_cast<int>(std::floor(origin_px.x() - margin_px));
  const int right =
      static_cast<int>(std::ceil(origin_px.x() + glyph.width * unit_px + margin_px));
  const int top =
      static_cast<int>(std::floor(origin_px.y() - kTopUnits * unit_px - margin_px));
  const int bottom = static_cast<int>(std::ceil(origin_px.y() + 3 * unit_px + margin_px));
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      const Vec2 at((x + 0.5 - origin_px.x()) / unit_px,
                    (origin_px.y() - y - 0.5) / unit_px);
      double distance = std::numeric_limits<double>::infinity();
      for (const Polyline& stroke : glyph.strokes) {
        distance = std::min(distance, DistanceTo(stroke, at));
      }
      const double covered =
          std::clamp(0.5 * stroke_px + 0.5 - distance * unit_px, 0.0, 1.0);
      if (covered > 0.0) {
        canvas.Blend(x, y, style.color, style.alpha * static_cast<float>(covered));
      }
    }
  }
}

void FillGlyph(Canvas& canvas, const Glyph& glyph, const Vec2& origin_px, double unit_px,
               const TextStyle& style) {
  std::vector<Polyline> loops_px = glyph.loops;
  for (Polyline& loop : loops_px) {
    for (Vec2& p : loop) p = origin_px + unit_px * Vec2(p.x(), -p.y());
  }
  FillLoops(canvas, loops_px, {style.color, style.alpha});
}

}  // namespace

double TextWidth(std::string_view text, double cap_height_px) {
  double units = 0.0;
  for (const Glyph& glyph : GlyphsOf(text)) units += glyph.width + kGapUnits;
  return std::max(0.0, units - kGapUnits) * cap_height_px / kUnitsPerCap;
}

std::vector<std::string> WrapText(std::string_view text, double cap_height_px,
                                  double width_px) {
  std::vector<std::string> lines;
  std::string line;
  const auto fits = [&](const std::string& candidate) {
    return TextWidth(candidate, cap_height_px) <= width_px;
  };
  const auto end_line = [&] {
    if (!line.empty()) lines.push_back(std::exchange(line, {}));
  };
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    std::string token(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!line.empty() && fits(line + " " + token)) {
      line += " " + token;
      continue;
    }
    end_line();
    while (token.size() > 1 && !fits(token)) {
      std::size_t kept = token.size();
      // Between characters of UTF-8, not within one.
      const auto shorten = [&] {
        do --kept;
        while (kept > 1 && (static_cast<unsigned char>(token[kept]) & 0xC0U) == 0x80U);
      };
      do shorten();
      while (kept > 1 && !fits(token.substr(0, kept)));
      lines.push_back(token.substr(0, kept));
      token.erase(0, kept);
    }
    line = token;
  }
  end_line();
  return lines;
}

TextStyle FittingStyle(std::string_view text, TextStyle style, double width_px) {
  const double width = TextWidth(text, style.cap_height_px);
  if (width > width_px && width_px > 0.0) style.cap_height_px *= width_px / width;
  return style;
}

void DrawText(Canvas& canvas, const Vec2& at_px, std::string_view text,
              const TextStyle& style) {
  const double unit_px = style.cap_height_px / kUnitsPerCap;
  const double stroke_px = std::max(1.0, 0.115 * style.cap_height_px * style.weight);
  const double share = style.align == Align::kLeft     ? 0.0
                       : style.align == Align::kCenter ? 0.5
                                                       : 1.0;
  const double width_px = TextWidth(text, style.cap_height_px);
  // Whole pixels keep stems and baselines equally sharp wherever the text is placed.
  Vec2 pen(std::round(at_px.x() - share * width_px), std::round(at_px.y()));
  for (const Glyph& glyph : GlyphsOf(text)) {
    FillGlyph(canvas, glyph, pen, unit_px, style);
    DrawGlyph(canvas, glyph, pen, unit_px, stroke_px, style);
    pen.x() += (glyph.width + kGapUnits) * unit_px;
  }
}

}  // namespace intaglio::render
