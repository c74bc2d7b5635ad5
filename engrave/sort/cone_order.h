#pragma once

// Makes any order obey the beam's cone: no point is fired through an earlier crack, even
// if the order itself ignores heights.

#include "engrave/sort/beam/beam_cone.h"
#include "engrave/sort/order.h"

namespace intaglio::sort {

/// `order` with, right before each point, those of the later points that it would shade.
/// An order without violation stays as it is. Every index of points_mm once.
Order KeepToCone(const PointList& points_mm, const Order& order, const BeamCone& cone);

}  // namespace intaglio::sort
