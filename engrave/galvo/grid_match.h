#pragma once

// Which measured mark is which node of a square grid that was marked: from the mark in
// the middle outwards, neighbour by neighbour, so that distortion and a turn of some
// degrees do not matter. With the disc that shows the direction (calibration_grid.h) the
// piece may also lie turned by quarters; without it the measurement is taken as upright,
// turned by less than 20 degrees, and no mirror image.

#include <optional>
#include <span>
#include <vector>

#include "engrave/galvo/head_fit.h"

namespace intaglio::galvo {

struct GridMatch {
  std::vector<GridMark> marks;      ///< commands: nodes of the grid around 0
  std::size_t left_out_count = 0;   ///< measured marks that are no disc: dust
  std::size_t not_found_count = 0;  ///< nodes without a mark
  /// Counterclockwise, of the measurement, which is turned back; nothing when the disc
  /// that shows it was not found.
  std::optional<int> quarter_turns;
};

/// `measured_mm`: about as large as the grid, in any frame; measured places are given
/// from their middle. `nodes` a side: odd, 5..65; `pitch_mm` > 0. A neighbour is where
/// the ones before it lead within a quarter of the pitch. kInvalidValue: other numbers, a
/// grid whose rows and columns are not as many as `nodes`, with how many were found, or a
/// mirror image.
Result<GridMatch> MatchGrid(std::span<const Vec2> measured_mm, int nodes,
                            double pitch_mm);

}  // namespace intaglio::galvo
