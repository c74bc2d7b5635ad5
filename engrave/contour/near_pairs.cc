#include "engrave/contour/near_pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace intaglio::contour {
namespace {

constexpr double kMaxEntriesPerBox = 8;

class BoxGrid {
 public:
  BoxGrid(std::span<const FlatBox> boxes, double margin)
      : boxes_(boxes), margin_(margin) {
    double size = 0;
    Vec2 min = boxes[0].min_mm;
    Vec2 max = boxes[0].max_mm;
    for (const FlatBox& box : boxes) {
      size += (box.max_mm - box.min_mm).maxCoeff();
      min = min.cwiseMin(box.min_mm);
      max = max.cwiseMax(box.max_mm);
    }
    const double count = static_cast<double>(boxes.size());
    origin_ = min - Vec2::Constant(margin);
    const Vec2 extent = max + Vec2::Constant(margin) - origin_;
    cell_ = std::max(size / count, 1e-3);
    while (extent.x() / cell_ * (extent.y() / cell_) > 4 * count + 64 ||
           EntryCount() > kMaxEntriesPerBox * count) {
      cell_ *= 1.5;
    }
    // By the expression that places the boxes: any other one rounds otherwise, and a box
    // whose end lies on a line of the grid would reach beyond the last cell.
    columns_ = Column(max.x() + margin) + 1;
    rows_ = Row(max.y() + margin) + 1;
    Fill();
  }

  /// Ends soon after there are more than max_pairs.
  std::vector<Pair> Pairs(std::uint64_t max_pairs) const {
    std::vector<Pair> pairs;
    for (std::size_t cell = 0; cell + 1 < begins_.size(); ++cell) {
      for (std::size_t i = begins_[cell]; i < begins_[cell + 1]; ++i) {
        if (pairs.size() > max_pairs) return pairs;
        for (std::size_t j = i + 1; j < begins_[cell + 1]; ++j) {
          AddPair(cell, entries_[i], entries_[j], pairs);
        }
      }
    }
    return pairs;
  }

 private:
  std::size_t Column(double x) const {
    return static_cast<std::size_t>((x - origin_.x()) / cell_);
  }
  std::size_t Row(double y) const {
    return static_cast<std::size_t>((y - origin_.y()) / cell_);
  }

  double EntryCount() const {
    double count = 0;
    for (const FlatBox& box : boxes_) {
      const Vec2 cells = (box.max_mm - box.min_mm) / cell_;
      count += (cells.x() + 1) * (cells.y() + 1);
    }
    return count;
  }

  template <typename F>
  void ForEachCell(const FlatBox& box, const F& f) const {
    const std::size_t last_column = Column(box.max_mm.x() + margin_);
    const std::size_t last_row = Row(box.max_mm.y() + margin_);
    for (std::size_t y = Row(box.min_mm.y()); y <= last_row; ++y) {
      for (std::size_t x = Column(box.min_mm.x()); x <= last_column; ++x) {
        f(y * columns_ + x);
      }
    }
  }

  void Fill() {
    begins_.assign(columns_ * rows_ + 1, 0);
    for (const FlatBox& box : boxes_) {
      ForEachCell(box, [&](std::size_t cell) { ++begins_[cell + 1]; });
    }
    for (std::size_t c = 1; c < begins_.size(); ++c) begins_[c] += begins_[c - 1];
    entries_.resize(begins_.back());
    std::vector<std::size_t> at(begins_.begin(), begins_.end() - 1);
    for (std::uint32_t k = 0; k < boxes_.size(); ++k) {
      ForEachCell(boxes_[k], [&](std::size_t cell) { entries_[at[cell]++] = k; });
    }
  }

  /// Boxes that share several cells are a pair of the first one that both reach into.
  void AddPair(std::size_t cell, std::uint32_t i, std::uint32_t j,
               std::vector<Pair>& pairs) const {
    const FlatBox& a = boxes_[i];
    const FlatBox& b = boxes_[j];
    const Vec2 min = a.min_mm.cwiseMax(b.min_mm);
    const Vec2 max = a.max_mm.cwiseMin(b.max_mm);
    if (min.x() > max.x() + margin_ || min.y() > max.y() + margin_) return;
    if (Row(min.y()) * columns_ + Column(min.x()) != cell) return;
    pairs.push_back({i, j});
  }

  std::span<const FlatBox> boxes_;
  double margin_;
  Vec2 origin_;
  double cell_ = 1;
  std::size_t columns_ = 0;
  std::size_t rows_ = 0;
  std::vector<std::size_t> begins_;
  std::vector<std::uint32_t> entries_;
};

}  // namespace

std::vector<Pair> NearPairs(std::span<const FlatBox> boxes, double margin_mm) {
  if (boxes.size() < 2) return {};
  return BoxGrid(boxes, margin_mm).Pairs(UINT64_MAX);
}

Result<std::vector<Pair>> NearPairsUpTo(std::span<const FlatBox> boxes, double margin_mm,
                                        std::uint64_t max_pairs) {
  if (boxes.size() < 2) return std::vector<Pair>();
  std::vector<Pair> pairs = BoxGrid(boxes, margin_mm).Pairs(max_pairs);
  if (pairs.size() <= max_pairs) return pairs;
  return Fail(
      ErrorCode::kTooLarge,
      fmt::format("of {} edges and elements more than {} pairs lie side by side; thin "
                  "out the outline, or divide the drawing",
                  boxes.size(), max_pairs),
      fmt::format("{}", max_pairs));
}

}  // namespace intaglio::contour
