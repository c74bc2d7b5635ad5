#include "engrave/drawing/svg/svg_clip.h"

#include <algorithm>
#include <utility>

#include "engrave/drawing/flatten.h"
#include "engrave/drawing/svg/svg_changes.h"
#include "engrave/drawing/svg/svg_elements.h"
#include "engrave/drawing/svg/svg_shapes.h"

namespace intaglio::drawing {
namespace {

constexpr int kMaxClipsOfClips = 8;

/// Properties that move what a clip is made of and that are not obeyed.
bool IsMovedByOthers(const pugi::xml_node& node, const SvgStyle& style) {
  std::vector<std::string> names;
  AddSvgPropertiesNotObeyed(style, style.Attribute(node, "transform"), names);
  return std::ranges::any_of(names,
                             [](const auto& name) { return name != "stroke-dasharray"; });
}

}  // namespace

Box3 ExtentOf(const std::vector<Curve>& curves) {
  Drawing drawing;
  drawing.curves = curves;
  Box3 box;
  const auto flat = Flatten(drawing);
  if (!flat) return box;
  for (const FlatCurve& curve : flat->curves) {
    for (const Vec3& p : curve.points_mm) box.Extend(p);
  }
  return box;
}

bool SvgClips::Take(const pugi::xml_node& node, const BoxSource& box, SvgScope& scope,
                    bool& is_read) {
  const SvgTransform& t = scope.to_page;
  const std::array<double, 9> place = {
      t.a, t.b, t.c, t.d, t.e, t.f, scope.page.x(), scope.page.y(), scope.em};
  Known& known = known_[node.hash_value()];
  // Boxes differ from element to element; clips of clips may refer to them.
  const bool is_known = known.place == place && known.is_read && known.areas.size() == 1;
  const std::string_view units = node.attribute("clipPathUnits").value();
  if (!is_known || units == "objectBoundingBox") {
    Reading reading;
    if (!Read(node, box, scope, reading)) return false;
    known = {place, {}, reading.is_read};
    if (reading.is_read) {
      auto area = ClipArea::OfShapes(reading.shapes, work_);
      known.is_read = area.has_value();
      known.areas = std::move(reading.within);
      if (area) known.areas.push_back(std::make_shared<const ClipArea>(std::move(*area)));
    }
  }
  is_read = known.is_read;
  if (is_read)
    scope.clips.insert(scope.clips.end(), known.areas.begin(), known.areas.end());
  return true;
}

void SvgClips::TakeViewport(const Vec2& size, SvgScope& scope) {
  auto area = ClipArea::OfShapes({{{SvgBoxOf(scope.to_page, size)}, false}}, work_);
  if (area) {
    scope.clips.push_back(std::make_shared<const ClipArea>(std::move(*area)));
  } else {
    scope.not_obeyed.emplace_back("viewport");
  }
}

bool SvgClips::Cut(const SvgScope& scope, std::vector<Curve>& curves) {
  if (scope.clips.empty()) return true;
  std::vector<Curve> left = curves;
  for (const auto& clip : scope.clips) {
    std::vector<Curve> inside;
    for (const Curve& curve : left) {
      if (!clip->Cut(curve, scope.filled, work_, inside)) return false;
    }
    left = std::move(inside);
  }
  curves = std::move(left);
  return true;
}

/// The style of the groups around a clip path, and not of those around its user.
bool SvgClips::InheritStyle(const pugi::xml_node& node, SvgScope& scope) {
  std::vector<pugi::xml_node> groups;
  for (pugi::xml_node group = node.parent(); group.type() == pugi::node_element;
       group = group.parent())
    groups.push_back(group);
  for (auto group = groups.rbegin(); group != groups.rend(); ++group) {
    SvgStyle style;
    if (!scopes_.TakeStyle(*group, scope, style)) return false;
  }
  return true;
}

bool SvgClips::Read(const pugi::xml_node& node, const BoxSource& box,
                    const SvgScope& user, Reading& reading) {
  reading.is_read =
      SvgName(node.name()) == "clipPath" && reading.depth < kMaxClipsOfClips;
  if (!reading.is_read) return true;
  if (!builder_.CountEntity("clip-path")) return false;
  SvgScope scope;
  scope.to_page = user.to_page;
  scope.page = user.page;
  scope.references = user.references;
  SvgStyle style;
  if (!InheritStyle(node, scope) || !scopes_.TakeStyle(node, scope, style)) return false;
  if (IsMovedByOthers(node, style)) {
    reading.is_read = false;
    return true;
  }
  // The transform of a clip path does not move its own clip: as browsers do.
  if (!ReadOwnClip(style, box, user, reading, reading.within)) return false;
  scopes_.TakeTransform(node, style, scope);
  if (std::string_view(node.attribute("clipPathUnits").value()) == "objectBoundingBox") {
    Box3 of_user;
    if (!box(of_user)) return false;
    const Vec3 size = of_user.size_mm();
    if (!(size.x() > 0 && size.y() > 0)) {
      reading.is_read = false;
      return true;
    }
    scope.to_page = scope.to_page.Then(
        {size.x(), 0, 0, size.y(), of_user.min_mm.x(), of_user.min_mm.y()});
  }
  for (const pugi::xml_node child : node.children()) {
    if (!reading.is_read) break;
    if (child.type() == pugi::node_element && !ReadChild(child, scope, {}, reading))
      return false;
  }
  return true;
}

/// The clip path that an element of a clip path, or itself, is clipped with.
bool SvgClips::ReadOwnClip(const SvgStyle& style, const BoxSource& box,
                           const SvgScope& scope, Reading& reading, Areas& within) {
  const std::string& value = style.value(SvgProperty::kClipPath);
  if (value.empty() || value == "none" || value == "inherit") return true;
  const pugi::xml_node target = document_.Find(value);
  if (value.starts_with("url(#") && !target) return true;  // as no clip
  Reading own;
  own.depth = reading.depth + 1;
  if (!Read(target, box, scope, own)) return false;
  std::optional<ClipArea> area;
  if (own.is_read) area = ClipArea::OfShapes(own.shapes, work_);
  reading.is_read = reading.is_read && area.has_value();
  if (!area) return true;
  within.insert(within.end(), own.within.begin(), own.within.end());
  within.push_back(std::make_shared<const ClipArea>(std::move(*area)));
  return true;
}

bool SvgClips::ReadChild(const pugi::xml_node& node, SvgScope scope, Areas within,
                         Reading& reading) {
  const std::string_view element = SvgName(node.name());
  if (!IsSvgShape(element) && element != "use" && element != "text") return true;
  SvgStyle style;
  if (!HoldsSvgCondition(node)) return true;
  if (!scopes_.TakeStyle(node, scope, style)) return false;
  if (style.value(SvgProperty::kDisplay) == "none") return true;
  if (element == "text" || IsMovedByOthers(node, style)) {
    reading.is_read = false;
    return true;
  }
  scopes_.TakeTransform(node, style, scope);
  if (element == "use") scopes_.TakePlaceOfUse(node, style, scope);
  std::vector<Curve> curves;
  if (element != "use" && !scopes_.CurvesOf(node, style, scope, curves)) return false;
  const auto box = [&](Box3& extent) {
    extent = ExtentOf(curves);
    return true;
  };
  if (!ReadOwnClip(style, box, scope, reading, within)) return false;
  if (element == "use") return ReadUse(node, scope, within, reading);
  if (scope.hidden) return true;
  for (Curve& curve : curves) {
    for (Piece& piece : curve.pieces) ToPage(scope.to_page, piece);
  }
  AddShape({std::move(curves), scope.clips_even_odd}, within, reading);
  return true;
}

/// Of a shape or text; others are not drawn in a clip path.
bool SvgClips::ReadUse(const pugi::xml_node& node, SvgScope& scope, const Areas& within,
                       Reading& reading) {
  std::string_view target = node.attribute("href").value();
  if (target.empty()) target = node.attribute("xlink:href").value();
  const pugi::xml_node found = document_.Find(target);
  if (!found || SvgName(found.name()) == "use") return true;
  if (!builder_.CountEntity("use")) return false;
  ++scope.references;
  return ReadChild(found, scope, within, reading);
}

void SvgClips::AddShape(ClipShape shape, const Areas& within, Reading& reading) {
  if (within.empty()) return reading.shapes.push_back(std::move(shape));
  auto area = ClipArea::OfShapes({std::move(shape)}, work_);
  for (const auto& other : within) {
    if (area) area = ClipArea::OfBoth(*area, *other, work_);
  }
  reading.is_read = reading.is_read && area.has_value();
  if (area) reading.shapes.push_back(area->AsShape());
}

}  // namespace intaglio::drawing
