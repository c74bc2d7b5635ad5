#pragma once

#include <cstdint>
#include <vector>

namespace intaglio::discretize {

/// The order in which a triangular lattice is filled so that at every density the chosen
/// places are distributed as evenly as possible (void and cluster, Ulichney 1993), as a
/// tile that is periodic in both directions. Rows are a step of sqrt(3)/2 apart; odd rows
/// are shifted half a step to the right.
class HalftoneMask {
 public:
  static constexpr int kSide = 128;  ///< columns and rows; even

  /// Integer arithmetic: the same seed gives the same mask on every machine. 50 ms.
  explicit HalftoneMask(std::uint64_t seed);

  /// Whether the place is taken at a density of 0 (none) to 1 (all).
  bool Takes(int column, int row, double density) const {
    constexpr unsigned kMask = kSide - 1;
    const auto at = (static_cast<unsigned>(row) & kMask) * kSide +
                    (static_cast<unsigned>(column) & kMask);
    return rank_[at] + 0.5 < density * kSide * kSide;
  }

 private:
  std::vector<std::uint16_t> rank_;
};

}  // namespace intaglio::discretize
