#pragma once

// A way through places, each once, made shorter: a piece of it turned round (2-opt), or a
// few consecutive places moved elsewhere (Or-opt), wherever two near places become
// neighbours and the way gets shorter, until no such change is left.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::sort {

/// What a step costs between places of different groups, as a way, mm.
struct GroupChange {
  std::span<const std::uint32_t> groups = {};  ///< of each place; empty: all are of one
  double change_mm = 0;                        ///< >= 0
};

/// `way`: indices into `places_mm`, each once. Its beginning is reached from `from_mm`,
/// whatever the group, its end is free. Never longer than it was, with what the changes
/// cost; the same arguments give the same way.
void ShortenWay(std::span<const Vec2> places_mm, const Vec2& from_mm,
                std::vector<std::uint32_t>& way, const GroupChange& change = {});

}  // namespace intaglio::sort
