#include "engrave/sort/slabs.h"

#include <fmt/format.h>

#include <algorithm>

#include "engrave/core/check.h"

namespace intaglio::sort {
namespace {

constexpr double kMinThicknessMm = 0.01;
constexpr double kMaxThicknessMm = 100;

// Layers at multiples of the thickness lie on the slabs' limits, where rounding could put
// one layer in two slabs; so the limits are this share of the thickness lower.
constexpr double kLimitShare = 1e-6;

}  // namespace

Status CheckThickness(std::string_view field, double thickness_mm) {
  if (thickness_mm >= kMinThicknessMm && thickness_mm <= kMaxThicknessMm) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("{}: {} is outside {}..{}", field, thickness_mm,
                          kMinThicknessMm, kMaxThicknessMm),
              fmt::format("{}", thickness_mm));
}

std::vector<std::uint64_t> SlabNumbers(const PointList& points_mm, int axis,
                                       double thickness_mm) {
  Require(!points_mm.empty(), "there is no point");
  double min_mm = points_mm.front()[axis];
  for (const Vec3& p : points_mm) min_mm = std::min(min_mm, p[axis]);
  std::vector<std::uint64_t> slabs;
  slabs.reserve(points_mm.size());
  for (const Vec3& p : points_mm) {
    slabs.push_back(
        static_cast<std::uint64_t>((p[axis] - min_mm) / thickness_mm + kLimitShare));
  }
  return slabs;
}

}  // namespace intaglio::sort
