#include "engrave/discretize/mesh/ray_grid.h"

#include <fmt/format.h>

#include <algorithm>

#include "engrave/core/try.h"

namespace intaglio::discretize {
namespace {

constexpr double kMaxRays = 0x1p27;
constexpr double kMaxRaysPerAxis = 0x1p24;

/// The first i < count with origin + i step >= at, or count. The sums are exact.
std::uint32_t FirstFrom(double at_mm, double origin_mm, double step_mm,
                        std::uint32_t count) {
  const double near = std::ceil((at_mm - origin_mm) / step_mm);
  auto i = static_cast<std::uint32_t>(std::clamp(near, 0.0, static_cast<double>(count)));
  while (i > 0 && origin_mm + (i - 1) * step_mm >= at_mm) --i;
  while (i < count && origin_mm + i * step_mm < at_mm) ++i;
  return i;
}

}  // namespace

std::uint32_t RayGrid::ColumnFrom(double u_mm) const {
  return FirstFrom(u_mm, u0_mm, step_u_mm, column_count);
}

std::uint32_t RayGrid::RowFrom(double v_mm) const {
  return FirstFrom(v_mm, v0_mm, step_v_mm, row_count);
}

RayGrid RayGrid::Between() const {
  RayGrid grid = *this;
  grid.u0_mm -= Rounded(0.5 * step_u_mm);
  grid.v0_mm -= Rounded(0.5 * step_v_mm);
  ++grid.column_count;
  ++grid.row_count;
  return grid;
}

namespace {

/// Units and steps; the grid has no rays yet.
RayGrid StepsFor(const Box3& bounds, double step_u_mm, double step_v_mm) {
  RayGrid grid;
  const double reach_mm =
      std::max({bounds.min_mm.cwiseAbs().maxCoeff(), bounds.max_mm.cwiseAbs().maxCoeff(),
                step_u_mm, step_v_mm});
  grid.unit_mm = std::ldexp(1.0, std::ilogb(reach_mm) - 49);
  grid.step_u_mm = grid.Rounded(step_u_mm);
  grid.step_v_mm = grid.Rounded(step_v_mm);
  return grid;
}

Status SetCounts(double columns, double rows, double step_mm, RayGrid& grid) {
  if (columns * rows > kMaxRays || std::max(columns, rows) > kMaxRaysPerAxis) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("a grid of {:.3g} rays is too fine for the model; use a "
                            "distance larger than {} mm",
                            columns * rows, step_mm),
                fmt::format("{}", step_mm));
  }
  grid.column_count = static_cast<std::uint32_t>(columns);
  grid.row_count = static_cast<std::uint32_t>(rows);
  return {};
}

}  // namespace

Result<RayGrid> GridOver(const Box3& bounds, double step_u_mm, double step_v_mm) {
  RayGrid grid = StepsFor(bounds, step_u_mm, step_v_mm);
  const Vec3 size = bounds.size_mm(), center = bounds.center_mm();
  const double columns = std::floor(size.x() / grid.step_u_mm) + 1;
  const double rows = std::floor(size.y() / grid.step_v_mm) + 1;
  INTAGLIO_TRY(SetCounts(columns, rows, step_u_mm, grid));
  grid.u0_mm = grid.Rounded(center.x() - 0.5 * (columns - 1) * grid.step_u_mm);
  grid.v0_mm = grid.Rounded(center.y() - 0.5 * (rows - 1) * grid.step_v_mm);
  return grid;
}

Result<RayGrid> GridThroughOrigin(const Box3& bounds, double step_mm) {
  RayGrid grid = StepsFor(bounds, step_mm, step_mm);
  const double step = grid.step_u_mm;
  const auto first = [&](double min_mm) { return std::ceil(min_mm / step); };
  const auto count = [&](double min_mm, double max_mm) {
    return std::max(0.0, std::floor(max_mm / step) - first(min_mm) + 1);
  };
  INTAGLIO_TRY(SetCounts(count(bounds.min_mm.x(), bounds.max_mm.x()),
                         count(bounds.min_mm.y(), bounds.max_mm.y()), step_mm, grid));
  grid.u0_mm = first(bounds.min_mm.x()) * step;
  grid.v0_mm = first(bounds.min_mm.y()) * step;
  return grid;
}

}  // namespace intaglio::discretize
