#include "engrave/discretize/spacing/thinning_front.h"

#include <algorithm>
#include <cmath>

namespace intaglio::discretize {
namespace {

constexpr std::size_t kMaxLevels = 24;

}  // namespace

OwnSpacings::OwnSpacings(const SourceExtent& extent, double min_spacing_mm,
                         const Vec3& rise)
    : max_spacing_mm_(extent.max_spacing_mm) {
  const double min_mm =
      std::max(min_spacing_mm, static_cast<double>(extent.min_spacing_mm));
  double reach_mm = max_spacing_mm_;
  do {
    levels_.push_back(
        {reach_mm, reach_mm, Columns(extent.bounds, reach_mm, 1, extent.count, rise)});
    reach_mm /= 2;
  } while (reach_mm >= min_mm && levels_.size() < kMaxLevels);
}

std::size_t OwnSpacings::LevelOf(double spacing_mm) const {
  const std::size_t last = levels_.size() - 1;
  if (last == 0 || !(spacing_mm > 0)) return last;
  // Its integer part's binary logarithm: the level's reach is at least the spacing,
  // except for the rounding of the quotient, which kReachAllowance covers.
  const int level = std::ilogb(max_spacing_mm_ / spacing_mm);
  return std::min(last, static_cast<std::size_t>(std::max(0, level)));
}

std::size_t OwnSpacings::KeepFar(std::span<ThinningPoint> points) const {
  if (levels_.size() == 1) return KeepFar(points, levels_[0]);
  std::size_t kept = 0;
  for (const ThinningPoint& point : points) {
    const std::span one(&(points[kept] = point), 1);
    // Its own level decides most often.
    const Level& own = levels_[LevelOf(point.spacing_mm)];
    if (KeepFar(one, own) == 0) continue;
    kept += std::all_of(levels_.begin(), levels_.end(), [&](const Level& level) {
      return &level == &own || KeepFar(one, level) == 1;
    });
  }
  return kept;
}

std::size_t OwnSpacings::KeepFar(std::span<ThinningPoint> points,
                                 const Level& level) const {
  if (level.columns.empty()) return points.size();
  return level.columns.KeepFar(
      points, {level.min_mm, level.reach_mm, true},
      [&](const ThinningPoint& point, Columns::Hasty hasty) {
        const double own_mm = point.spacing_mm;
        const double reach_mm = std::max(own_mm, level.reach_mm);
        if (hasty == Columns::Hasty::kFar && reach_mm <= level.reach_mm) return false;
        const Vec3& p = point.p_mm;
        const double wide_mm = reach_mm * kReachAllowance;
        return level.columns.Any(
            p, wide_mm, wide_mm, [&](const Vec3& q, double spacing_mm) {
              const double dx = p.x() - q.x(), dy = p.y() - q.y(), dz = p.z() - q.z();
              const double s = std::max(own_mm, spacing_mm);
              return dx * dx + dy * dy + dz * dz < s * s;
            });
      });
}

ThinningFront::ThinningFront(const ThinningOptions& options, const Box3& bounds,
                             std::size_t point_count, const SourceExtents& extents)
    : height_ratio_(options.height_ratio),
      min_square_(options.min_spacing_mm * options.min_spacing_mm),
      min_mm_(options.min_spacing_mm),
      surely_near_(min_square_),
      surely_far_(min_square_),
      reach_mm_(options.min_spacing_mm * kReachAllowance),
      columns_(bounds, options.min_spacing_mm, options.height_ratio, point_count,
               options.rise) {
  if (height_ratio_ != 1) {
    surely_near_ *= 1 - 1e-12;
    surely_far_ *= 1 + 1e-12;
  }
  for (const auto& [source, extent] : extents) {
    // A spacing not above that of the block needs no second check.
    if (extent.max_spacing_mm <= options.min_spacing_mm) continue;
    own_.try_emplace(source, extent, options.min_spacing_mm, options.rise);
    own_is_enough_ = extents.size() == 1 && height_ratio_ == 1 &&
                     extent.min_spacing_mm >= options.min_spacing_mm;
  }
}

void ThinningFront::Add(const ThinningPoint& point) {
  if (!own_is_enough_) columns_.Add(point.p_mm, point.spacing_mm);
  if (OwnSpacings* own = OwnOf(point.source)) own->Add(point);
}

std::size_t ThinningFront::KeepFar(std::span<ThinningPoint> points) {
  if (own_.empty()) return KeepFarFromAll(points);
  // The wider of both rules first: it decides more often.
  std::size_t kept = 0;
  for (std::size_t begin = 0, end = 0; begin < points.size(); begin = end) {
    const std::uint32_t source = points[begin].source;
    while (end < points.size() && points[end].source == source) ++end;
    const OwnSpacings* own = OwnOf(source);
    const std::span run = points.subspan(begin, end - begin);
    const std::size_t far = own == nullptr ? run.size() : own->KeepFar(run);
    if (kept < begin) std::copy_n(run.begin(), far, &points[kept]);
    kept += far;
  }
  return KeepFarFromAll(points.first(kept));
}

std::size_t ThinningFront::KeepFarFromAll(std::span<ThinningPoint> points) const {
  if (columns_.empty()) return points.size();
  const double flatten = 1 / height_ratio_;
  const double reach_z_mm = reach_mm_ * height_ratio_;
  return columns_.KeepFar(
      points, {min_mm_, reach_mm_, false},
      [&](const ThinningPoint& point, Columns::Hasty hasty) {
        if (hasty == Columns::Hasty::kFar) return false;
        const Vec3& p = point.p_mm;
        return columns_.Any(p, reach_mm_, reach_z_mm, [&](const Vec3& q, double) {
          const double dx = p.x() - q.x(), dy = p.y() - q.y(), dz = p.z() - q.z();
          const double across = dx * dx + dy * dy, hasty_dz = dz * flatten;
          const double square = across + hasty_dz * hasty_dz;
          if (square < surely_near_) return true;
          if (square >= surely_far_) return false;
          const double flat = dz / height_ratio_;
          return across + flat * flat < min_square_;
        });
      });
}

bool ThinningFront::AreTooNear(const ThinningPoint& p, const ThinningPoint& q) const {
  const Vec3 d = p.p_mm - q.p_mm;
  const double across = d.x() * d.x() + d.y() * d.y();
  const double flat = height_ratio_ == 1 ? d.z() : d.z() / height_ratio_;
  if (across + flat * flat < min_square_) return true;
  if (p.source != q.source) return false;
  const double s = std::max(p.spacing_mm, q.spacing_mm);
  return across + d.z() * d.z() < s * s;
}

OwnSpacings* ThinningFront::OwnOf(std::uint32_t source) {
  if (own_.empty()) return nullptr;
  if (source != last_source_ || last_own_ == nullptr) {
    const auto at = own_.find(source);
    last_own_ = at == own_.end() ? nullptr : &at->second;
    last_source_ = source;
  }
  return last_own_;
}

}  // namespace intaglio::discretize
