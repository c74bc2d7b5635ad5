#pragma once

#include <pugixml.hpp>

#include "engrave/drawing/drawing_builder.h"

namespace intaglio::drawing {

/// The name without its namespace.
std::string_view SvgName(const char* name);

bool IsSvgShape(std::string_view element);

/// The curves of a shape in its own user space. Percentages refer to `page`. False: the
/// builder has the error.
bool SvgShapeCurves(const pugi::xml_node& node, const Vec2& page, std::string_view place,
                    DrawingBuilder& builder, std::vector<Curve>& curves);

}  // namespace intaglio::drawing
