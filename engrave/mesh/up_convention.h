#pragma once

// Which axis points up in files of formats that define none, by what most programs write
// into them. It is no fact about a file (UpAxisOfFile gives those), so a person is asked.
//
// OBJ: y, the default of the exporters of Blender, Maya, ZBrush and 3ds Max. PLY: scans
// and figures have y up, parts have z up. STL, 3MF and 3DS: z, as printers and 3ds Max
// have it.

#include <string_view>

#include "engrave/mesh/up_axis.h"

namespace intaglio::mesh {

enum class UpConvention { kZ, kMostlyY, kYOrZ };

/// By the file name's extension, in any case. kZ for one that is not listed, too.
UpConvention UpConventionOf(std::string_view extension);

}  // namespace intaglio::mesh
