#pragma once

// What an element of an SVG takes from its groups and passes on to its children, and how
// its attributes change it.

#include <cstdint>
#include <initializer_list>
#include <memory>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/drawing/clip.h"
#include "engrave/drawing/drawing_builder.h"
#include "engrave/drawing/svg/svg_document.h"
#include "engrave/drawing/svg/svg_path.h"
#include "engrave/drawing/svg/svg_style.h"

namespace intaglio::drawing {

// When neither width nor height is given: the default sizes of browsers.
inline constexpr double kSvgWidth_px = 300, kSvgHeight_px = 150;
inline constexpr double kSvgEm_px = 16;

struct SvgScope {
  SvgTransform to_page;  ///< user space to the drawing, mm, y up
  Vec2 page = Vec2(kSvgWidth_px, kSvgHeight_px);
  double em = kSvgEm_px;
  std::uint32_t layer = 0;
  std::uint32_t color = 0;
  bool hidden = false;
  bool filled = true;
  bool stroked = false;
  bool clips_even_odd = false;  ///< clip-rule
  int depth = 0;
  int references = 0;
  std::vector<std::shared_ptr<const ClipArea>> clips;
  std::vector<std::string> not_obeyed;  ///< what changes the shapes below: "mask"
};

/// The piece in the space to which the transform leads.
void ToPage(const SvgTransform& transform, Piece& piece);

/// The box from 0 0 to `size`, likewise.
Curve SvgBoxOf(const SvgTransform& transform, const Vec2& size);

/// Applies the attributes and properties of elements to scopes. Functions that return
/// false leave the error in the builder.
class SvgScopes {
 public:
  SvgScopes(DrawingBuilder& builder, SvgDocument& document)
      : builder_(builder), document_(document) {}

  /// A length that cannot be read is as one that is not given, which is what browsers do.
  void TakeLength(const pugi::xml_node& node, const SvgStyle& style,
                  const char* attribute, double whole, double em, double& length);
  /// The viewBox of an element of this size: its transform, and its own page.
  void TakeViewBox(const pugi::xml_node& node, const Vec2& size, SvgScope& scope);
  bool TakeStyle(const pugi::xml_node& node, SvgScope& scope, SvgStyle& style);
  void TakeTransform(const pugi::xml_node& node, const SvgStyle& style, SvgScope& scope);
  /// The x and y of a use, which end its transform: its clip moves with them.
  void TakePlaceOfUse(const pugi::xml_node& node, const SvgStyle& style, SvgScope& scope);

  /// The curves of a shape in its user space. A wrong attribute ends a shape, and not the
  /// file.
  bool CurvesOf(const pugi::xml_node& node, const SvgStyle& style, const SvgScope& scope,
                std::vector<Curve>& curves);
  /// Counts the bytes of an element that is read again because of a reference.
  bool CountAgain(const pugi::xml_node& node,
                  std::initializer_list<const char*> attributes);

 private:
  void LeaveOut(const pugi::xml_node& node, std::string_view attribute);

  DrawingBuilder& builder_;
  SvgDocument& document_;
};

}  // namespace intaglio::drawing
