#pragma once

// The texts of SVG that hold numbers: path data, points, transforms, lengths.
// Frame: the user space of the element, y down.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/drawing/drawing.h"

namespace intaglio::drawing {

inline bool IsSvgBlank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f';
}

/// Numbers of SVG, one after another, behind blanks and at most one comma.
class SvgNumbers {
 public:
  explicit SvgNumbers(std::string_view text) : rest_(text) {}

  /// The next number; none at the end, at another character, and when not finite.
  std::optional<double> Next();
  /// A flag of an arc; the next number may follow without a blank.
  std::optional<bool> NextFlag();
  /// The next character, past blanks; 0 at the end.
  char Peek();
  void Skip() { rest_.remove_prefix(1); }
  void SkipBlanks();
  void SkipComma();
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

/// What is wrong with a text, and where in it.
struct SvgTextError {
  std::string sentence;
  std::string near;
};

/// The curves of path data, with arcs as arcs and quadratics as cubics. `max_points`
/// bounds their control points. The text is right to its end, or an error.
std::optional<SvgTextError> ParseSvgPath(std::string_view text, std::uint64_t max_points,
                                         std::vector<Curve>& curves);

/// From p to q as an arc of the ellipse of these radii and turn (SVG 1.1, F.6: from
/// endpoints to centre; radii too small are enlarged). A line when a radius is 0.
Piece SvgArc(const Vec3& p, const Vec3& q, Vec2 radii, double turn_deg, bool large,
             bool positive);

/// x' = a x + c y + e, y' = b x + d y + f.
struct SvgTransform {
  double a = 1, b = 0, c = 0, d = 1, e = 0, f = 0;

  SvgTransform Then(const SvgTransform& inner) const;
  /// It leaves no area of anything: no viewer shows what it moves (CSS Transforms 1).
  bool HasNoArea() const;
};
/// Of an attribute or of CSS, with its units (CSS Transforms 1, chapter 12). None when
/// the list is wrong, or in three dimensions, or a share of a box.
std::optional<SvgTransform> ParseSvgTransform(std::string_view text);

/// A length in user units: px, mm, cm, Q, in, pt, pc or none; em, ex, rem, ch of letters
/// of `em` px; a share of `whole` for %, vw, vh. None when it is something else.
std::optional<double> ParseSvgLength(std::string_view text, double whole, double em = 16);

/// The point of transform-origin: lengths, percent or keywords. None when it is wrong.
std::optional<Vec2> ParseSvgOrigin(std::string_view text, const Vec2& page, double em);

struct SvgViewBox {
  Vec2 low = Vec2::Zero(), size = Vec2::Zero();
};
/// Four finite numbers, the size positive; none otherwise.
std::optional<SvgViewBox> ParseSvgViewBox(std::string_view text);
/// The transform that fits the box into a viewport of this size (SVG 1.1, 7.8).
SvgTransform FitSvgViewBox(const SvgViewBox& box, const Vec2& size,
                           std::string_view preserve_aspect_ratio);

}  // namespace intaglio::drawing
