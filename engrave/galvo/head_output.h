#pragma once

// What a control board outputs in a tick: 16 bits an axis over the field, 32768 is its
// centre, and the laser.

#include <cstdint>

#include "engrave/galvo/correction_table.h"
#include "engrave/galvo/mark_ticks.h"

namespace intaglio::galvo {

struct HeadOutput {
  std::uint16_t x = 32768, y = 32768;
  bool laser = false;
};

/// Field places to outputs: field = material + displacement, corrected, in steps of
/// L / 2^16, and held at the border of the field.
class OutputMaker {
 public:
  /// `commands`: commands minus targets; null: none. It has to outlive this.
  OutputMaker(double field_mm, const CorrectionTable* commands)
      : field_mm_(field_mm), per_mm_(65536 / field_mm), commands_(commands) {}

  /// Neither allocates nor throws.
  HeadOutput Make(const MarkTick& tick, const Vec2& displacement_mm);

  /// Ticks with the laser on whose place, or the command for it, was beyond the border:
  /// marks that are wrong.
  std::uint64_t lit_outside_count() const { return lit_outside_count_; }

 private:
  double field_mm_, per_mm_;
  const CorrectionTable* commands_;
  std::uint64_t lit_outside_count_ = 0;
};

}  // namespace intaglio::galvo
