#pragma once

#include <pugixml.hpp>

#include "engrave/drawing/drawing_builder.h"
#include "engrave/drawing/svg/svg_style.h"

namespace intaglio::drawing {

/// The name without its namespace.
std::string_view SvgName(const char* name);

bool IsSvgShape(std::string_view element);

/// What lengths refer to: percent to the page, em to the size of letters, px.
struct SvgScale {
  Vec2 page = Vec2::Zero();
  double em = 16;
};

/// The curves of a shape in its own user space; of path data with an error what comes
/// before it. False: the builder has the error, kInvalidValue when an attribute is wrong.
bool SvgShapeCurves(const pugi::xml_node& node, const SvgStyle& style,
                    const SvgScale& scale, std::string_view place,
                    DrawingBuilder& builder, std::vector<Curve>& curves);

}  // namespace intaglio::drawing
