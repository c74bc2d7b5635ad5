#include "engrave/discretize/slabs.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::discretize {
namespace {

// A seam is made twice and a front of points ends at each: with this many of its
// thicknesses between two of them, that is one layer in thirty.
constexpr double kSeamsPerSlab = 32;
// A lead, and the seam it belongs to, cost six times as much.
constexpr double kSeamsPerSlabWithLead = 64;
// Enough for every machine, and few enough that the cost of cutting is negligible.
constexpr double kMaxSlabs = 256;
// Factor on the reach: two points this far apart in height are never too near, whatever
// rounding did to them.
constexpr double kSeamAllowance = 1 + 1e-6;

}  // namespace

Slabs::Slabs(const HeightRange& heights, double reach_mm, double lead_mm)
    : reach_mm_(reach_mm * kSeamAllowance),
      lead_mm_(lead_mm),
      seam_mm_(lead_mm > 0 ? 2 * reach_mm_ : reach_mm_) {
  Require(reach_mm > 0 && std::isfinite(reach_mm), "reach_mm must be positive, is {}",
          reach_mm);
  const double seams = lead_mm > 0 ? kSeamsPerSlabWithLead : kSeamsPerSlab;
  Require(lead_mm >= 0 && lead_mm < kSeamsPerSlab * reach_mm,
          "lead_mm must be from 0 to {}, is {}", kSeamsPerSlab * reach_mm, lead_mm);
  if (!(heights.low_mm <= heights.high_mm)) return;
  const double low_mm = heights.low_mm, height_mm = heights.high_mm - heights.low_mm;
  const double fitting = std::floor(height_mm / (seams * reach_mm_));
  const auto slabs = static_cast<std::size_t>(std::clamp(fitting, 1.0, kMaxSlabs));
  for (std::size_t k = 1; k < slabs; ++k) {
    heights_mm_.push_back(low_mm + height_mm * static_cast<double>(k) /
                                       static_cast<double>(slabs));
  }
}

HeightRange Slabs::Whole(std::size_t slab) const {
  HeightRange range;
  if (slab > 0) range.low_mm = heights_mm_.at(slab - 1);
  if (slab < heights_mm_.size()) range.high_mm = heights_mm_[slab];
  return range;
}

HeightRange Slabs::Lead(std::size_t slab) const {
  if (slab == 0) return {0, 0};
  return {heights_mm_.at(slab - 1) - lead_mm_, heights_mm_[slab - 1]};
}

HeightRange Slabs::Seam(std::size_t slab) const {
  if (slab == 0) return {0, 0};
  return {heights_mm_.at(slab - 1), heights_mm_[slab - 1] + seam_mm_};
}

HeightRange Slabs::Between(std::size_t slab) const {
  HeightRange range = Whole(slab);
  if (slab > 0) range.low_mm += seam_mm_;
  return range;
}

HeightRange Slabs::Filling(std::size_t slab) const {
  if (slab + 1 >= count() || lead_mm_ == 0) return {0, 0};
  return {heights_mm_[slab], heights_mm_[slab] + reach_mm_};
}

}  // namespace intaglio::discretize
