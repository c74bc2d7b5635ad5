#include "engrave/render/text.h"

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

// A glyph is a list of strokes, separated by blanks. A stroke begins with its kind,
//   l  straight lines from point to point
//   s  a smooth curve: the quadratic B-spline of the points, with its ends on the first
//      and last
//   c  the same, closed
// and goes on with points: a digit for x and a letter for y, d the baseline, j the
// height of an x, m the height of a capital (9 units), a the depth of a tail.

namespace intaglio::render {
namespace {

constexpr double kUnitsPerCap = 9.0;
constexpr double kTopUnits = 12.5;   ///< The marks of capitals.
constexpr double kGapUnits = 2.3;    ///< Between glyphs.
constexpr double kSpaceUnits = 4.2;  ///< A blank, gaps not counted.
constexpr int kCurveSteps = 5;       ///< Chords for each corner of a curve.

constexpr std::array<const char*, 95> kAscii = {
    "",                                       // blank
    "l0m0g l0d0d",                            // !
    "l0m0k l2m2k",                            // "
    "l1d2m l4d5m l0g6g l0j6j",                // #
    "s5k5m0m0i5h5d0d0f l2c3n",                // $
    "l0d6m c0j2j2m0m c4d6d6g4g",              // %
    "s6d1j1m4m4j0g0d4d6h",                    // &
    "l0m0k",                                  // '
    "s2n0k0e2b",                              // (
    "s0n2k2e0b",                              // )
    "l2i2m l0j4l l0l4j",                      // *
    "l0h4h l2f2j",                            // +
    "l1d0b",                                  // ,
    "l0h3h",                                  // -
    "l0d0d",                                  // .
    "l0c4m",                                  // /
    "c0d5d5m0m",                              // 0
    "l1k3m3d l1d5d",                          // 1
    "s0k0m5m5i3g0d l0d5d",                    // 2
    "s0k0m5m5i2i s2i5i5d0d0f",                // 3
    "l4d4m0g5g",                              // 4
    "l5m1m0i s0i2k5j5d1d0e",                  // 5
    "s5l4m0m0g c0d5d5j0j",                    // 6
    "l0m5m2d",                                // 7
    "c0d5d5i0i c0i5i5m0m",                    // 8
    "s0e1d5d5j c0g5g5m0m",                    // 9
    "l0d0d l0i0i",                            // :
    "l1i1i l1d0b",                            // ;
    "l4j0h4f",                                // <
    "l0g4g l0i4i",                            // =
    "l0j4h0f",                                // >
    "s0k0m4m4i2i2g l2d2d",                    // ?
    "c2f4f4j2j s4j4f6f6m0m0d5d",              // @
    "l0d3m6d l1g5g",                          // A
    "l3d0d0m3m s3m5m5i3i l0i3i s3i5i5d3d",    // B
    "s5k5m0m0d5d5f",                          // C
    "l2d0d0m2m s2m5m5d2d",                    // D
    "l5d0d0m5m l0i4i",                        // E
    "l0d0m5m l0i4i",                          // F
    "s5k5m0m0d5d5h l3h5h",                    // G
    "l0d0m l5d5m l0i5i",                      // H
    "l0d2d l1d1m l0m2m",                      // I
    "l4m4g s4g4d0d0g",                        // J
    "l0d0m l5m0g l2i5d",                      // K
    "l0m0d5d",                                // L
    "l0d0m3g6m6d",                            // M
    "l0d0m5d5m",                              // N
    "c0d6d6m0m",                              // O
    "l0d0m3m s3m5m5h3h l3h0h",                // P
    "c0d6d6m0m l4f6d",                        // Q
    "l0d0m3m s3m5m5h3h l3h0h l2h5d",          // R
    "s5k5m0m0i5h5d0d0f",                      // S
    "l0m6m l3m3d",                            // T
    "l0m0g s0g0d5d5g l5g5m",                  // U
    "l0m3d6m",                                // V
    "l0m2d4k6d8m",                            // W
    "l0d5m l0m5d",                            // X
    "l0m3h6m l3h3d",                          // Y
    "l0m5m0d5d",                              // Z
    "l2n0n0b2b",                              // [
    "l0m4c",                                  // backslash
    "l0n2n2b0b",                              // ]
    "l0k2m4k",                                // ^
    "l0c5c",                                  // _
    "l0m1k",                                  // `
    "c0d4d4j0j l4d4j",                        // a
    "c0d4d4j0j l0d0m",                        // b
    "s4i4j0j0d4d4e",                          // c
    "c0d4d4j0j l4d4m",                        // d
    "l0g4g s4g4j0j0d3d4e",                    // e
    "s3m1m1k l1k1d l0j3j",                    // f
    "c0d4d4j0j l4j4c s4c4a0a0b",              // g
    "l0d0m s0h0j4j4g l4g4d",                  // h
    "l0d0j l0l0l",                            // i
    "l2j2c s2c2a0a l2l2l",                    // j
    "l0d0m l4j0f l1g4d",                      // k
    "l0m0f s0f0d2d",                          // l
    "l0d0j s0h0j3j3g l3g3d s3h3j6j6g l6g6d",  // m
    "l0d0j s0h0j4j4g l4g4d",                  // n
    "c0d4d4j0j",                              // o
    "c0d4d4j0j l0j0a",                        // p
    "c0d4d4j0j l4j4a",                        // q
    "l0d0j s0h0j3j",                          // r
    "s4i4j0j0g4g4d0d0e",                      // s
    "l1l1f s1f1d3d l0j3j",                    // t
    "l0j0g s0g0d4d4f l4d4j",                  // u
    "l0j2d4j",                                // v
    "l0j1d3i5d6j",                            // w
    "l0d4j l0j4d",                            // x
    "l0j2d l4j1a",                            // y
    "l0j4j0d4d",                              // z
    "s3n1n1h0h s0h1h1b3b",                    // {
    "l0n0b",                                  // |
    "s0n2n2h3h s3h2h2b0b",                    // }
    "s0h1j3f4h",                              // ~
};

const char* StrokesOf(char32_t sign) {
  if (sign >= U' ' && sign <= U'~') return kAscii[sign - U' '];
  switch (sign) {
    case U'µ':
    case U'μ':
      return "l0j0a s0g0d4d4f l4d4j";
    case U'°':
      return "c0j3j3m0m";
    case U'±':
      return "l0i4i l2g2k l0e4e";
    case U'×':
      return "l0f4j l0j4f";
    case U'·':
      return "l0h0h";
    case U'–':
      return "l0h5h";
    case U'²':
      return "s0l0m2m2l0i l0i2i";
    case U'ß':
      return "l0d0k s0k0m4m4i2i s2i5i5d2d";
    case U'æ':
      return "c0d3d3j0j l3g7g s7g7j3j3d6d";
    case U'œ':
      return "c0d4d4j0j l4g8g s8g8j4j4d7d";
    case U'Æ':
      return "l0d4m7m l4m4d7d l1g4g l4i6i";
    case U'ı':
      return "l0d0j";
    case U'³':
      return "s0m2m2k1k s1k2k2i0i";
    default:
      return "l0d4d4m0m0d";
  }
}

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
  double width = 0.0;  ///< Units.
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

}  // namespace

double TextWidth(std::string_view text, double cap_height_px) {
  double units = 0.0;
  for (const char32_t sign : Decode(text)) {
    units += GlyphOf(sign).width + kGapUnits;
  }
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
  for (const char32_t sign : Decode(text)) {
    const Glyph glyph = GlyphOf(sign);
    DrawGlyph(canvas, glyph, pen, unit_px, stroke_px, style);
    pen.x() += (glyph.width + kGapUnits) * unit_px;
  }
}

}  // namespace intaglio::render
