#pragma once

// Copies of a model, and models that count as one.

#include <memory>
#include <vector>

#include "engrave/discretize/spacing/point_source.h"

namespace intaglio::discretize {

/// The points of `source`, moved by offset_mm (glass frame). A point within rounding of a
/// range's end may be counted on its other side, for both ranges alike.
std::unique_ptr<PointSource> MakeShifted(std::shared_ptr<const PointSource> source,
                                         const Vec3& offset_mm);

/// All points of all sources, as of one model. They have one rise.
std::unique_ptr<PointSource> MakeSeveral(
    std::vector<std::unique_ptr<PointSource>> sources);

/// The positions of copies: count[i] along axis i, step_mm[i] apart, x first, then y,
/// then z. With `centred` the middle of the grid is at 0, else its first copy.
PointList GridOffsets(const Eigen::Vector3i& count, const Vec3& step_mm, bool centred);

}  // namespace intaglio::discretize
