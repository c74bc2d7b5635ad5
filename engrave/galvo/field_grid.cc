#include "engrave/galvo/field_grid.h"

#include <fmt/format.h>

#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::galvo {
namespace {

constexpr int kMaxNodes = 1025;

}  // namespace

FieldGrid CentredGrid(double width_mm, int nodes) {
  Require(width_mm > 0 && nodes >= 2 && nodes <= kMaxNodes,
          "a grid of {} mm with {} nodes a side", width_mm, nodes);
  FieldGrid grid{nodes, -width_mm / 2, width_mm / (nodes - 1), {}};
  grid.values_mm.assign(static_cast<std::size_t>(nodes) * static_cast<std::size_t>(nodes),
                        Vec2::Zero());
  return grid;
}

Status CheckGrid(const FieldGrid& grid) {
  if (grid.nodes < 2 || grid.nodes > kMaxNodes) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("a grid of {} nodes a side; give 2..{}", grid.nodes, kMaxNodes),
        fmt::format("{}", grid.nodes));
  }
  if (!(grid.pitch_mm > 0) || !std::isfinite(grid.pitch_mm) ||
      !std::isfinite(grid.first_mm)) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("a grid from {} mm with a pitch of {} mm; give finite numbers "
                    "and a pitch above 0",
                    grid.first_mm, grid.pitch_mm),
        fmt::format("{}", grid.pitch_mm));
  }
  const auto nodes = static_cast<std::size_t>(grid.nodes);
  if (grid.values_mm.size() != nodes * nodes) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("a grid of {0} x {0} nodes has {1} values; give one a node",
                            nodes, grid.values_mm.size()),
                fmt::format("{}", grid.values_mm.size()));
  }
  for (std::size_t i = 0; i < grid.values_mm.size(); ++i) {
    if (grid.values_mm[i].allFinite()) continue;
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("node {} of row {} of a grid is no number; measure it again",
                            i % nodes, i / nodes));
  }
  return {};
}

}  // namespace intaglio::galvo
