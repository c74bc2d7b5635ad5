#pragma once

#include <string_view>

#include "engrave/formats/point_file.h"

namespace intaglio::formats {

/// Three or more numbers a line, as ReadXyz() in point_file.h describes them.
Result<PointTable> ParseCoordinateLines(std::string_view bytes,
                                        const PointFileLimits& limits);

/// kTooLarge, for a text that has more points than allowed.
tl::unexpected<Error> MorePointsThanAllowed(const PointFileLimits& limits);

}  // namespace intaglio::formats
