#pragma once

// The properties that style sheets, style attributes and presentation attributes set for
// an element, in the order of the cascade (CSS 2.1, 6.4): the attribute of the property's
// name, the rules of sheets by specificity and then by order, the style attribute;
// !important before all.

#include <array>
#include <cstdint>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "engrave/drawing/drawing_builder.h"

namespace intaglio::drawing {

/// The properties that a reader of outlines needs. From kTransform on: transforms and
/// geometry, whose attributes are read with the shapes; a sheet or style attribute sets
/// them before these.
enum class SvgProperty {
  kDisplay,
  kVisibility,
  kStroke,
  kFill,
  kClipPath,
  kClipRule,
  kMask,
  kFilter,
  kMarker,
  kMarkerStart,
  kMarkerMid,
  kMarkerEnd,
  kOverflow,
  kFontSize,
  kOpacity,
  kFillOpacity,
  kStrokeOpacity,
  kStrokeDasharray,
  kTransform,
  kTransformOrigin,
  kTransformBox,
  kTranslate,
  kRotate,
  kScale,
  kOffsetPath,
  kZoom,
  kX,
  kY,
  kWidth,
  kHeight,
  kCx,
  kCy,
  kR,
  kRx,
  kRy,
  kD,
  kCount
};

struct SvgStyle {
  bool displayed = true;       ///< display is not none, and opacity not 0
  std::optional<bool> hidden;  ///< by visibility; none: as the parent is
  /// At most 255 bytes; empty: as the parent's; "none" where its opacity is 0.
  std::string stroke;
  std::string fill;  ///< as stroke
  /// As written, at most 255 bytes; geometry and transforms only when CSS sets them.
  std::array<std::string, static_cast<std::size_t>(SvgProperty::kCount)> values;

  const std::string& value(SvgProperty property) const {
    return values[static_cast<std::size_t>(property)];
  }
  /// What CSS sets for an attribute, else the attribute itself.
  std::string_view Attribute(const pugi::xml_node& node, const char* name) const;
};

/// The rules of all style sheets of a file. Selectors are an element, classes and an id,
/// alone or together, and *; rules of others are counted as left out when they would set
/// one of the properties above, and at-rules by their name.
class SvgStyleSheets {
 public:
  explicit SvgStyleSheets(DrawingBuilder& builder) : builder_(builder) {}

  /// Takes the rules of one sheet behind all before. False: more selectors than a
  /// tenth of DrawingLimits::max_entities.
  bool AddSheet(std::string_view css);

  /// The properties of the element. False: the comparison with rules has exceeded
  /// DrawingLimits::max_unfolded_bytes.
  bool StyleOf(const pugi::xml_node& node, SvgStyle& style);

 private:
  struct Declared {
    std::string value;
    std::uint64_t rank = 0;  ///< the greater wins
  };
  using Declarations =
      std::array<std::optional<Declared>, static_cast<std::size_t>(SvgProperty::kCount)>;
  struct Selector {
    std::string element;  ///< empty: any
    std::string id;
    std::vector<std::string> classes;
  };
  struct Rule {
    Selector selector;
    Declarations declarations;
  };

  static std::optional<Selector> SelectorOf(std::string_view text);
  static bool Declare(std::string_view block, std::uint64_t rank,
                      Declarations& declarations);
  static void Prefer(const Declarations& from, Declarations& winners);
  bool AddRule(std::string_view selectors, std::string_view block);
  Rule& RuleOf(const Selector& selector);
  bool CountCompared(std::uint64_t bytes);
  bool TakeFrom(std::string_view key, const pugi::xml_node& node, Declarations& winners);

  DrawingBuilder& builder_;
  std::vector<Rule> rules_;
  std::unordered_map<std::string, std::size_t> rule_by_selector_;
  /// "#id", else ".class", else the element, else "": the first that a selector names.
  std::unordered_map<std::string, std::vector<std::size_t>> rules_by_key_;
  std::uint64_t selector_count_ = 0;
  std::uint64_t compared_bytes_ = 0;
};

}  // namespace intaglio::drawing
