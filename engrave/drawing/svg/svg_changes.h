#pragma once

#include <string>
#include <vector>

#include "engrave/core/findings.h"
#include "engrave/drawing/drawing.h"
#include "engrave/drawing/svg/svg_document.h"
#include "engrave/drawing/svg/svg_style.h"

namespace intaglio::drawing {

/// What changes the look of a shape and is not obeyed: the names of `not_obeyed` from its
/// groups and itself, its markers and its patterns, each with the area of the box of its
/// curves, which are at their place, mm.
std::vector<FileFinding> SvgChangesOf(const SvgStyle& style,
                                      const std::vector<std::string>& not_obeyed,
                                      const SvgDocument& document,
                                      const std::vector<Curve>& curves);

}  // namespace intaglio::drawing
