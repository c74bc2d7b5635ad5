#include "engrave/drawing/svg/svg_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <pugixml.hpp>
#include <unordered_map>

#include "engrave/drawing/pieces.h"
#include "engrave/drawing/svg/svg_path.h"
#include "engrave/drawing/svg/svg_shapes.h"
#include "engrave/drawing/svg/svg_style.h"

namespace intaglio::drawing {
namespace {

constexpr double kPx_mm = 25.4 / 96;
// When neither width nor height is given: the default sizes of browsers.
constexpr double kDefaultWidth = 300, kDefaultHeight = 150;

/// What a group passes on to its children.
struct Context {
  SvgTransform to_page;  ///< user space to the page's px, y down
  Vec2 page = Vec2(kDefaultWidth, kDefaultHeight);
  std::uint32_t layer = 0;
  std::uint32_t color = 0;
  bool hidden = false;
  int depth = 0;
  int references = 0;
};

class SvgReader {
 public:
  SvgReader(std::string_view text, const ReadOptions& options, std::string_view name)
      : text_(text),
        options_(options),
        builder_(name, options.limits),
        sheets_(builder_) {}

  Result<Drawing> Read() {
    if (CheckSize() && Parse()) {
      const pugi::xml_node root = document_.document_element();
      if (SvgName(root.name()) != "svg") {
        builder_.Refuse(ErrorCode::kUnreadable, "",
                        "the file has no svg element; it is not SVG", root.name());
      } else if (NoteIdsAndSheets(root)) {
        ReadPage(root);
      }
    }
    return builder_.Take();
  }

 private:
  /// Checked before parsing: the tree takes 64 bytes for an "<a>" in the file.
  bool CheckSize() {
    if (text_.size() > options_.limits.max_file_bytes) {
      return builder_.Refuse(ErrorCode::kTooLarge, "",
                             fmt::format("the file has {} bytes, the limit is {}; divide "
                                         "the drawing or raise the limit",
                                         text_.size(), options_.limits.max_file_bytes));
    }
    std::uint64_t elements = 0, attributes = 0;
    for (std::size_t i = 0; i < text_.size(); ++i) {
      if (text_[i] == '=') ++attributes;
      if (text_[i] == '<' && i + 1 < text_.size() && text_[i + 1] != '/') ++elements;
    }
    const std::uint64_t largest = options_.limits.max_entities;
    if (elements <= largest && attributes <= 8 * largest) return true;
    return builder_.Refuse(
        ErrorCode::kTooLarge, "",
        fmt::format("the file has more than {} elements or {} "
                    "attributes; divide the drawing or raise the limit",
                    largest, 8 * largest));
  }

  std::string LineAt(std::ptrdiff_t offset) const {
    const auto stop = std::clamp<std::ptrdiff_t>(offset, 0, std::ssize(text_));
    return fmt::format("line {}",
                       std::count(text_.begin(), text_.begin() + stop, '\n') + 1);
  }
  std::string PlaceOf(const pugi::xml_node& node) const {
    const char* id = node.attribute("id").value();
    std::string place =
        fmt::format("{}, {}", LineAt(node.offset_debug()), Shown(SvgName(node.name())));
    if (*id != '\0') place += fmt::format(" \"{}\"", Shown(id));
    return place;
  }

  bool Parse() {
    const pugi::xml_parse_result parsed = document_.load_buffer(
        text_.data(), text_.size(),
        pugi::parse_minimal | pugi::parse_escapes | pugi::parse_cdata,
        pugi::encoding_auto);
    if (parsed) return true;
    return builder_.Refuse(
        parsed.status == pugi::status_out_of_memory ? ErrorCode::kTooLarge
                                                    : ErrorCode::kUnreadable,
        LineAt(parsed.offset),
        fmt::format("not well-formed XML ({}); export the drawing again",
                    parsed.description()));
  }

  /// The elements by their ids and the style sheets, which apply wherever in the file
  /// they are. Without recursion, because files may be nested to any depth.
  bool NoteIdsAndSheets(const pugi::xml_node& root) {
    pugi::xml_node node = root;
    int depth = 0;
    while (true) {
      if (const char* id = node.attribute("id").value(); *id != '\0') {
        by_id_.try_emplace(id, node);
      }
      if (SvgName(node.name()) == "style" && !TakeSheet(node)) return false;
      if (node.first_child()) {
        node = node.first_child();
        if (++depth > options_.limits.max_nesting) return RefuseDepth(node);
        continue;
      }
      while (node != root && !node.next_sibling()) {
        node = node.parent();
        --depth;
      }
      if (node == root) return true;
      node = node.next_sibling();
    }
  }
  bool TakeSheet(const pugi::xml_node& node) {
    const std::string_view type = node.attribute("type").value();
    const std::string_view media = node.attribute("media").value();
    if ((!type.empty() && type != "text/css") ||
        (!media.empty() && media.find("all") == media.npos &&
         media.find("screen") == media.npos)) {
      builder_.LeaveOut("style sheet of another kind");
      return true;
    }
    std::string css;
    for (const pugi::xml_node part : node.children()) css += part.value();
    return sheets_.AddSheet(css);
  }
  bool RefuseDepth(const pugi::xml_node& node) {
    return builder_.Refuse(
        ErrorCode::kTooLarge, PlaceOf(node),
        fmt::format("elements or references are nested more than {} deep; ungroup them",
                    options_.limits.max_nesting));
  }

  bool Length(const pugi::xml_node& node, const char* attribute, double whole,
              double& length) {
    const char* text = node.attribute(attribute).value();
    if (*text == '\0' || std::string_view(text) == "auto") return true;
    const std::optional<double> value = ParseSvgLength(text, whole);
    if (!value) {
      return builder_.Refuse(
          ErrorCode::kInvalidValue, PlaceOf(node),
          fmt::format("attribute {}: not a length in px, mm, cm, in, pt, pc or %",
                      attribute),
          text);
    }
    length = *value;
    return true;
  }

  /// The viewBox of an element of this size: its transform, and its own page.
  bool ApplyViewBox(const pugi::xml_node& node, const Vec2& size, Context& context) {
    context.page = size;
    const char* text = node.attribute("viewBox").value();
    if (*text == '\0') return true;
    SvgNumbers numbers(text);
    std::array<double, 4> box{};
    for (double& value : box) {
      const std::optional<double> number = numbers.Next();
      if (!number) {
        return builder_.Refuse(ErrorCode::kInvalidValue, PlaceOf(node),
                               "attribute viewBox: needs four finite numbers", text);
      }
      value = *number;
      numbers.SkipComma();
    }
    if (!(box[2] > 0 && box[3] > 0)) {
      return builder_.Refuse(ErrorCode::kInvalidValue, PlaceOf(node),
                             "attribute viewBox: width and height must be positive",
                             text);
    }
    Vec2 scale(size.x() / box[2], size.y() / box[3]);
    const std::string_view fit = node.attribute("preserveAspectRatio").value();
    Vec2 align(0.5, 0.5);
    if (!fit.starts_with("none")) {
      const bool slice = fit.find("slice") != fit.npos;
      scale.setConstant(slice ? scale.maxCoeff() : scale.minCoeff());
      if (fit.find("xMin") != fit.npos) align.x() = 0;
      if (fit.find("xMax") != fit.npos) align.x() = 1;
      if (fit.find("YMin") != fit.npos) align.y() = 0;
      if (fit.find("YMax") != fit.npos) align.y() = 1;
    }
    const Vec2 inside(box[2], box[3]);
    const Vec2 room = align.cwiseProduct(size - scale.cwiseProduct(inside));
    context.to_page =
        context.to_page.Then({scale.x(), 0, 0, scale.y(), room.x() - scale.x() * box[0],
                              room.y() - scale.y() * box[1]});
    context.page = inside;
    return true;
  }

  bool ReadPage(const pugi::xml_node& root) {
    // A page without size is as large as its viewBox.
    Vec2 natural(kDefaultWidth, kDefaultHeight);
    SvgNumbers box(root.attribute("viewBox").value());
    std::array<double, 4> values{};
    bool has_box = true;
    for (double& value : values) {
      const std::optional<double> number = box.Next();
      has_box = has_box && number.has_value();
      value = number.value_or(0);
      box.SkipComma();
    }
    if (has_box) natural = {values[2], values[3]};
    Vec2 size = natural;
    if (!Length(root, "width", natural.x(), size.x()) ||
        !Length(root, "height", natural.y(), size.y())) {
      return false;
    }
    if (!(size.minCoeff() > 0)) {
      return builder_.Refuse(ErrorCode::kInvalidValue, PlaceOf(root),
                             "width and height of the page must be positive");
    }
    Context page;
    if (!ApplyViewBox(root, size, page)) return false;
    const double mm = options_.unit_mm.value_or(kPx_mm);
    page.to_page = SvgTransform{mm, 0, 0, -mm, 0, mm * size.y()}.Then(page.to_page);
    bool displayed = true;
    if (!TakeStyle(root, page, displayed)) return false;
    if (displayed) return ReadChildren(root, page);
    builder_.LeaveOut("invisible");
    return true;
  }

  bool ReadChildren(const pugi::xml_node& node, const Context& context) {
    for (const pugi::xml_node child : node.children()) {
      if (child.type() == pugi::node_element && !ReadElement(child, context))
        return false;
    }
    return true;
  }

  /// Applies the element's style to the context; `displayed` follows from the property
  /// display.
  bool TakeStyle(const pugi::xml_node& node, Context& context, bool& displayed) {
    if (context.references > 0 && !CountAgain(node, {"style", "class", "transform"})) {
      return false;
    }
    SvgStyle style;
    if (!sheets_.StyleOf(node, style)) return false;
    displayed = style.displayed;
    context.hidden = style.hidden.value_or(context.hidden);
    if (!style.stroke.empty()) context.color = builder_.NameIndex(style.stroke);
    return true;
  }

  bool ReadElement(const pugi::xml_node& node, Context context) {
    const std::string_view element = SvgName(node.name());
    bool displayed = true;
    if (!TakeStyle(node, context, displayed)) return false;
    if (!displayed) {
      builder_.LeaveOut("invisible");
      return true;
    }
    if (++context.depth > options_.limits.max_nesting) return RefuseDepth(node);
    const std::string_view transform = node.attribute("transform").value();
    if (!transform.empty()) {
      const std::optional<SvgTransform> parsed = ParseSvgTransform(transform);
      if (!parsed) {
        return builder_.Refuse(
            ErrorCode::kInvalidValue, PlaceOf(node),
            "attribute transform cannot be read; export the drawing again", transform);
      }
      context.to_page = context.to_page.Then(*parsed);
    }
    if (IsSvgShape(element)) return ReadShape(node, context);
    if (element == "g" || element == "a" || element == "switch") {
      return ReadGroup(node, context);
    }
    if (element == "svg") return ReadViewport(node, node, context);
    if (element == "use") return ReadUse(node, context);
    constexpr std::string_view kSilent[] = {"defs",  "symbol",   "title",     "desc",
                                            "style", "metadata", "namedview", "script"};
    if (std::ranges::find(kSilent, element) == std::end(kSilent))
      builder_.LeaveOut(element);
    return true;
  }

  bool ReadGroup(const pugi::xml_node& node, Context& context) {
    std::string_view layer = node.attribute("inkscape:label").value();
    if (layer.empty()) layer = node.attribute("id").value();
    if (!layer.empty()) context.layer = builder_.NameIndex(layer);
    return ReadChildren(node, context);
  }

  /// An svg or symbol in its place; its size from `sized`, itself or the use.
  bool ReadViewport(const pugi::xml_node& node, const pugi::xml_node& sized,
                    Context& context) {
    Vec2 at = Vec2::Zero(), size = context.page;
    for (const pugi::xml_node& from : {node, sized}) {
      if (!Length(from, "width", context.page.x(), size.x()) ||
          !Length(from, "height", context.page.y(), size.y())) {
        return false;
      }
    }
    if (SvgName(node.name()) == "svg" && (!Length(node, "x", context.page.x(), at.x()) ||
                                          !Length(node, "y", context.page.y(), at.y()))) {
      return false;
    }
    if (!(size.minCoeff() > 0)) return true;  // not drawn, as the standard defines
    context.to_page = context.to_page.Then({1, 0, 0, 1, at.x(), at.y()});
    return ApplyViewBox(node, size, context) && ReadChildren(node, context);
  }

  bool ReadUse(const pugi::xml_node& node, Context& context) {
    std::string_view target = node.attribute("href").value();
    if (target.empty()) target = node.attribute("xlink:href").value();
    const auto found =
        target.starts_with('#') ? by_id_.find(target.substr(1)) : by_id_.end();
    if (found == by_id_.end()) {
      builder_.LeaveOut("use of an element that is not in the file");
      return true;
    }
    if (!builder_.CountEntity("use")) return false;
    if (++context.references > options_.limits.max_nesting) return RefuseDepth(node);
    Vec2 at = Vec2::Zero();
    if (!Length(node, "x", context.page.x(), at.x()) ||
        !Length(node, "y", context.page.y(), at.y())) {
      return false;
    }
    context.to_page = context.to_page.Then({1, 0, 0, 1, at.x(), at.y()});
    if (SvgName(found->second.name()) == "symbol") {
      bool displayed = true;  // the value for the symbol itself, which is never drawn
      if (!TakeStyle(found->second, context, displayed)) return false;
      return ReadViewport(found->second, node, context);
    }
    return ReadElement(found->second, context);
  }

  bool ReadShape(const pugi::xml_node& node, const Context& context) {
    std::vector<Curve> curves;
    // Lines are counted for errors alone: it takes the whole file.
    if (!builder_.CountEntity("") ||
        (context.references > 0 && !CountAgain(node, {"d", "points"}))) {
      return false;
    }
    if (context.hidden) {
      builder_.LeaveOut("invisible");
      return true;
    }
    DrawingBuilder probe("", options_.limits);
    if (!SvgShapeCurves(node, context.page, "", probe, curves)) {
      return SvgShapeCurves(node, context.page, PlaceOf(node), builder_, curves);
    }
    const SvgTransform& t = context.to_page;
    Mat3 linear = Mat3::Identity();
    linear.topLeftCorner<2, 2>() << t.a, t.c, t.b, t.d;
    const Vec3 offset(t.e, t.f, 0);
    for (Curve& curve : curves) {
      for (Piece& piece : curve.pieces) Transform(linear, offset, piece);
      curve.layer = context.layer;
      curve.color = context.color;
      if (!builder_.Add(std::move(curve), SvgName(node.name()))) return false;
    }
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

  std::string_view text_;
  ReadOptions options_;
  DrawingBuilder builder_;
  SvgStyleSheets sheets_;
  pugi::xml_document document_;
  std::unordered_map<std::string_view, pugi::xml_node> by_id_;
};

}  // namespace

Result<Drawing> ReadSvg(std::string_view text, const ReadOptions& options,
                        std::string_view name) {
  RequireUsable(options);
  return SvgReader(text, options, name).Read();
}

}  // namespace intaglio::drawing
