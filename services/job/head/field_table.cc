#include "services/job/head/field_table.h"

#include <fmt/format.h>

#include <cmath>

#include "engrave/core/check.h"

namespace intaglio {
namespace {

constexpr double kNmPerMm = 1e6;
constexpr double kSamePlaceMm = 1e-9;

std::int32_t Nanometres(double mm) {
  return static_cast<std::int32_t>(std::lround(mm * kNmPerMm));
}

}  // namespace

FieldTable FieldTableOf(const galvo::FieldGrid& grid) {
  Require(std::abs(grid.first_mm + 0.5 * (grid.nodes - 1) * grid.pitch_mm) < kSamePlaceMm,
          "a table that begins at {} mm is not centred", grid.first_mm);
  FieldTable table;
  table.set_pitch_mm(grid.pitch_mm);
  table.set_nodes_a_side(static_cast<std::uint32_t>(grid.nodes));
  for (const Vec2& value_mm : grid.values_mm) {
    table.add_x_nm(Nanometres(value_mm.x()));
    table.add_y_nm(Nanometres(value_mm.y()));
  }
  return table;
}

Result<galvo::FieldGrid> GridOf(const FieldTable& table) {
  const auto nodes = static_cast<int>(table.nodes_a_side());
  const int count = nodes * nodes;
  if (table.x_nm_size() != count || table.y_nm_size() != count) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("has {} and {} numbers of {} nodes a side; give "
                            "correction_file in its place",
                            table.x_nm_size(), table.y_nm_size(), nodes));
  }
  galvo::FieldGrid grid{
      nodes, -0.5 * (nodes - 1) * table.pitch_mm(), table.pitch_mm(), {}};
  for (int i = 0; i < count; ++i)
    grid.values_mm.emplace_back(table.x_nm(i) / kNmPerMm, table.y_nm(i) / kNmPerMm);
  return grid;
}

}  // namespace intaglio
