#pragma once

#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <unordered_map>

#include "engrave/drawing/drawing_builder.h"
#include "engrave/drawing/svg/svg_style.h"

namespace intaglio::drawing {

/// The tree of an SVG with its entities expanded, its elements by their ids, and its
/// style sheets.
class SvgDocument {
 public:
  SvgDocument(std::string_view text, DrawingBuilder& builder)
      : text_(text), builder_(builder), sheets_(builder) {}

  /// False: the builder has the error (too large, not XML, no svg element, nested too
  /// deep).
  bool Load();

  pugi::xml_node root() const { return document_.document_element(); }
  SvgStyleSheets& sheets() { return sheets_; }
  /// Of "#id" or "url(#id)"; no node when it is not in the file.
  pugi::xml_node Find(std::string_view reference) const;
  /// "line 3, rect "a"".
  std::string PlaceOf(const pugi::xml_node& node) const;
  /// The error of an element, or of a reference, that is nested too deep; false.
  bool RefuseDepth(const pugi::xml_node& node);

 private:
  bool CheckSize();
  bool Expand();
  bool Parse();
  bool NoteIdsAndSheets();
  bool TakeSheet(const pugi::xml_node& node);
  std::string LineAt(std::ptrdiff_t offset) const;

  std::string_view text_;
  std::string expanded_;  ///< what text_ views when the file declares entities
  DrawingBuilder& builder_;
  SvgStyleSheets sheets_;
  pugi::xml_document document_;
  std::unordered_map<std::string_view, pugi::xml_node> by_id_;
};

}  // namespace intaglio::drawing
