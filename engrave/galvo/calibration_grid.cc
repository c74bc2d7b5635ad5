#include "engrave/galvo/calibration_grid.h"

#include <fmt/format.h>

#include <cmath>

namespace intaglio::galvo {

Status CheckCalibrationGrid(int nodes, double pitch_mm) {
  if (nodes < 5 || nodes > 65 || nodes % 2 == 0) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("a grid of {} nodes a side; give an odd number of 5..65", nodes),
        fmt::format("{}", nodes));
  }
  if (!(pitch_mm > 0) || !std::isfinite(pitch_mm))
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("a pitch of {} mm; give more than 0", pitch_mm),
                fmt::format("{}", pitch_mm));
  return {};
}

std::vector<Vec2> CalibrationGrid(int nodes, double pitch_mm) {
  const int half = (nodes - 1) / 2;
  std::vector<Vec2> places_mm;
  for (int y = -half; y <= half; ++y)
    for (int x = -half; x <= half; ++x) places_mm.emplace_back(pitch_mm * Vec2(x, y));
  return places_mm;
}

}  // namespace intaglio::galvo
