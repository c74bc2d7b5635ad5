#pragma once

// What a union has to satisfy, checked on its fragments. Shares no decision with their
// making: only the signed distance of a point from an area.

#include <optional>
#include <string>

#include "engrave/contour/fragments.h"
#include "engrave/core/progress.h"

namespace intaglio::contour {

/// What is wrong, and where.
struct Refusal {
  std::string sentence;
  Vec2 place_mm;
  std::uint32_t area = 0;
};

/// Nothing when everything holds. `pairs`: those of the areas that may meet; `groups`:
/// one number for each area, alike for those that touch. `progress`, which may be empty:
/// in fragments; false from it ends the proof without a refusal.
std::optional<Refusal> Prove(std::span<const Area> areas, std::span<const Pair> pairs,
                             const Remains& remains,
                             std::span<const ChainedContour> contours,
                             std::span<const std::uint32_t> groups,
                             const ProgressSink& progress = {});

}  // namespace intaglio::contour
