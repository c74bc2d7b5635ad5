#include "engrave/sort/boustrophedon.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/sort/cone_order.h"
#include "engrave/sort/slabs.h"

namespace intaglio::sort {

Status CheckBoustrophedonOptions(const OrderOptions& options) {
  INTAGLIO_TRY(CheckThickness("boustrophedon.layer_thickness_mm",
                              options.boustrophedon.layer_thickness_mm));
  INTAGLIO_TRY(
      CheckThickness("boustrophedon.row_width_mm", options.boustrophedon.row_width_mm));
  const double turn_rad = options.boustrophedon.row_turn_rad;
  if (std::abs(turn_rad) <= std::numbers::pi) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("boustrophedon.row_turn_rad: {} is outside -pi..pi", turn_rad),
              fmt::format("{}", turn_rad));
}

namespace {

/// By x along the rows and by y across them. A turn of 0 changes no bit.
PointList AlongRows(const PointList& points_mm, double row_turn_rad) {
  const double c = std::cos(row_turn_rad), s = std::sin(row_turn_rad);
  PointList turned_mm;
  turned_mm.reserve(points_mm.size());
  for (const Vec3& p : points_mm)
    turned_mm.emplace_back(c * p.x() + s * p.y(), c * p.y() - s * p.x(), p.z());
  return turned_mm;
}

}  // namespace

Result<Order> OrderByBoustrophedon(const PointList& points_mm,
                                   const OrderOptions& options,
                                   const ProgressSink& progress) {
  Order order(points_mm.size());
  if (points_mm.empty()) return order;
  if (progress && !progress(0, points_mm.size())) {
    return Fail(ErrorCode::kCancelled, "the sort was cancelled");
  }
  const auto slab = SlabNumbers(points_mm, 2, options.boustrophedon.layer_thickness_mm);
  const PointList turned_mm = AlongRows(points_mm, options.boustrophedon.row_turn_rad);
  const auto row = SlabNumbers(turned_mm, 1, options.boustrophedon.row_width_mm);
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (slab[a] != slab[b]) return slab[a] < slab[b];
    if (row[a] != row[b]) return (slab[a] % 2 == 0) == (row[a] < row[b]);
    const double x = turned_mm[a].x() - turned_mm[b].x();
    if (x != 0) return ((slab[a] + row[a]) % 2 == 0) == (x < 0);
    return a < b;
  });
  return KeepToCone(points_mm, order, options.cone);
}

}  // namespace intaglio::sort
