#include "engrave/calibrate/test_pattern.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

// A row of x is made upwards of x when layer + row number is even, a column upwards of y
// when the layer is even (engrave/sort/boustrophedon.h); a layer is left empty where the
// next direction needs it. Row numbers count from the lowest y of all marks.

namespace intaglio::calibrate {
namespace {

constexpr double kRowDistanceMm = 0.6;  // between two rows of a station
constexpr double kLimitShare = 1e-6;    // as of the order, against rounding

struct Row {
  Vec2 start_mm;
  int axis = 0;  // along which it lies
  double step_mm = 0;
  bool upwards = true;
};

double LengthOf(const TestPatternOptions& o, double step_mm) {
  return step_mm * (o.marks_per_row - 1);
}

/// Width and depth of a station.
Vec2 StationSize(const TestPatternOptions& o) {
  const double fast_mm = LengthOf(o, o.fast_step_mm);
  const double rows_mm = 3 * kRowDistanceMm;
  return {std::max(fast_mm, rows_mm), fast_mm + kRowDistanceMm + rows_mm};
}

/// Slow up, slow down, fast up, fast down; rows below, columns above.
std::vector<Row> RowsAt(const TestPatternOptions& o, const Vec2& corner_mm) {
  std::vector<Row> rows;
  const double above_mm = 4 * kRowDistanceMm;
  for (int axis = 0; axis < 2; ++axis) {
    for (int i = 0; i < 4; ++i) {
      Vec2 start_mm = corner_mm;
      start_mm[1 - axis] += i * kRowDistanceMm;
      if (axis == 1) start_mm.y() += above_mm;
      rows.push_back(
          {start_mm, axis, i < 2 ? o.slow_step_mm : o.fast_step_mm, i % 2 == 0});
    }
  }
  return rows;
}

void Append(const TestPatternOptions& o, const Row& row, double z_mm,
            PointList& marks_mm) {
  for (int i = 0; i < o.marks_per_row; ++i) {
    const int step = row.upwards ? i : o.marks_per_row - 1 - i;
    Vec3 mark_mm(row.start_mm.x(), row.start_mm.y(), z_mm);
    mark_mm[row.axis] += step * row.step_mm;
    marks_mm.push_back(mark_mm);
  }
}

}  // namespace

Result<TestPattern> MakeTestPattern(const TestPatternOptions& o) {
  const Vec2 station_mm = StationSize(o);
  const Vec2 room_mm = o.block_mm.head<2>().array() - 2 * o.margin_mm;
  TestPattern pattern;
  // A layer for each row and one that is left out, and the margin above and below.
  const double depth_mm = 2 * 8 * o.stations * o.stations * pattern.layer_mm;
  const Vec3 needed_mm(o.stations * station_mm.x(), o.stations * station_mm.y(),
                       depth_mm);
  const Vec3 given_mm(room_mm.x(), room_mm.y(), o.block_mm.z() - 2 * o.margin_mm);
  if ((given_mm.array() < needed_mm.array()).any()) {
    const Vec3 smallest_mm = needed_mm.array() + 2 * o.margin_mm;
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("block {:g} x {:g} x {:g} mm is too small for the test "
                            "pattern; take one of {:.3g} x {:.3g} x {:.3g} mm or more",
                            o.block_mm.x(), o.block_mm.y(), o.block_mm.z(),
                            smallest_mm.x(), smallest_mm.y(), smallest_mm.z()));
  }
  const double top_mm = o.block_mm.z() - o.margin_mm;
  int layer = 0;
  for (int j = 0; j < o.stations; ++j) {
    for (int i = 0; i < o.stations; ++i) {
      const Vec2 share = Vec2(i, j) / (o.stations - 1);
      const Vec2 corner_mm =
          Vec2::Constant(o.margin_mm) + share.cwiseProduct(room_mm - station_mm);
      for (const Row& row : RowsAt(o, corner_mm)) {
        const auto number = static_cast<int>(
            (row.start_mm.y() - o.margin_mm) / pattern.row_width_mm + kLimitShare);
        const bool odd = (layer + (row.axis == 0 ? number : 0)) % 2 != 0;
        if (odd == row.upwards) ++layer;
        Append(o, row, top_mm - depth_mm + layer * pattern.layer_mm, pattern.marks_mm);
        ++layer;
      }
    }
  }
  return pattern;
}

}  // namespace intaglio::calibrate
