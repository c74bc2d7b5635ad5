#pragma once

// A way through places, each once, made shorter: a piece of it turned round (2-opt), or a
// few consecutive places moved elsewhere (Or-opt), wherever two near places become
// neighbours and the way gets shorter, until no such change is left.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::sort {

/// `way`: indices into `places_mm`, each once. Its beginning is reached from `from_mm`,
/// its end is free. Never longer than it was; the same arguments give the same way.
void ShortenWay(std::span<const Vec2> places_mm, const Vec2& from_mm,
                std::vector<std::uint32_t>& way);

}  // namespace intaglio::sort
