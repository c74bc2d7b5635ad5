#pragma once

#include <memory>

#include "engrave/discretize/spacing/point_source.h"

namespace intaglio::discretize {

/// A finished list of points as a source, for methods whose points are few or read from a
/// file. `statistics.point_count` is counted separately for every range; all other
/// statistics are reported with the range that holds the lowest point. The points' own
/// `source` is not used. Heights are measured along `rise`.
std::unique_ptr<PointSource> MakeFixedPoints(SpacedCloud points,
                                             const MethodStatistics& statistics = {},
                                             const Vec3& rise = kUpward);

}  // namespace intaglio::discretize
