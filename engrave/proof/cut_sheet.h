#pragma once

// A sheet by cells, and how deep a tool has cut each of them: an upright cylinder that
// goes along straight ways. A cell is its middle; whether the tool has been over it is
// exact. Frame: x and y of the machine, mm; depth below the face of the sheet.
// Time: cells that the tool sweeps.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::proof {

/// A straight way of the tip. z: above the face of the sheet, so negative in it.
struct CutStep {
  Vec3 from_mm = Vec3::Zero(), to_mm = Vec3::Zero();
};

class CutSheet {
 public:
  /// kTooLarge: of more than kMaxCells cells.
  static Result<CutSheet> Make(const Vec2& min_mm, const Vec2& max_mm, double cell_mm);

  /// Takes away what the tool has on its way.
  void Sweep(const CutStep& step, double radius_mm);

  double cell_mm() const { return cell_mm_; }
  int column_count() const { return columns_; }
  int row_count() const { return rows_; }
  std::size_t size() const { return depths_.size(); }
  /// Of cell row * column_count() + column, um, to 65 535; 0: uncut.
  std::uint16_t depth_um(std::size_t cell) const { return depths_[cell]; }

  static constexpr std::size_t kMaxCells = std::size_t{1} << 26;

 private:
  void SweepShort(const CutStep& step, double radius_mm);

  Vec2 min_mm_ = Vec2::Zero();
  double cell_mm_ = 1;
  int columns_ = 0, rows_ = 0;
  std::vector<std::uint16_t> depths_;
};

/// Of each cell the number of its piece of the uncut face, from 1; 0: it is cut. Cells
/// hang together over their sides.
std::vector<std::uint32_t> PiecesOf(const CutSheet& sheet);

}  // namespace intaglio::proof
