#pragma once

#include <algorithm>
#include <array>
#include <pugixml.hpp>
#include <string_view>

#include "engrave/core/findings.h"
#include "engrave/io/lower_case.h"

namespace intaglio::drawing {

/// An element that is never drawn where it is: it is used by others, which report it, or
/// describes the file.
inline bool IsSvgDefinition(std::string_view element) {
  constexpr std::array<std::string_view, 19> kNames = {
      "defs",   "symbol",  "title",          "desc",           "style",
      "script", "filter",  "metadata",       "namedview",      "view",
      "marker", "pattern", "linearGradient", "radialGradient", "clipPath",
      "mask",   "cursor",  "color-profile",  "font-face"};
  return std::ranges::find(kNames, element) != kNames.end();
}

inline bool IsSvgPaint(std::string_view paint) {
  return paint != "none" && paint != "transparent";
}

/// What it means for the piece that the reader does not obey an element of SVG: all that
/// is not known is missing in the piece; what moves shows its beginning.
inline Effect EffectOfSvgElement(std::string_view element) {
  constexpr std::array<std::string_view, 6> kMoving = {
      "animate", "animateColor", "animateMotion", "animateTransform", "set", "discard"};
  return std::ranges::find(kMoving, element) == kMoving.end() ? Effect::kLost
                                                              : Effect::kNothingSeen;
}

/// Whether the element's conditions hold (SVG 1.1, 5.8): no extensions are supported, and
/// the language is English, as that of this program.
inline bool HoldsSvgCondition(const pugi::xml_node& node) {
  if (node.attribute("requiredExtensions")) return false;
  if (!node.attribute("systemLanguage")) return true;
  std::string_view rest = node.attribute("systemLanguage").value();
  while (!rest.empty()) {
    std::string_view language = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), language.size() + 1));
    while (language.starts_with(' ')) language.remove_prefix(1);
    if (io::LowerCase(language.substr(0, 2)) == "en") return true;
  }
  return false;
}

}  // namespace intaglio::drawing
