#pragma once

// Clip paths of SVG: of shapes and of uses of shapes, by clip-rule, clipped themselves,
// and in units of the box of what they clip (SVG 1.1, 14.3; CSS Masking 1, 5).

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <pugixml.hpp>
#include <unordered_map>
#include <vector>

#include "engrave/drawing/clip.h"
#include "engrave/drawing/drawing_builder.h"
#include "engrave/drawing/svg/svg_document.h"
#include "engrave/drawing/svg/svg_scope.h"

namespace intaglio::drawing {

/// The box of all curves, in their frame; empty when there are none.
Box3 ExtentOf(const std::vector<Curve>& curves);

class SvgClips {
 public:
  using Areas = std::vector<std::shared_ptr<const ClipArea>>;
  /// Sets the box of what is clipped, in its user space. False: the builder has the
  /// error.
  using BoxSource = std::function<bool(Box3& box)>;

  SvgClips(DrawingBuilder& builder, SvgDocument& document, SvgScopes& scopes)
      : builder_(builder), document_(document), scopes_(scopes) {}

  /// Adds the clip path to the scope of the element that refers to it. `is_read` false:
  /// it is none, or something in it cannot be read, and nothing is added. False: the
  /// builder has the error.
  bool Take(const pugi::xml_node& node, const BoxSource& box, SvgScope& scope,
            bool& is_read);
  /// Adds the box of a viewport.
  void TakeViewport(const Vec2& size, SvgScope& scope);

  /// What is within all clips of the scope. False, and the curves stay: see
  /// ClipArea::Cut.
  bool Cut(const SvgScope& scope, std::vector<Curve>& curves);

 private:
  /// A clip path that is being read.
  struct Reading {
    Areas within;  ///< of the clip path itself
    std::vector<ClipShape> shapes;
    bool is_read = true;
    int depth = 0;
  };
  struct Known {
    std::array<double, 9> place{};
    Areas areas;
    bool is_read = false;
  };

  bool Read(const pugi::xml_node& node, const BoxSource& box, const SvgScope& user,
            Reading& reading);
  bool ReadOwnClip(const SvgStyle& style, const BoxSource& box, const SvgScope& scope,
                   Reading& reading, Areas& within);
  bool InheritStyle(const pugi::xml_node& node, SvgScope& scope);
  bool ReadChild(const pugi::xml_node& node, SvgScope scope, Areas within,
                 Reading& reading);
  bool ReadUse(const pugi::xml_node& node, SvgScope& scope, const Areas& within,
               Reading& reading);
  void AddShape(ClipShape shape, const Areas& within, Reading& reading);

  DrawingBuilder& builder_;
  SvgDocument& document_;
  SvgScopes& scopes_;
  ClipWork work_;
  std::unordered_map<std::size_t, Known> known_;  ///< the last of each clip path
};

}  // namespace intaglio::drawing
