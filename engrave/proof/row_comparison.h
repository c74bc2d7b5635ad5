#pragma once

// What a scan head burnt of a row of dots (mark::IsRow), dot by dot. Frame: material, mm.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/formats/mark_record.h"
#include "engrave/proof/mark_comparison.h"

namespace intaglio::proof {

struct BurntRow {
  std::uint32_t missed_count = 0, incomplete_count = 0, doubled_count = 0;
  /// After `offset_mm`: largest distance of a tick's end from its dot, or of what was
  /// burnt of a dot, by its mean, from the dot's middle.
  double shape_um = 0;

  /// That of the whole row: made when each of its dots is.
  BurntFate fate() const;
};

/// `dots`: the lit ways of the row in their order, as planned. Each tick belongs to the
/// dot that is nearest to its middle along the row, when the first tick is laid upon the
/// begin of the first dot: where the web was is not known. `offset_mm`: what is burnt
/// less what is planned.
BurntRow CompareRow(std::span<const std::vector<Vec2>> dots,
                    std::span<const formats::BurntTick> ticks, std::uint32_t pass_count,
                    const Vec2& offset_mm);

}  // namespace intaglio::proof
