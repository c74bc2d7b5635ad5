#pragma once

// Which point of the order is next. As a rule the first that has not ended; but a point
// that was passed by, and above which cracks were made since, is not fired through them:
// it stays open, and is reported as such. Shutters do not move during a run: it ends
// where the next point is to be made in other channels than the first.

#include <cstdint>
#include <optional>
#include <span>

#include "engrave/core/channels.h"
#include "engrave/core/geometry.h"
#include "engrave/sort/beam/beam_cone.h"
#include "services/cell/point_ledger.h"
#include "services/synchronizer/pulses/cell_names.h"

namespace intaglio::synchronizer {

class OpenPoints {
 public:
  /// All but `cone` outlive this, which is the beam above a point in the frame of the
  /// points.
  /// `masks`: one a point; empty: all are made in the same channels.
  OpenPoints(const PointList& points_mm, const PointLedger& ledger,
             const sort::BeamCone& cone, std::span<const ChannelMask> masks = {})
      : points_mm_(points_mm), ledger_(ledger), cone_(cone), masks_(masks) {}

  /// Begins a run at the first point of the order again.
  void Rewind();
  /// The channels of all points of the run; 0 when it has none, or masks were not given.
  ChannelMask mask() const { return mask_; }
  /// The next one after the last answer; nullopt at the end of the run.
  std::optional<std::uint32_t> Next();

 private:
  std::optional<std::uint32_t> FindOpen();
  bool Shadowed(std::uint32_t point) const;

  const PointList& points_mm_;
  const PointLedger& ledger_;
  sort::BeamCone cone_;
  std::span<const ChannelMask> masks_;
  ChannelMask mask_ = 0;
  std::uint32_t cursor_ = 0;
};

}  // namespace intaglio::synchronizer
