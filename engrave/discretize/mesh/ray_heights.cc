#include "engrave/discretize/mesh/ray_heights.h"

namespace intaglio::discretize {

std::uint32_t RayHeights::Receive(std::span<const RaySpan> spans) {
  // Crossings of each column, from their differences.
  std::fill(end_of_.begin(), end_of_.end(), 0U);
  auto first = static_cast<std::uint32_t>(end_of_.size() - 1);
  std::uint32_t last = 0;
  for (const RaySpan& span : spans) {
    ++end_of_[span.begin];
    --end_of_[span.end];
    first = std::min(first, span.begin);
    last = std::max(last, span.end);
  }
  first_ = first;
  last_ = last;
  std::uint32_t count = 0, total = 0;
  for (std::uint32_t column = first; column < last; ++column) {
    count += end_of_[column];
    end_of_[column] = total;
    total += count;
  }
  if (heights_.size() < total) heights_.resize(total);
  for (const RaySpan& span : spans) {
    double w_mm = span.w_mm;
    for (std::uint32_t column = span.begin; column < span.end; ++column) {
      heights_[end_of_[column]++] = w_mm;
      w_mm += span.step_w_mm;
    }
  }
  return total;
}

}  // namespace intaglio::discretize
