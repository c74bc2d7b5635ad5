#pragma once

// An order made to keep to the beam's cone: whatever it does not say about heights, no
// point is fired through an earlier crack.

#include "engrave/sort/beam/beam_cone.h"
#include "engrave/sort/order.h"

namespace intaglio::sort {

/// `order` with, right before each point, those of the later points that it would shade.
/// An order without violation stays as it is. Every index of points_mm once.
Order KeepToCone(const PointList& points_mm, const Order& order, const BeamCone& cone);

}  // namespace intaglio::sort
