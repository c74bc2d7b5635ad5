#pragma once

// Which of some points must be made before which others, because they lie in the beam
// cone above them (beam_cone.h). Only the pairs are kept from which all others follow.

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/sort/beam/beam_cone.h"

namespace intaglio::sort {

class Precedence {
 public:
  /// points_mm: frame glass, mm; indices below are of this list.
  Precedence(std::span<const Vec3> points_mm, const BeamCone& cone);

  /// Points above `point`, to be made after it.
  std::span<const std::uint32_t> After(std::uint32_t point) const {
    return {after_.data() + after_begin_[point],
            after_begin_[point + 1] - after_begin_[point]};
  }
  /// Points below `point`, to be made before it.
  std::span<const std::uint32_t> Before(std::uint32_t point) const {
    return {before_.data() + before_begin_[point],
            before_begin_[point + 1] - before_begin_[point]};
  }

 private:
  std::vector<std::uint32_t> after_begin_, after_;
  std::vector<std::uint32_t> before_begin_, before_;
};

}  // namespace intaglio::sort
