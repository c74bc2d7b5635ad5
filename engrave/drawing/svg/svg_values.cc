#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/drawing/svg/svg_path.h"

namespace intaglio::drawing {
namespace {

using std::numbers::pi;

constexpr double kMm = 96 / 25.4;  // CSS: 96 px an inch

/// Degrees of an angle with the unit of CSS, or without.
std::optional<double> AngleIn(double number, std::string_view unit) {
  if (unit.empty() || unit == "deg") return number;
  if (unit == "rad") return number * 180 / pi;
  if (unit == "grad") return number * 0.9;
  if (unit == "turn") return number * 360;
  return std::nullopt;
}

std::optional<double> PxOf(double number, std::string_view unit) {
  constexpr std::pair<std::string_view, double> kUnits[] = {
      {"", 1},    {"px", 1},         {"mm", kMm}, {"cm", 10 * kMm},
      {"in", 96}, {"pt", 96.0 / 72}, {"pc", 16},  {"Q", kMm / 4}};
  for (const auto& [name, px] : kUnits) {
    if (name == unit) return number * px;
  }
  return std::nullopt;
}

std::string_view UnitAt(std::string_view rest) {
  std::size_t size = 0;
  while (size < rest.size() &&
         ((rest[size] >= 'a' && rest[size] <= 'z') ||
          (rest[size] >= 'A' && rest[size] <= 'Z') || rest[size] == '%')) {
    ++size;
  }
  return rest.substr(0, size);
}

std::optional<SvgTransform> TransformOf(std::string_view name,
                                        const std::vector<double>& n) {
  const auto radians = [](double degrees) { return degrees * pi / 180; };
  const bool one = n.size() == 1, two = n.size() == 2;
  if (name == "matrix" && n.size() == 6)
    return SvgTransform{n[0], n[1], n[2], n[3], n[4], n[5]};
  if (name == "translate" && (one || two))
    return SvgTransform{1, 0, 0, 1, n[0], two ? n[1] : 0};
  if (name == "translateX" && one) return SvgTransform{1, 0, 0, 1, n[0], 0};
  if (name == "translateY" && one) return SvgTransform{1, 0, 0, 1, 0, n[0]};
  if (name == "scale" && (one || two)) return SvgTransform{n[0], 0, 0, n.back(), 0, 0};
  if (name == "scaleX" && one) return SvgTransform{n[0], 0, 0, 1, 0, 0};
  if (name == "scaleY" && one) return SvgTransform{1, 0, 0, n[0], 0, 0};
  if (name == "skewX" && one) return SvgTransform{1, 0, std::tan(radians(n[0])), 1, 0, 0};
  if (name == "skewY" && one) return SvgTransform{1, std::tan(radians(n[0])), 0, 1, 0, 0};
  if (name == "skew" && (one || two)) {
    return SvgTransform{
        1, two ? std::tan(radians(n[1])) : 0, std::tan(radians(n[0])), 1, 0, 0};
  }
  if ((name == "rotate" && (one || n.size() == 3)) || (name == "rotateZ" && one)) {
    const double c = std::cos(radians(n[0])), s = std::sin(radians(n[0]));
    const SvgTransform turn{c, s, -s, c, 0, 0};
    if (one) return turn;
    return SvgTransform{1, 0, 0, 1, n[1], n[2]}.Then(turn).Then(
        {1, 0, 0, 1, -n[1], -n[2]});
  }
  return std::nullopt;
}

/// The numbers up to the closing bracket, as degrees or px.
std::optional<std::vector<double>> ArgumentsOf(std::string_view name,
                                               SvgNumbers& numbers) {
  const bool turns = name.starts_with("rotate") || name.starts_with("skew");
  std::vector<double> values;
  while (numbers.Peek() != ')') {
    const std::optional<double> number = numbers.Next();
    if (!number || values.size() == 6) return std::nullopt;
    const std::string_view unit = UnitAt(numbers.rest());
    // Behind the angle of a rotate: its centre.
    const bool is_angle = turns && (values.empty() || name == "skew");
    const auto value = is_angle ? AngleIn(*number, unit) : PxOf(*number, unit);
    if (!value) return std::nullopt;
    numbers = SvgNumbers(numbers.rest().substr(unit.size()));
    values.push_back(*value);
    numbers.SkipComma();
  }
  numbers.Skip();
  return values;
}

}  // namespace

bool SvgTransform::HasNoArea() const {
  constexpr double kRounding = 1e-12;
  return std::abs(a * d - b * c) <= kRounding * (a * a + b * b + c * c + d * d);
}

SvgTransform SvgTransform::Then(const SvgTransform& inner) const {
  return {a * inner.a + c * inner.b,     b * inner.a + d * inner.b,
          a * inner.c + c * inner.d,     b * inner.c + d * inner.d,
          a * inner.e + c * inner.f + e, b * inner.e + d * inner.f + f};
}

std::optional<SvgTransform> ParseSvgTransform(std::string_view text) {
  SvgTransform whole;
  SvgNumbers numbers(text);
  while (numbers.Peek() != '\0') {
    const std::string_view rest = numbers.rest();
    const auto open = rest.find('(');
    if (open == rest.npos) return rest == "none" ? std::optional(whole) : std::nullopt;
    std::string_view name = rest.substr(0, open);
    while (!name.empty() && IsSvgBlank(name.back())) name.remove_suffix(1);
    numbers = SvgNumbers(rest.substr(open + 1));
    const auto values = ArgumentsOf(name, numbers);
    if (!values) return std::nullopt;
    numbers.SkipComma();
    const std::optional<SvgTransform> next = TransformOf(name, *values);
    if (!next) return std::nullopt;
    whole = whole.Then(*next);
  }
  return whole;
}

std::optional<double> ParseSvgLength(std::string_view text, double whole, double em) {
  SvgNumbers numbers(text);
  const std::optional<double> number = numbers.Next();
  if (!number) return std::nullopt;
  std::string_view unit = numbers.rest();
  while (!unit.empty() && IsSvgBlank(unit.back())) unit.remove_suffix(1);
  if (const auto px = PxOf(*number, unit)) return px;
  if (unit == "%" || unit == "vw" || unit == "vh") return *number / 100 * whole;
  if (unit == "em") return *number * em;
  if (unit == "ex" || unit == "ch") return *number * em / 2;
  constexpr double kRootEm = 16;
  if (unit == "rem") return *number * kRootEm;
  return std::nullopt;
}

std::optional<Vec2> ParseSvgOrigin(std::string_view text, const Vec2& page, double em) {
  std::array<std::string_view, 2> words;
  std::size_t count = 0;
  while (count < 2) {
    while (!text.empty() && (IsSvgBlank(text.front()) || text.front() == ','))
      text.remove_prefix(1);
    if (text.empty()) break;
    words.at(count++) = text.substr(0, text.find_first_of(" \t\r\n\f,"));
    text.remove_prefix(words.at(count - 1).size());
  }
  if (count == 0) return std::nullopt;
  if (count == 1) words[1] = "center";
  const auto is_y = [](std::string_view word) {
    return word == "top" || word == "bottom";
  };
  if (is_y(words[0]) || words[1] == "left" || words[1] == "right")
    std::swap(words[0], words[1]);
  Vec2 origin;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    const std::string_view word = words.at(axis);
    if (word == "left" || word == "top") {
      origin[i] = 0;
    } else if (word == "center") {
      origin[i] = page[i] / 2;
    } else if (word == "right" || word == "bottom") {
      origin[i] = page[i];
    } else if (const auto length = ParseSvgLength(word, page[i], em)) {
      origin[i] = *length;
    } else {
      return std::nullopt;
    }
  }
  return origin;
}

std::optional<SvgViewBox> ParseSvgViewBox(std::string_view text) {
  SvgNumbers numbers(text);
  std::array<double, 4> values{};
  for (double& value : values) {
    const std::optional<double> number = numbers.Next();
    if (!number) return std::nullopt;
    value = *number;
    numbers.SkipComma();
  }
  if (!(values[2] > 0 && values[3] > 0)) return std::nullopt;
  return SvgViewBox{{values[0], values[1]}, {values[2], values[3]}};
}

SvgTransform FitSvgViewBox(const SvgViewBox& box, const Vec2& size,
                           std::string_view preserve_aspect_ratio) {
  const std::string_view fit = preserve_aspect_ratio;
  Vec2 scale = size.cwiseQuotient(box.size);
  Vec2 align(0.5, 0.5);
  if (!fit.starts_with("none")) {
    const bool slice = fit.find("slice") != fit.npos;
    scale.setConstant(slice ? scale.maxCoeff() : scale.minCoeff());
    if (fit.find("xMin") != fit.npos) align.x() = 0;
    if (fit.find("xMax") != fit.npos) align.x() = 1;
    if (fit.find("YMin") != fit.npos) align.y() = 0;
    if (fit.find("YMax") != fit.npos) align.y() = 1;
  }
  const Vec2 room = align.cwiseProduct(size - scale.cwiseProduct(box.size));
  const Vec2 offset = room - scale.cwiseProduct(box.low);
  return {scale.x(), 0, 0, scale.y(), offset.x(), offset.y()};
}

}  // namespace intaglio::drawing
