#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/findings.h"
#include "engrave/drawing/drawing.h"
#include "engrave/drawing/svg/svg_document.h"
#include "engrave/drawing/svg/svg_style.h"

namespace intaglio::drawing {

/// Adds the names of the properties of an element that move, size or dash it and what is
/// in it, and that the reader does not obey: the transforms of CSS beside `transform`,
/// motion along a path, zoom, dashes; of an element with a transform also transform-box,
/// which shifts its origin.
void AddSvgPropertiesNotObeyed(const SvgStyle& style, std::string_view transform,
                               std::vector<std::string>& names);

/// What changes the look of a shape and is not obeyed: the names of `not_obeyed` from its
/// groups and itself, its markers and its patterns, each with the area of the box of its
/// curves, which are at their place, mm. Also the page's edge where the shape crosses it:
/// viewers draw nothing beyond it, and a piece is made of the whole drawing. `page_mm`:
/// the size of the page from 0 0; none: it has no edge.
std::vector<FileFinding> SvgChangesOf(const SvgStyle& style,
                                      const std::vector<std::string>& not_obeyed,
                                      const SvgDocument& document,
                                      const std::vector<Curve>& curves,
                                      const std::optional<Vec2>& page_mm);

}  // namespace intaglio::drawing
