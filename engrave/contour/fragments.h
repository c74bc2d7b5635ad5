#pragma once

// What remains of the edges of areas, and contours made of it.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/contour/covers.h"

namespace intaglio::contour {

struct Fragment {
  Edge edge;  ///< the union to its left
  std::uint32_t area = 0;
};

/// A part of an edge that does not remain although no other area covers it clearly: its
/// middle. Another fragment has to run through there, or an area has to cover it.
struct Omission {
  Vec2 place_mm;
  Vec2 outward;
  std::uint32_t area = 0;
};

struct Remains {
  std::vector<Fragment> fragments;
  std::vector<Omission> omissions;
};

/// The parts of all edges outside every other area. Of edges that run along each other in
/// one direction that of the area with the lowest number remains, of opposite ones none.
/// Sorts `covers`.
Remains RemainsOf(std::span<const Area> areas, const CoverFinder& finder,
                  std::vector<Cover>& covers);

struct ChainedContour {
  std::vector<std::uint32_t> fragments;  ///< in their order
  bool closed = false;
};

/// Chains fragments end to beginning, to kVertex_mm. Where several begin, that of the
/// same area, else the sharpest turn to the left goes on, so that areas that only touch
/// keep contours of their own.
std::vector<ChainedContour> Chain(std::span<const Fragment> fragments);

/// The edges of a contour, with neighbours joined that lie on one line or one circle.
Edges Joined(std::span<const Fragment> fragments, std::span<const std::uint32_t> contour);

}  // namespace intaglio::contour
