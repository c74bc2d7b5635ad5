#include "engrave/drawing/svg/svg_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <pugixml.hpp>

#include "engrave/drawing/pieces.h"
#include "engrave/drawing/svg/svg_changes.h"
#include "engrave/drawing/svg/svg_clip.h"
#include "engrave/drawing/svg/svg_document.h"
#include "engrave/drawing/svg/svg_elements.h"
#include "engrave/drawing/svg/svg_path.h"
#include "engrave/drawing/svg/svg_shapes.h"
#include "engrave/drawing/svg/svg_style.h"
#include "engrave/io/lower_case.h"

namespace intaglio::drawing {
namespace {

constexpr double kPx_mm = 25.4 / 96;
// When neither width nor height is given: the default sizes of browsers.
constexpr double kDefaultWidth = 300, kDefaultHeight = 150;
constexpr double kDefaultEm = 16;

/// What a group passes on to its children.
struct Context {
  SvgTransform to_page;  ///< user space to the page's px, y down
  Vec2 page = Vec2(kDefaultWidth, kDefaultHeight);
  double em = kDefaultEm;
  std::uint32_t layer = 0;
  std::uint32_t color = 0;
  bool hidden = false;
  bool filled = true;
  bool stroked = false;
  int depth = 0;
  int references = 0;
  std::vector<std::shared_ptr<const ConvexClip>> clips;
  std::vector<std::string> not_obeyed;  ///< what changes the shapes below: "mask"
};

class SvgReader {
 public:
  SvgReader(std::string_view text, const ReadOptions& options, std::string_view name)
      : options_(options), builder_(name, options.limits), document_(text, builder_) {}

  Result<Drawing> Read() {
    if (document_.Load()) ReadPage(document_.root());
    return builder_.Take();
  }

 private:
  std::string PlaceOf(const pugi::xml_node& node) const {
    return document_.PlaceOf(node);
  }

  /// A length that cannot be read is as one that is not given, which is what browsers do.
  void Length(const pugi::xml_node& node, const SvgStyle& style, const char* attribute,
              double whole, double em, double& length) {
    const std::string_view text = style.Attribute(node, attribute);
    if (text.empty() || text == "auto") return;
    const std::optional<double> value = ParseSvgLength(text, whole, em);
    if (value) {
      length = *value;
    } else {
      LeaveOutAttribute(node, attribute);
    }
  }
  void LeaveOutAttribute(const pugi::xml_node& node, std::string_view attribute) {
    builder_.LeaveOutAt(
        fmt::format("{} with a wrong {}", SvgName(node.name()), attribute),
        Effect::kChanged, [&] { return PlaceOf(node); });
  }

  /// The viewBox of an element of this size: its transform, and its own page.
  void ApplyViewBox(const pugi::xml_node& node, const Vec2& size, Context& context) {
    context.page = size;
    const char* text = node.attribute("viewBox").value();
    if (*text == '\0') return;
    const auto box = ParseSvgViewBox(text);
    if (!box) return LeaveOutAttribute(node, "viewBox");
    context.to_page = context.to_page.Then(
        FitSvgViewBox(*box, size, node.attribute("preserveAspectRatio").value()));
    context.page = box->size;
  }

  bool ReadPage(const pugi::xml_node& root) {
    // A page without size is as large as its viewBox.
    Vec2 natural(kDefaultWidth, kDefaultHeight);
    if (const auto box = ParseSvgViewBox(root.attribute("viewBox").value())) {
      natural = box->size;
    }
    Vec2 size = natural;
    Context page;
    SvgStyle style;
    if (!TakeStyle(root, page, style)) return false;
    Length(root, style, "width", natural.x(), page.em, size.x());
    Length(root, style, "height", natural.y(), page.em, size.y());
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
    if (!TakeChanges(root, style, page)) return false;
    const bool has_size = size != Vec2(kDefaultWidth, kDefaultHeight);
    const std::string& overflow = style.value(SvgProperty::kOverflow);
    if (has_size && overflow != "visible") page_mm_ = mm * size;
    ApplyViewBox(root, size, page);
    builder_.SetUnit(std::abs(page.to_page.d));
    if (style.displayed && HoldsSvgCondition(root)) return ReadChildren(root, page);
    builder_.LeaveOut("invisible", Effect::kNothingSeen);
    return true;
  }

  bool ReadChildren(const pugi::xml_node& node, const Context& context) {
    for (const pugi::xml_node child : node.children()) {
      if (child.type() == pugi::node_element && !ReadElement(child, child, context))
        return false;
    }
    return true;
  }

  /// The first child whose conditions hold, alone (SVG 1.1, 5.8.1).
  bool ReadSwitch(const pugi::xml_node& node, const Context& context) {
    for (const pugi::xml_node child : node.children()) {
      if (child.type() == pugi::node_element && HoldsSvgCondition(child))
        return ReadElement(child, child, context);
    }
    return true;
  }

  /// Applies the element's style to the context.
  bool TakeStyle(const pugi::xml_node& node, Context& context, SvgStyle& style) {
    if (context.references > 0 && !CountAgain(node, {"style", "class", "transform"})) {
      return false;
    }
    if (!document_.sheets().StyleOf(node, style)) return false;
    context.hidden = style.hidden.value_or(context.hidden);
    if (!style.stroke.empty()) {
      context.color = builder_.NameIndex(style.stroke);
      context.stroked = IsSvgPaint(style.stroke);
    }
    if (!style.fill.empty()) context.filled = IsSvgPaint(style.fill);
    const std::string& letters = style.value(SvgProperty::kFontSize);
    context.em = ParseSvgLength(letters, context.em, context.em).value_or(context.em);
    return true;
  }

  void TakeTransform(const pugi::xml_node& node, const SvgStyle& style,
                     Context& context) {
    const std::string_view text = style.Attribute(node, "transform");
    if (text.empty()) return;
    const std::optional<SvgTransform> parsed = ParseSvgTransform(text);
    if (!parsed) return LeaveOutAttribute(node, "transform");
    Vec2 origin = Vec2::Zero();
    if (const std::string_view at = style.Attribute(node, "transform-origin");
        !at.empty()) {
      const auto point = ParseSvgOrigin(at, context.page, context.em);
      if (!point) LeaveOutAttribute(node, "transform-origin");
      origin = point.value_or(origin);
    }
    context.to_page = context.to_page.Then({1, 0, 0, 1, origin.x(), origin.y()})
                          .Then(*parsed)
                          .Then({1, 0, 0, 1, -origin.x(), -origin.y()});
  }

  /// Clips of a convex area are cut; others, masks and filters are reported with each
  /// shape that they change.
  bool TakeChanges(const pugi::xml_node& node, const SvgStyle& style, Context& context) {
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
        bool is_cut = false;
        if (!TakeClip(target, context, is_cut)) return false;
        if (is_cut) continue;
      }
      context.not_obeyed.emplace_back(name);
    }
    AddSvgPropertiesNotObeyed(style, style.Attribute(node, "transform"),
                              context.not_obeyed);
    return true;
  }

  /// A clipPath of one shape whose area is convex.
  bool TakeClip(const pugi::xml_node& node, Context& context, bool& is_cut) {
    const std::string_view units = node.attribute("clipPathUnits").value();
    const pugi::xml_node child = node.first_child();
    if (!child || child.next_sibling() || !IsSvgShape(SvgName(child.name())) ||
        units == "objectBoundingBox" || SvgName(node.name()) != "clipPath") {
      return true;
    }
    if (!builder_.CountEntity("clip-path")) return false;
    SvgStyle own, of_shape;
    Context clip = context;
    if (!TakeStyle(node, clip, own)) return false;
    TakeTransform(node, own, clip);
    if (!TakeStyle(child, clip, of_shape)) return false;
    TakeTransform(child, of_shape, clip);
    // A clip that is clipped itself.
    if (!own.value(SvgProperty::kClipPath).empty() ||
        !of_shape.value(SvgProperty::kClipPath).empty()) {
      return true;
    }
    std::vector<Curve> curves;
    if (!CurvesOf(child, of_shape, clip, curves)) return false;
    if (curves.size() != 1) return true;
    for (Piece& piece : curves.front().pieces) ToPage(clip.to_page, piece);
    auto area = ConvexClipOf(curves.front());
    is_cut = area.has_value();
    if (is_cut) {
      context.clips.push_back(std::make_shared<const ConvexClip>(std::move(*area)));
    }
    return true;
  }

  /// `sized` gives a viewport its size: the element, or the use that refers to it.
  bool ReadElement(const pugi::xml_node& node, const pugi::xml_node& sized,
                   Context context) {
    const std::string_view element = SvgName(node.name());
    SvgStyle style;
    if (!TakeStyle(node, context, style)) return false;
    if (!style.displayed || !HoldsSvgCondition(node)) {
      builder_.LeaveOut("invisible", Effect::kNothingSeen);
      return true;
    }
    if (++context.depth > options_.limits.max_nesting) return document_.RefuseDepth(node);
    TakeTransform(node, style, context);
    if (!TakeChanges(node, style, context)) return false;
    if (IsSvgShape(element)) return ReadShape(node, style, context);
    if (element == "g" || element == "a" || element == "switch") {
      return ReadGroup(node, context);
    }
    if (element == "svg") return ReadViewport(node, sized, style, context);
    if (element == "use") return ReadUse(node, style, context);
    const std::string_view whole = node.name();
    const bool foreign = whole.size() > element.size() && !whole.starts_with("svg:");
    if (IsSvgDefinition(element)) return true;
    builder_.LeaveOutAt(whole,
                        foreign ? Effect::kNothingSeen : EffectOfSvgElement(element),
                        [&] { return PlaceOf(node); });
    return true;
  }

  bool ReadGroup(const pugi::xml_node& node, Context& context) {
    std::string_view layer = node.attribute("inkscape:label").value();
    if (layer.empty()) layer = node.attribute("id").value();
    if (!layer.empty()) context.layer = builder_.NameIndex(layer);
    return SvgName(node.name()) == "switch" ? ReadSwitch(node, context)
                                            : ReadChildren(node, context);
  }

  /// An svg or symbol in its place; its size from `sized`, itself or the use.
  bool ReadViewport(const pugi::xml_node& node, const pugi::xml_node& sized,
                    const SvgStyle& style, Context& context) {
    Vec2 at = Vec2::Zero(), size = context.page;
    for (const pugi::xml_node& from : {node, sized}) {
      const SvgStyle& own = from == node ? style : SvgStyle();
      Length(from, own, "width", context.page.x(), context.em, size.x());
      Length(from, own, "height", context.page.y(), context.em, size.y());
    }
    if (SvgName(node.name()) == "svg") {
      Length(node, style, "x", context.page.x(), context.em, at.x());
      Length(node, style, "y", context.page.y(), context.em, at.y());
    }
    if (!(size.minCoeff() > 0)) return true;  // not drawn, as the standard defines
    context.to_page = context.to_page.Then({1, 0, 0, 1, at.x(), at.y()});
    const std::string& overflow = style.value(SvgProperty::kOverflow);
    if (overflow != "visible" && overflow != "auto") {
      if (auto area = ConvexClipOf(SvgBoxOf(context.to_page, size))) {
        context.clips.push_back(std::make_shared<const ConvexClip>(std::move(*area)));
      }
    }
    ApplyViewBox(node, size, context);
    return ReadChildren(node, context);
  }

  bool ReadUse(const pugi::xml_node& node, const SvgStyle& style, Context& context) {
    std::string_view target = node.attribute("href").value();
    if (target.empty()) target = node.attribute("xlink:href").value();
    const pugi::xml_node found = document_.Find(target);
    if (!found) {
      builder_.LeaveOutAt("use of an element that is not in the file", Effect::kLost,
                          [&] { return PlaceOf(node); });
      return true;
    }
    if (!builder_.CountEntity("use")) return false;
    if (++context.references > options_.limits.max_nesting)
      return document_.RefuseDepth(node);
    Vec2 at = Vec2::Zero();
    Length(node, style, "x", context.page.x(), context.em, at.x());
    Length(node, style, "y", context.page.y(), context.em, at.y());
    context.to_page = context.to_page.Then({1, 0, 0, 1, at.x(), at.y()});
    if (SvgName(found.name()) != "symbol") return ReadElement(found, node, context);
    SvgStyle own;  // display of the symbol itself, which is never drawn, has no effect
    return TakeStyle(found, context, own) && ReadViewport(found, node, own, context);
  }

  bool ReadShape(const pugi::xml_node& node, const SvgStyle& style,
                 const Context& context) {
    // Lines are counted for errors alone: it takes the whole file.
    if (!builder_.CountEntity("") ||
        (context.references > 0 && !CountAgain(node, {"d", "points"}))) {
      return false;
    }
    if (context.hidden) {
      builder_.LeaveOut("invisible", Effect::kNothingSeen);
      return true;
    }
    if (!context.filled && !context.stroked) {
      builder_.LeaveOut("shape that is neither filled nor stroked", Effect::kNothingSeen);
      return true;
    }
    std::vector<Curve> curves;
    if (!CurvesOf(node, style, context, curves)) return false;
    for (Curve& curve : curves) {
      for (Piece& piece : curve.pieces) ToPage(context.to_page, piece);
      curve.layer = context.layer;
      curve.color = context.color;
    }
    if (!Clip(context, curves)) return false;
    for (const FileFinding& met :
         SvgChangesOf(style, context.not_obeyed, document_, curves, page_mm_)) {
      builder_.LeaveOutAt(
          met.what, met.effect, [&] { return PlaceOf(node); }, met.area_mm2, met.remedy);
    }
    for (Curve& curve : curves) {
      if (!builder_.Add(std::move(curve), SvgName(node.name()))) return false;
    }
    return true;
  }

  bool Clip(const Context& context, std::vector<Curve>& curves) {
    for (const auto& clip : context.clips) {
      std::vector<Curve> inside;
      for (const Curve& curve : curves) {
        if (!ClipCurve(curve, context.filled, *clip, builder_, inside)) return false;
      }
      curves = std::move(inside);
    }
    return true;
  }

  /// A wrong attribute ends a shape, and not the file.
  bool CurvesOf(const pugi::xml_node& node, const SvgStyle& style, const Context& context,
                std::vector<Curve>& curves) {
    DrawingBuilder probe("", options_.limits);
    const SvgScale scale{context.page, context.em};
    if (SvgShapeCurves(node, style, scale, "", probe, curves)) return true;
    const Error error = probe.Take().error();
    if (error.code != ErrorCode::kInvalidValue)
      return builder_.Refuse(error.code, PlaceOf(node), error.message, error.value);
    builder_.LeaveOutAt(
        fmt::format("{}, {}", SvgName(node.name()), error.message.substr(2)),
        Effect::kChanged, [&] { return PlaceOf(node); });
    return true;
  }
  bool CountAgain(const pugi::xml_node& node,
                  std::initializer_list<const char*> attributes) {
    std::size_t bytes = 50;
    for (const char* attribute : attributes) {
      bytes += std::string_view(node.attribute(attribute).value()).size();
    }
    return builder_.CountUnfolded(bytes, "use");
  }

  ReadOptions options_;
  DrawingBuilder builder_;
  SvgDocument document_;
  std::optional<Vec2> page_mm_;  ///< where viewers end the drawing, from 0 0
};

}  // namespace

Result<Drawing> ReadSvg(std::string_view text, const ReadOptions& options,
                        std::string_view name) {
  RequireUsable(options);
  return SvgReader(text, options, name).Read();
}

}  // namespace intaglio::drawing
