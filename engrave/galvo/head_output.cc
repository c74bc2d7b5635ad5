#include "engrave/galvo/head_output.h"

#include <algorithm>
#include <cmath>

namespace intaglio::galvo {
namespace {

std::uint16_t BitsOf(double bits) {
  return static_cast<std::uint16_t>(std::clamp(std::floor(bits + 32768.5), 0.0, 65535.0));
}

}  // namespace

HeadOutput OutputMaker::Make(const MarkTick& tick, const Vec2& displacement_mm) {
  const Vec2 field_mm = tick.place_mm + displacement_mm;
  const Vec2 command_mm =
      commands_ == nullptr ? field_mm : Vec2(field_mm + commands_->At(field_mm));
  const double farthest_mm =
      std::max(field_mm.cwiseAbs().maxCoeff(), command_mm.cwiseAbs().maxCoeff());
  if (tick.laser && !(farthest_mm <= field_mm_ / 2)) ++lit_outside_count_;
  return {BitsOf(command_mm.x() * per_mm_), BitsOf(command_mm.y() * per_mm_), tick.laser};
}

}  // namespace intaglio::galvo
