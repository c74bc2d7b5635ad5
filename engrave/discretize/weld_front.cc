#include "engrave/discretize/weld_front.h"

#include <algorithm>
#include <cmath>

namespace intaglio::discretize {
namespace {

// Two points nearer than a reach differ by less than a column's width even after the
// rounding of their column numbers.
constexpr double kReachAllowance = 1 + 1e-9;
// So that a tiny spacing in a large block takes no memory, nor the time to clear it, that
// the points do not justify.
constexpr double kColumnsPerPoint = 1, kLeastColumns = 1024;
// A coordinate's last place in single precision, 2^-24, times: two points, three axes,
// the squares and their sums.
constexpr double kSingleError = 16 * 0x1p-24;
constexpr std::size_t kMaxLevels = 24;

double SideOf(const Vec3& size_mm, double reach_mm, std::size_t point_count) {
  const double most =
      std::max(kLeastColumns, kColumnsPerPoint * static_cast<double>(point_count));
  double side_mm = reach_mm * kReachAllowance;
  while ((size_mm.x() / side_mm + 3) * (size_mm.y() / side_mm + 3) > most) {
    side_mm *= 1.25;
  }
  return side_mm;
}

}  // namespace

Columns::Columns(const Box3& bounds, double reach_mm, double height_ratio,
                 std::size_t point_count)
    : origin_(bounds.min_mm),
      scale_(1, 1, 1 / height_ratio),
      error_mm_(kSingleError * (bounds.size_mm().maxCoeff() + reach_mm)),
      side_mm_(SideOf(bounds.size_mm(), reach_mm, point_count)),
      per_side_(1 / side_mm_),
      width_(static_cast<std::size_t>(bounds.size_mm().x() * per_side_) + 3),
      depth_(static_cast<std::size_t>(bounds.size_mm().y() * per_side_) + 3),
      newest_(width_ * depth_) {}

void Columns::Add(const Vec3& p_mm, float spacing_mm) {
  Newest& newest = newest_[ColumnOf(p_mm)];
  entries_.push_back({p_mm, newest.entry, spacing_mm});
  newest.entry = static_cast<std::uint32_t>(entries_.size() - 1);
  const Vec3 q = (p_mm - origin_).cwiseProduct(scale_);
  const std::uint32_t lane = newest.next_lane;
  newest.x[lane] = static_cast<float>(q.x());
  newest.y[lane] = static_cast<float>(q.y());
  newest.z[lane] = static_cast<float>(q.z());
  newest.next_lane = (lane + 1) % 4;
}

OwnSpacings::OwnSpacings(const SourceExtent& extent, double min_spacing_mm)
    : max_spacing_mm_(extent.max_spacing_mm) {
  const double least_mm =
      std::max(min_spacing_mm, static_cast<double>(extent.min_spacing_mm));
  double reach_mm = max_spacing_mm_;
  do {
    levels_.push_back(
        {reach_mm, reach_mm, Columns(extent.bounds, reach_mm, 1, extent.count)});
    reach_mm /= 2;
  } while (reach_mm >= least_mm && levels_.size() < kMaxLevels);
}

std::size_t OwnSpacings::LevelOf(double spacing_mm) const {
  const std::size_t last = levels_.size() - 1;
  if (last == 0 || !(spacing_mm > 0)) return last;
  // Its integer part's binary logarithm: the level's reach is at least the spacing, but
  // for the rounding of the quotient, which kReachAllowance holds.
  const int level = std::ilogb(max_spacing_mm_ / spacing_mm);
  return std::min(last, static_cast<std::size_t>(std::max(0, level)));
}

bool OwnSpacings::IsTooNear(const WeldPoint& point) const {
  const std::size_t own = LevelOf(point.spacing_mm);
  if (IsTooNear(point, levels_[own])) return true;
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    if (level != own && IsTooNear(point, levels_[level])) return true;
  }
  return false;
}

bool OwnSpacings::IsTooNear(const WeldPoint& point, const Level& level) const {
  if (level.columns.empty()) return false;
  const double own_mm = point.spacing_mm;
  const Vec3& p = point.p_mm;
  const double reach_mm = std::max(own_mm, level.reach_mm);
  const Columns::Hasty hasty =
      level.columns.Look(p, std::max(own_mm, level.least_mm), reach_mm);
  if (hasty == Columns::Hasty::kNear) return true;
  if (hasty == Columns::Hasty::kFar && reach_mm <= level.reach_mm) return false;
  const double wide_mm = reach_mm * kReachAllowance;
  return level.columns.Any(p, wide_mm, wide_mm, [&](const Vec3& q, double spacing_mm) {
    const double dx = p.x() - q.x(), dy = p.y() - q.y(), dz = p.z() - q.z();
    const double s = std::max(own_mm, spacing_mm);
    return dx * dx + dy * dy + dz * dz < s * s;
  });
}

WeldFront::WeldFront(const WeldOptions& options, const Box3& bounds,
                     std::size_t point_count, const SourceExtents& extents)
    : height_ratio_(options.height_ratio),
      least_square_(options.min_spacing_mm * options.min_spacing_mm),
      least_mm_(options.min_spacing_mm),
      surely_near_(least_square_),
      surely_far_(least_square_),
      reach_mm_(options.min_spacing_mm * kReachAllowance),
      columns_(bounds, options.min_spacing_mm, options.height_ratio, point_count) {
  if (height_ratio_ != 1) {
    surely_near_ *= 1 - 1e-12;
    surely_far_ *= 1 + 1e-12;
  }
  for (const auto& [source, extent] : extents) {
    // A spacing that the block asks for anyway needs no second look.
    if (extent.max_spacing_mm <= options.min_spacing_mm) continue;
    own_.try_emplace(source, extent, options.min_spacing_mm);
    own_is_enough_ = extents.size() == 1 && height_ratio_ == 1 &&
                     extent.min_spacing_mm >= options.min_spacing_mm;
  }
}

void WeldFront::Add(const WeldPoint& point) {
  if (!own_is_enough_) columns_.Add(point.p_mm, point.spacing_mm);
  if (OwnSpacings* own = OwnOf(point.source)) own->Add(point);
}

bool WeldFront::IsTooNear(const WeldPoint& point) {
  // The wider of both rules first: it answers more often.
  const OwnSpacings* own = OwnOf(point.source);
  return (own != nullptr && own->IsTooNear(point)) || IsTooNearToAny(point.p_mm);
}

bool WeldFront::IsTooNearToAny(const Vec3& p) const {
  if (columns_.empty()) return false;
  const Columns::Hasty look = columns_.Look(p, least_mm_, reach_mm_);
  if (look != Columns::Hasty::kUnsure) return look == Columns::Hasty::kNear;
  const double flatten = 1 / height_ratio_;
  const double reach_z_mm = reach_mm_ * height_ratio_;
  return columns_.Any(p, reach_mm_, reach_z_mm, [&](const Vec3& q, double) {
    const double dx = p.x() - q.x(), dy = p.y() - q.y(), dz = p.z() - q.z();
    const double across = dx * dx + dy * dy, hasty = dz * flatten;
    const double square = across + hasty * hasty;
    if (square < surely_near_) return true;
    if (square >= surely_far_) return false;
    const double flat = dz / height_ratio_;
    return across + flat * flat < least_square_;
  });
}

OwnSpacings* WeldFront::OwnOf(std::uint32_t source) {
  if (own_.empty()) return nullptr;
  if (source != last_source_ || last_own_ == nullptr) {
    const auto at = own_.find(source);
    last_own_ = at == own_.end() ? nullptr : &at->second;
    last_source_ = source;
  }
  return last_own_;
}

}  // namespace intaglio::discretize
