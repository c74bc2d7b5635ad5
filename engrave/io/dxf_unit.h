#pragma once

#include <optional>
#include <string_view>

namespace intaglio::io {

/// The length of a drawing's unit, mm, by the value of the header variable $INSUNITS of
/// its DXF (AutoCAD DXF reference, "HEADER section", $INSUNITS: 0 to 24); 1 for a drawing
/// without a unit (0). 21 to 24 are the foot, inch, yard and mile of the US survey.
/// Nothing for any other value. Blanks around it are ignored.
std::optional<double> DxfUnitMm(std::string_view insunits);

}  // namespace intaglio::io
