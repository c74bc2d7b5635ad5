#include "engrave/drawing/svg/svg_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <pugixml.hpp>

#include "engrave/drawing/pieces.h"
#include "engrave/drawing/svg/svg_changes.h"
#include "engrave/drawing/svg/svg_clip.h"
#include "engrave/drawing/svg/svg_document.h"
#include "engrave/drawing/svg/svg_elements.h"
#include "engrave/drawing/svg/svg_path.h"
#include "engrave/drawing/svg/svg_scope.h"
#include "engrave/drawing/svg/svg_shapes.h"
#include "engrave/drawing/svg/svg_style.h"

namespace intaglio::drawing {
namespace {

constexpr double kPx_mm = 25.4 / 96;

/// Walks through the elements and adds the curves of shapes.
class SvgReader {
 public:
  /// `measures`: shapes are taken for their boxes, seen or not, and not clipped.
  SvgReader(DrawingBuilder& builder, SvgDocument& document, const ReadOptions& options,
            bool measures)
      : options_(options),
        measures_(measures),
        builder_(builder),
        document_(document),
        scopes_(builder, document),
        clips_(builder, document, scopes_) {}

  bool ReadPage() {
    const pugi::xml_node root = document_.root();
    // A page without size is as large as its viewBox.
    Vec2 natural(kSvgWidth_px, kSvgHeight_px);
    if (const auto box = ParseSvgViewBox(root.attribute("viewBox").value())) {
      natural = box->size;
    }
    Vec2 size = natural;
    SvgScope page;
    SvgStyle style;
    if (!scopes_.TakeStyle(root, page, style)) return false;
    scopes_.TakeLength(root, style, "width", natural.x(), page.em, size.x());
    scopes_.TakeLength(root, style, "height", natural.y(), page.em, size.y());
    if (!style.Attribute(root, "transform").empty()) {
      builder_.LeaveOutAt("transform of the page", Effect::kChanged,
                          [&] { return PlaceOf(root); });
    }
    // A unit that is given is that of the viewBox, in place of the page's size.
    builder_.NoteUnitAskedFor("page", options_.unit_mm);
    if (options_.unit_mm && root.attribute("viewBox")) size = natural;
    if (!(size.minCoeff() > 0)) {
      return builder_.Refuse(ErrorCode::kInvalidValue, PlaceOf(root),
                             "width and height of the page must be positive");
    }
    const double mm = options_.unit_mm.value_or(kPx_mm);
    page.to_page = {mm, 0, 0, -mm, 0, mm * size.y()};
    page.page = size;
    const auto no_box = [](Box3&) { return true; };
    if (!TakeChanges(root, style, no_box, page)) return false;
    const bool has_size = size != Vec2(kSvgWidth_px, kSvgHeight_px);
    const std::string& overflow = style.value(SvgProperty::kOverflow);
    if (has_size && overflow != "visible") page_mm_ = mm * size;
    scopes_.TakeViewBox(root, size, page);
    builder_.SetUnit(std::abs(page.to_page.d));
    if (style.displayed && HoldsSvgCondition(root)) return ReadChildren(root, page);
    builder_.LeaveOut("invisible", Effect::kNothingSeen);
    return true;
  }

 private:
  std::string PlaceOf(const pugi::xml_node& node) const {
    return document_.PlaceOf(node);
  }

  bool ReadChildren(const pugi::xml_node& node, const SvgScope& scope) {
    for (const pugi::xml_node child : node.children()) {
      if (child.type() == pugi::node_element && !ReadElement(child, child, scope))
        return false;
    }
    return true;
  }

  /// The first child whose conditions hold, alone (SVG 1.1, 5.8.1).
  bool ReadSwitch(const pugi::xml_node& node, const SvgScope& scope) {
    for (const pugi::xml_node child : node.children()) {
      if (child.type() == pugi::node_element && HoldsSvgCondition(child))
        return ReadElement(child, child, scope);
    }
    return true;
  }

  /// Clip paths are cut; those that cannot be read, masks and filters are reported with
  /// each shape that they change.
  bool TakeChanges(const pugi::xml_node& node, const SvgStyle& style,
                   const SvgClips::BoxSource& box, SvgScope& scope) {
    if (measures_) return true;
    constexpr std::pair<SvgProperty, std::string_view> kChanging[] = {
        {SvgProperty::kClipPath, "clip-path"},
        {SvgProperty::kMask, "mask"},
        {SvgProperty::kFilter, "filter"}};
    for (const auto& [property, name] : kChanging) {
      const std::string& value = style.value(property);
      if (value.empty() || value == "none" || value == "inherit") continue;
      if (property == SvgProperty::kClipPath) {
        const pugi::xml_node target = document_.Find(value);
        if (value.starts_with("url(#") && !target) continue;  // as no clip
        bool is_read = false;
        if (!clips_.Take(target, box, scope, is_read)) return false;
        if (is_read) continue;
      }
      scope.not_obeyed.emplace_back(name);
    }
    AddSvgPropertiesNotObeyed(style, style.Attribute(node, "transform"),
                              scope.not_obeyed);
    return true;
  }

  /// The box of an element's shapes in its user space.
  bool MeasureElement(const pugi::xml_node& node, const pugi::xml_node& sized,
                      const SvgStyle& style, SvgScope scope, Box3& box) {
    DrawingBuilder probe("", options_.limits);
    SvgReader reader(probe, document_, options_, true);
    scope.to_page = {};
    ++scope.references;  // its elements are read again, and counted so
    const bool is_read = reader.ReadContent(node, sized, style, scope);
    if (!builder_.CountUnfolded(probe.unfolded_bytes(), "clip-path")) return false;
    const auto drawing = probe.Take();
    if (!drawing) {
      const Error& error = drawing.error();
      return builder_.Refuse(error.code, PlaceOf(node), error.message, error.value);
    }
    box = ExtentOf(drawing->curves);
    return is_read;
  }

  /// `sized` gives a viewport its size: the element, or the use that refers to it.
  bool ReadElement(const pugi::xml_node& node, const pugi::xml_node& sized,
                   SvgScope scope) {
    SvgStyle style;
    if (!scopes_.TakeStyle(node, scope, style)) return false;
    if (!style.displayed || !HoldsSvgCondition(node)) {
      builder_.LeaveOut("invisible", Effect::kNothingSeen);
      return true;
    }
    if (++scope.depth > options_.limits.max_nesting) return document_.RefuseDepth(node);
    scopes_.TakeTransform(node, style, scope);
    if (SvgName(node.name()) == "use") scopes_.TakePlaceOfUse(node, style, scope);
    const auto box = [&](Box3& extent) {
      return MeasureElement(node, sized, style, scope, extent);
    };
    return TakeChanges(node, style, box, scope) && ReadContent(node, sized, style, scope);
  }

  bool ReadContent(const pugi::xml_node& node, const pugi::xml_node& sized,
                   const SvgStyle& style, SvgScope& scope) {
    const std::string_view element = SvgName(node.name());
    if (IsSvgShape(element)) return ReadShape(node, style, scope);
    if (element == "g" || element == "a" || element == "switch") {
      return ReadGroup(node, scope);
    }
    if (element == "svg") return ReadViewport(node, sized, style, scope);
    if (element == "use") return ReadUse(node, scope);
    const std::string_view whole = node.name();
    const bool foreign = whole.size() > element.size() && !whole.starts_with("svg:");
    if (IsSvgDefinition(element)) return true;
    builder_.LeaveOutAt(whole,
                        foreign ? Effect::kNothingSeen : EffectOfSvgElement(element),
                        [&] { return PlaceOf(node); });
    return true;
  }

  bool ReadGroup(const pugi::xml_node& node, SvgScope& scope) {
    std::string_view layer = node.attribute("inkscape:label").value();
    if (layer.empty()) layer = node.attribute("id").value();
    if (!layer.empty()) scope.layer = builder_.NameIndex(layer);
    return SvgName(node.name()) == "switch" ? ReadSwitch(node, scope)
                                            : ReadChildren(node, scope);
  }

  /// An svg or symbol in its place; its size from `sized`, itself or the use.
  bool ReadViewport(const pugi::xml_node& node, const pugi::xml_node& sized,
                    const SvgStyle& style, SvgScope& scope) {
    Vec2 at = Vec2::Zero(), size = scope.page;
    for (const pugi::xml_node& from : {node, sized}) {
      const SvgStyle& own = from == node ? style : SvgStyle();
      scopes_.TakeLength(from, own, "width", scope.page.x(), scope.em, size.x());
      scopes_.TakeLength(from, own, "height", scope.page.y(), scope.em, size.y());
    }
    if (SvgName(node.name()) == "svg") {
      scopes_.TakeLength(node, style, "x", scope.page.x(), scope.em, at.x());
      scopes_.TakeLength(node, style, "y", scope.page.y(), scope.em, at.y());
    }
    if (!(size.minCoeff() > 0)) return true;  // not drawn, as the standard defines
    scope.to_page = scope.to_page.Then({1, 0, 0, 1, at.x(), at.y()});
    const std::string& overflow = style.value(SvgProperty::kOverflow);
    if (overflow != "visible" && overflow != "auto") {
      clips_.TakeViewport(size, scope);
    }
    scopes_.TakeViewBox(node, size, scope);
    return ReadChildren(node, scope);
  }

  bool ReadUse(const pugi::xml_node& node, SvgScope& scope) {
    std::string_view target = node.attribute("href").value();
    if (target.empty()) target = node.attribute("xlink:href").value();
    const pugi::xml_node found = document_.Find(target);
    if (!found) {
      builder_.LeaveOutAt("use of an element that is not in the file", Effect::kLost,
                          [&] { return PlaceOf(node); });
      return true;
    }
    if (!builder_.CountEntity("use")) return false;
    if (++scope.references > options_.limits.max_nesting)
      return document_.RefuseDepth(node);
    if (SvgName(found.name()) != "symbol") return ReadElement(found, node, scope);
    SvgStyle own;  // display of the symbol itself, which is never drawn, has no effect
    return scopes_.TakeStyle(found, scope, own) && ReadViewport(found, node, own, scope);
  }

  bool IsSeen(const SvgScope& scope) {
    std::string_view reason;
    if (!scope.filled && !scope.stroked)
      reason = "shape that is neither filled nor stroked";
    if (scope.hidden || scope.to_page.HasNoArea()) reason = "invisible";
    if (!reason.empty()) builder_.LeaveOut(reason, Effect::kNothingSeen);
    return reason.empty();
  }

  bool ReadShape(const pugi::xml_node& node, const SvgStyle& style,
                 const SvgScope& scope) {
    // Lines are counted for errors alone: it takes the whole file.
    if (!builder_.CountEntity("") ||
        (scope.references > 0 && !scopes_.CountAgain(node, {"d", "points"}))) {
      return false;
    }
    if (!measures_ && !IsSeen(scope)) return true;
    std::vector<Curve> curves;
    if (!scopes_.CurvesOf(node, style, scope, curves)) return false;
    for (Curve& curve : curves) {
      for (Piece& piece : curve.pieces) ToPage(scope.to_page, piece);
      curve.layer = scope.layer;
      curve.color = scope.color;
    }
    std::vector<std::string> not_obeyed = scope.not_obeyed;
    if (!measures_ && !clips_.Cut(scope, curves)) not_obeyed.emplace_back("clip-path");
    for (const FileFinding& met :
         SvgChangesOf(style, not_obeyed, document_, curves, page_mm_)) {
      builder_.LeaveOutAt(
          met.what, met.effect, [&] { return PlaceOf(node); }, met.area_mm2, met.remedy);
    }
    for (Curve& curve : curves) {
      if (!builder_.Add(std::move(curve), SvgName(node.name()))) return false;
    }
    return true;
  }

  ReadOptions options_;
  bool measures_;
  DrawingBuilder& builder_;
  SvgDocument& document_;
  SvgScopes scopes_;
  SvgClips clips_;
  std::optional<Vec2> page_mm_;  ///< where viewers end the drawing, from 0 0
};

}  // namespace

Result<Drawing> ReadSvg(std::string_view text, const ReadOptions& options,
                        std::string_view name) {
  RequireUsable(options);
  DrawingBuilder builder(name, options.limits);
  SvgDocument document(text, builder);
  if (document.Load()) SvgReader(builder, document, options, false).ReadPage();
  return builder.Take();
}

}  // namespace intaglio::drawing
