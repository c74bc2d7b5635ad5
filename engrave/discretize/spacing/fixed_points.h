#pragma once

#include <memory>

#include "engrave/discretize/spacing/point_source.h"

namespace intaglio::discretize {

/// A finished list of points as a source, for methods whose points are few or stand in a
/// file. `statistics.point_count` is counted anew in every range; what else the
/// statistics say is told with the range that holds the lowest point. The points' own
/// `source` is not used.
std::unique_ptr<PointSource> MakeFixedPoints(SpacedCloud points,
                                             const MethodStatistics& statistics = {});

}  // namespace intaglio::discretize
