#include "engrave/drawing/svg/svg_scope.h"

#include <fmt/format.h>

#include "engrave/drawing/pieces.h"
#include "engrave/drawing/svg/svg_elements.h"
#include "engrave/drawing/svg/svg_shapes.h"

namespace intaglio::drawing {

void ToPage(const SvgTransform& t, Piece& piece) {
  Mat3 linear = Mat3::Identity();
  linear.topLeftCorner<2, 2>() << t.a, t.c, t.b, t.d;
  Transform(linear, Vec3(t.e, t.f, 0), piece);
}

Curve SvgBoxOf(const SvgTransform& transform, const Vec2& size) {
  const Vec3 right(size.x(), 0, 0), down(0, size.y(), 0);
  Curve box{{Polyline{{Vec3::Zero(), right, right + down, down}}}, true};
  ToPage(transform, box.pieces.front());
  return box;
}

void SvgScopes::TakeLength(const pugi::xml_node& node, const SvgStyle& style,
                           const char* attribute, double whole, double em,
                           double& length) {
  const std::string_view text = style.Attribute(node, attribute);
  if (text.empty() || text == "auto") return;
  const std::optional<double> value = ParseSvgLength(text, whole, em);
  if (value) {
    length = *value;
  } else {
    LeaveOut(node, attribute);
  }
}

void SvgScopes::LeaveOut(const pugi::xml_node& node, std::string_view attribute) {
  builder_.LeaveOutAt(fmt::format("{} with a wrong {}", SvgName(node.name()), attribute),
                      Effect::kChanged, [&] { return document_.PlaceOf(node); });
}

void SvgScopes::TakeViewBox(const pugi::xml_node& node, const Vec2& size,
                            SvgScope& scope) {
  scope.page = size;
  const char* text = node.attribute("viewBox").value();
  if (*text == '\0') return;
  const auto box = ParseSvgViewBox(text);
  if (!box) return LeaveOut(node, "viewBox");
  scope.to_page = scope.to_page.Then(
      FitSvgViewBox(*box, size, node.attribute("preserveAspectRatio").value()));
  scope.page = box->size;
}

bool SvgScopes::TakeStyle(const pugi::xml_node& node, SvgScope& scope, SvgStyle& style) {
  if (scope.references > 0 && !CountAgain(node, {"style", "class", "transform"})) {
    return false;
  }
  if (!document_.sheets().StyleOf(node, style)) return false;
  scope.hidden = style.hidden.value_or(scope.hidden);
  if (!style.stroke.empty()) {
    scope.color = builder_.NameIndex(style.stroke);
    scope.stroked = IsSvgPaint(style.stroke);
  }
  if (!style.fill.empty()) scope.filled = IsSvgPaint(style.fill);
  const std::string& rule = style.value(SvgProperty::kClipRule);
  if (!rule.empty() && rule != "inherit") scope.clips_even_odd = rule == "evenodd";
  const std::string& letters = style.value(SvgProperty::kFontSize);
  scope.em = ParseSvgLength(letters, scope.em, scope.em).value_or(scope.em);
  return true;
}

void SvgScopes::TakeTransform(const pugi::xml_node& node, const SvgStyle& style,
                              SvgScope& scope) {
  const std::string_view text = style.Attribute(node, "transform");
  if (text.empty()) return;
  const std::optional<SvgTransform> parsed = ParseSvgTransform(text);
  if (!parsed) return LeaveOut(node, "transform");
  Vec2 origin = Vec2::Zero();
  if (const std::string_view at = style.Attribute(node, "transform-origin");
      !at.empty()) {
    const auto point = ParseSvgOrigin(at, scope.page, scope.em);
    if (!point) LeaveOut(node, "transform-origin");
    origin = point.value_or(origin);
  }
  scope.to_page = scope.to_page.Then({1, 0, 0, 1, origin.x(), origin.y()})
                      .Then(*parsed)
                      .Then({1, 0, 0, 1, -origin.x(), -origin.y()});
}

void SvgScopes::TakePlaceOfUse(const pugi::xml_node& node, const SvgStyle& style,
                               SvgScope& scope) {
  Vec2 at = Vec2::Zero();
  TakeLength(node, style, "x", scope.page.x(), scope.em, at.x());
  TakeLength(node, style, "y", scope.page.y(), scope.em, at.y());
  scope.to_page = scope.to_page.Then({1, 0, 0, 1, at.x(), at.y()});
}

bool SvgScopes::CurvesOf(const pugi::xml_node& node, const SvgStyle& style,
                         const SvgScope& scope, std::vector<Curve>& curves) {
  DrawingBuilder probe("", builder_.limits());
  const SvgScale scale{scope.page, scope.em};
  if (SvgShapeCurves(node, style, scale, "", probe, curves)) return true;
  const Error error = probe.Take().error();
  if (error.code != ErrorCode::kInvalidValue)
    return builder_.Refuse(error.code, document_.PlaceOf(node), error.message,
                           error.value);
  builder_.LeaveOutAt(
      fmt::format("{}, {}", SvgName(node.name()), error.message.substr(2)),
      Effect::kChanged, [&] { return document_.PlaceOf(node); });
  return true;
}

bool SvgScopes::CountAgain(const pugi::xml_node& node,
                           std::initializer_list<const char*> attributes) {
  std::size_t bytes = 50;
  for (const char* attribute : attributes) {
    bytes += std::string_view(node.attribute(attribute).value()).size();
  }
  return builder_.CountUnfolded(bytes, "use");
}

}  // namespace intaglio::drawing
