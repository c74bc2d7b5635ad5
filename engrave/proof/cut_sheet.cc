#include "engrave/proof/cut_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace intaglio::proof {
namespace {

constexpr double kShort_mm = 1;  // the box of a longer way has many cells beside it
constexpr double kDeepest_um = 65535;

}  // namespace

Result<CutSheet> CutSheet::Make(const Vec2& min_mm, const Vec2& max_mm, double cell_mm) {
  const Vec2 count = ((max_mm - min_mm) / cell_mm).array().ceil().max(1);
  if (!(count.x() * count.y() <= static_cast<double>(kMaxCells))) {
    return Fail(
        ErrorCode::kTooLarge,
        fmt::format("a sheet of {:.0f} x {:.0f} mm has more than {} cells of {:g} "
                    "mm; make the job in parts",
                    max_mm.x() - min_mm.x(), max_mm.y() - min_mm.y(), kMaxCells,
                    cell_mm));
  }
  CutSheet sheet;
  sheet.min_mm_ = min_mm;
  sheet.cell_mm_ = cell_mm;
  sheet.columns_ = static_cast<int>(count.x());
  sheet.rows_ = static_cast<int>(count.y());
  sheet.depths_.assign(
      static_cast<std::size_t>(sheet.columns_) * static_cast<std::size_t>(sheet.rows_),
      0);
  return sheet;
}

void CutSheet::Sweep(const CutStep& step, double radius_mm) {
  const double length_mm = (step.to_mm - step.from_mm).norm();
  const int parts = std::max(1, static_cast<int>(std::ceil(length_mm / kShort_mm)));
  const Vec3 way_mm = (step.to_mm - step.from_mm) / parts;
  for (int i = 0; i < parts; ++i)
    SweepShort({step.from_mm + i * way_mm, step.from_mm + (i + 1) * way_mm}, radius_mm);
}

void CutSheet::SweepShort(const CutStep& step, double radius_mm) {
  if (std::min(step.from_mm.z(), step.to_mm.z()) >= 0) return;
  const Vec2 from = step.from_mm.head<2>(), way = step.to_mm.head<2>() - from;
  const double square = way.squaredNorm();
  const auto first = [&](int axis, int count) {
    const double low = std::min(step.from_mm[axis], step.to_mm[axis]) - radius_mm;
    return std::clamp(static_cast<int>((low - min_mm_[axis]) / cell_mm_), 0, count);
  };
  const auto last = [&](int axis, int count) {
    const double high = std::max(step.from_mm[axis], step.to_mm[axis]) + radius_mm;
    return std::clamp(static_cast<int>((high - min_mm_[axis]) / cell_mm_) + 1, 0, count);
  };
  const int end_row = last(1, rows_), end_column = last(0, columns_);
  for (int row = first(1, rows_); row < end_row; ++row) {
    for (int column = first(0, columns_); column < end_column; ++column) {
      const Vec2 at = min_mm_ + cell_mm_ * Vec2(column + 0.5, row + 0.5);
      const double along =
          square > 0 ? std::clamp((at - from).dot(way) / square, 0.0, 1.0) : 0;
      if ((from + along * way - at).squaredNorm() >= radius_mm * radius_mm) continue;
      const double z =
          square > 0 ? step.from_mm.z() + along * (step.to_mm.z() - step.from_mm.z())
                     : std::min(step.from_mm.z(), step.to_mm.z());
      const double depth_um = std::clamp(std::round(-1e3 * z), 0.0, kDeepest_um);
      auto& cell =
          depths_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(column)];
      cell = std::max(cell, static_cast<std::uint16_t>(depth_um));
    }
  }
}

std::vector<std::uint32_t> PiecesOf(const CutSheet& sheet) {
  constexpr auto kUnseen = static_cast<std::uint32_t>(-1);
  const auto columns = static_cast<std::size_t>(sheet.column_count());
  std::vector<std::uint32_t> pieces(sheet.size());
  for (std::size_t i = 0; i < pieces.size(); ++i)
    pieces[i] = sheet.depth_um(i) == 0 ? kUnseen : 0;
  std::vector<std::size_t> open;
  std::uint32_t count = 0;
  for (std::size_t begin = 0; begin < pieces.size(); ++begin) {
    if (pieces[begin] != kUnseen) continue;
    pieces[begin] = ++count;
    open.push_back(begin);
    const auto visit = [&](std::size_t cell) {
      if (pieces[cell] != kUnseen) return;
      pieces[cell] = count;
      open.push_back(cell);
    };
    while (!open.empty()) {
      const std::size_t cell = open.back();
      open.pop_back();
      if (cell % columns > 0) visit(cell - 1);
      if (cell % columns + 1 < columns) visit(cell + 1);
      if (cell >= columns) visit(cell - columns);
      if (cell + columns < pieces.size()) visit(cell + columns);
    }
  }
  return pieces;
}

}  // namespace intaglio::proof
