#pragma once

// Parts of a cloud that an order passes as it passes the whole.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::sort {

/// `count` samples of `size` points each, by index, ascending: the points nearest to
/// places that divide the cloud evenly by height. Neighbours stay neighbours: the
/// distances of the cloud are those of its samples. Samples may share points. A cloud of
/// no more than count * size points is its one sample. Deterministic. count, size >= 1.
/// `by_height`: only heights count for what is near, as for an order in slabs.
std::vector<std::vector<std::uint32_t>> LocalSamples(const PointList& points_mm,
                                                     std::size_t count, std::size_t size,
                                                     bool by_height = false);

}  // namespace intaglio::sort
