#pragma once

#include <memory>

#include "engrave/discretize/spacing/point_source.h"

namespace intaglio::discretize {

/// The points of a source with its ranges along another direction, for a job whose
/// sources rise differently. All points are made and kept at the first call of AddPoints.
/// Keeps a reference to the source.
std::unique_ptr<PointSource> MakeRemembered(const PointSource& source, const Vec3& rise);

}  // namespace intaglio::discretize
