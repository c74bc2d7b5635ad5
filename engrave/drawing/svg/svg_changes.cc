#include "engrave/drawing/svg/svg_changes.h"

#include "engrave/drawing/pieces.h"
#include "engrave/drawing/svg/svg_shapes.h"

namespace intaglio::drawing {
namespace {

double AreaOfBox(const std::vector<Curve>& curves) {
  if (curves.empty()) return 0;
  Box3 box;
  for (const Curve& curve : curves) {
    for (const Piece& piece : curve.pieces) {
      box.Extend(BeginOf(piece));
      box.Extend(EndOf(piece));
      if (const auto* arc = std::get_if<EllipticArc>(&piece)) {
        for (const double t : {0.25, 0.5, 0.75}) box.Extend(PointAt(*arc, t));
      }
      if (const auto* line = std::get_if<Polyline>(&piece)) {
        for (const Vec3& p : line->points_mm) box.Extend(p);
      }
    }
  }
  return box.size_mm().x() * box.size_mm().y();
}

}  // namespace

std::vector<FileFinding> SvgChangesOf(const SvgStyle& style,
                                      const std::vector<std::string>& not_obeyed,
                                      const SvgDocument& document,
                                      const std::vector<Curve>& curves) {
  std::vector<FileFinding> met;
  const auto add = [&](const std::string& what, Effect effect) {
    if (met.empty() || met.back().what != what)
      met.push_back(
          {.what = what, .where = {}, .remedy = {}, .count = 1, .effect = effect});
  };
  for (const std::string& name : not_obeyed) add(name, Effect::kChanged);
  for (const SvgProperty property : {SvgProperty::kMarker, SvgProperty::kMarkerStart,
                                     SvgProperty::kMarkerMid, SvgProperty::kMarkerEnd}) {
    if (document.Find(style.value(property))) add("marker", Effect::kLost);
  }
  for (const std::string* paint : {&style.fill, &style.stroke}) {
    if (SvgName(document.Find(*paint).name()) == "pattern") add("pattern", Effect::kLost);
  }
  if (met.empty()) return met;
  const double area_mm2 = AreaOfBox(curves);
  for (FileFinding& finding : met) finding.area_mm2 = area_mm2;
  return met;
}

}  // namespace intaglio::drawing
