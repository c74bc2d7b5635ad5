#include "engrave/sort/boustrophedon.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/sort/cone_order.h"
#include "engrave/sort/slabs.h"

namespace intaglio::sort {

Status CheckBoustrophedonOptions(const OrderOptions& options) {
  INTAGLIO_TRY(CheckThickness("boustrophedon.layer_thickness_mm",
                              options.boustrophedon.layer_thickness_mm));
  return CheckThickness("boustrophedon.row_width_mm", options.boustrophedon.row_width_mm);
}

Result<Order> OrderByBoustrophedon(const PointList& points_mm,
                                   const OrderOptions& options,
                                   const ProgressSink& progress) {
  Order order(points_mm.size());
  if (points_mm.empty()) return order;
  if (progress && !progress(0, points_mm.size())) {
    return Fail(ErrorCode::kCancelled, "the sort was cancelled");
  }
  const auto slab = SlabNumbers(points_mm, 2, options.boustrophedon.layer_thickness_mm);
  const auto row = SlabNumbers(points_mm, 1, options.boustrophedon.row_width_mm);
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (slab[a] != slab[b]) return slab[a] < slab[b];
    if (row[a] != row[b]) return (slab[a] % 2 == 0) == (row[a] < row[b]);
    const double x = points_mm[a].x() - points_mm[b].x();
    if (x != 0) return ((slab[a] + row[a]) % 2 == 0) == (x < 0);
    return a < b;
  });
  return KeepToCone(points_mm, order, options.cone);
}

}  // namespace intaglio::sort
