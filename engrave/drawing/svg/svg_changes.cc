#include "engrave/drawing/svg/svg_changes.h"

#include <algorithm>
#include <utility>

#include "engrave/drawing/drawing_builder.h"
#include "engrave/drawing/pieces.h"
#include "engrave/drawing/svg/svg_shapes.h"

namespace intaglio::drawing {
namespace {

/// Also of points between the ends of pieces: to a tenth of a piece's height.
Box3 BoxOf(const std::vector<Curve>& curves) {
  Box3 box;
  for (const Curve& curve : curves) {
    for (const Piece& piece : curve.pieces) {
      box.Extend(BeginOf(piece));
      box.Extend(EndOf(piece));
      for (const double t : {0.25, 0.5, 0.75}) {
        if (const auto* arc = std::get_if<EllipticArc>(&piece))
          box.Extend(PointAt(*arc, t));
        if (const auto* bezier = std::get_if<CubicBezier>(&piece))
          box.Extend(PointAt(*bezier, t));
      }
      if (const auto* line = std::get_if<Polyline>(&piece)) {
        for (const Vec3& p : line->points_mm) box.Extend(p);
      }
    }
  }
  return box;
}

bool IsBeyond(const Box3& box, const Vec2& page_mm) {
  const double slack_mm = 1e-6 * page_mm.maxCoeff();  // of the numbers of a file
  return !box.empty() && (box.min_mm.head<2>().minCoeff() < -slack_mm ||
                          box.max_mm.x() > page_mm.x() + slack_mm ||
                          box.max_mm.y() > page_mm.y() + slack_mm);
}

/// Values by which a property changes nothing.
bool IsInert(std::string_view value) {
  constexpr std::string_view kInert[] = {"",         "none",   "inherit", "initial",
                                         "unset",    "normal", "auto",    "revert",
                                         "view-box", "0",      "1",       "100%"};
  return std::ranges::find(kInert, value) != std::end(kInert);
}

}  // namespace

void AddSvgPropertiesNotObeyed(const SvgStyle& style, std::string_view transform,
                               std::vector<std::string>& names) {
  constexpr std::pair<SvgProperty, std::string_view> kProperties[] = {
      {SvgProperty::kTranslate, "translate"},
      {SvgProperty::kRotate, "rotate"},
      {SvgProperty::kScale, "scale"},
      {SvgProperty::kOffsetPath, "offset-path"},
      {SvgProperty::kZoom, "zoom"},
      {SvgProperty::kStrokeDasharray, "stroke-dasharray"}};
  for (const auto& [property, name] : kProperties) {
    if (!IsInert(style.value(property))) names.emplace_back(name);
  }
  if (!transform.empty() && !IsInert(style.value(SvgProperty::kTransformBox)))
    names.emplace_back("transform-box");
}

std::vector<FileFinding> SvgChangesOf(const SvgStyle& style,
                                      const std::vector<std::string>& not_obeyed,
                                      const SvgDocument& document,
                                      const std::vector<Curve>& curves,
                                      const std::optional<Vec2>& page_mm) {
  std::vector<FileFinding> met;
  const auto add = [&](const std::string& what, Effect effect,
                       std::string_view remedy = kConvertToCurves) {
    if (std::ranges::find(met, what, &FileFinding::what) == met.end())
      met.push_back({.what = what,
                     .where = {},
                     .remedy = std::string(remedy),
                     .count = 1,
                     .effect = effect});
  };
  for (const std::string& name : not_obeyed) add(name, Effect::kChanged);
  for (const SvgProperty property : {SvgProperty::kMarker, SvgProperty::kMarkerStart,
                                     SvgProperty::kMarkerMid, SvgProperty::kMarkerEnd}) {
    if (document.Find(style.value(property))) add("marker", Effect::kLost);
  }
  for (const std::string* paint : {&style.fill, &style.stroke}) {
    if (SvgName(document.Find(*paint).name()) == "pattern") add("pattern", Effect::kLost);
  }
  if (met.empty() && !page_mm) return met;
  const Box3 box = BoxOf(curves);
  if (page_mm && IsBeyond(box, *page_mm)) {
    add("edge of the page", Effect::kChanged, "remove what no viewer shows beyond it");
  }
  const double area_mm2 = box.empty() ? 0 : box.size_mm().head<2>().prod();
  for (FileFinding& finding : met) finding.area_mm2 = area_mm2;
  return met;
}

}  // namespace intaglio::drawing
