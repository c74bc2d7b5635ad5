#pragma once

// Which point of the order is next. As a rule the first that has not ended; but a point
// that was passed by, and above which cracks were made since, is not fired through them:
// it stays open, and the report says so.

#include <cstdint>
#include <optional>

#include "engrave/core/geometry.h"
#include "services/synchronizer/point_ledger.h"

namespace intaglio::synchronizer {

class OpenPoints {
 public:
  /// Both outlive this. `cone_tangent` >= 0: half angle of the beam above a point, in the
  /// frame of the points. Inside the cone means by more than 1e-9 mm, as in the sorters.
  OpenPoints(const PointList& points_mm, const PointLedger& ledger, double cone_tangent)
      : points_mm_(points_mm), ledger_(ledger), cone_tangent_(cone_tangent) {}

  /// Begins at the first point of the order again.
  void Rewind() { cursor_ = 0; }
  /// The next one after the last answer; nullopt at the end.
  std::optional<std::uint32_t> Next();

 private:
  bool Shadowed(std::uint32_t point) const;

  const PointList& points_mm_;
  const PointLedger& ledger_;
  double cone_tangent_;
  std::uint32_t cursor_ = 0;
};

}  // namespace intaglio::synchronizer
