#include "engrave/sort/beam/precedence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "engrave/core/check.h"

// A pair (p, e) is left out where some q is known with (p, q) kept and (q, e) a pair: it
// is kept itself or follows from kept ones, by induction over the height.

namespace intaglio::sort {
namespace {

bool IsPair(const Vec3& below, const Vec3& above, const BeamCone& cone) {
  return cone.Shades(below, above);
}

/// Points sorted by x, so that only those near in x are checked.
class AlongX {
 public:
  explicit AlongX(std::span<const Vec3> points_mm)
      : points_mm_(points_mm), sorted_(points_mm.size()), rank_(points_mm.size()) {
    std::iota(sorted_.begin(), sorted_.end(), 0U);
    std::sort(sorted_.begin(), sorted_.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(points_mm[a].x(), a) < std::pair(points_mm[b].x(), b);
    });
    for (std::uint32_t i = 0; i < sorted_.size(); ++i) rank_[sorted_[i]] = i;
  }

  template <typename Visit>
  void Within(std::uint32_t point, double reach_mm, const Visit& visit) const {
    const double x = points_mm_[point].x();
    for (std::size_t i = rank_[point] + 1; i < sorted_.size(); ++i) {
      if (points_mm_[sorted_[i]].x() - x > reach_mm) break;
      visit(sorted_[i]);
    }
    for (std::size_t i = rank_[point]; i-- > 0;) {
      if (x - points_mm_[sorted_[i]].x() > reach_mm) break;
      visit(sorted_[i]);
    }
  }

 private:
  std::span<const Vec3> points_mm_;
  std::vector<std::uint32_t> sorted_, rank_;
};

}  // namespace

Precedence::Precedence(std::span<const Vec3> points_mm, const BeamCone& cone)
    : after_begin_(points_mm.size() + 1), before_begin_(points_mm.size() + 1) {
  RequireUsable(cone);
  const AlongX along_x(points_mm);
  double top_mm = -std::numeric_limits<double>::infinity();
  for (const Vec3& p : points_mm) top_mm = std::max(top_mm, p.z());
  std::vector<std::uint32_t> above;
  for (std::uint32_t p = 0; p < points_mm.size(); ++p) {
    above.clear();
    const double up_mm = std::max(top_mm - points_mm[p].z(), 0.0);
    const double leaning_mm = std::abs(cone.LeanAt(points_mm[p]).x()) * up_mm;
    along_x.Within(p, cone.ReachMm(up_mm) + leaning_mm, [&](std::uint32_t e) {
      if (IsPair(points_mm[p], points_mm[e], cone)) above.push_back(e);
    });
    std::sort(above.begin(), above.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(points_mm[a].z(), a) < std::pair(points_mm[b].z(), b);
    });
    const auto begin = static_cast<std::ptrdiff_t>(after_.size());
    for (const std::uint32_t e : above) {
      const bool follows = std::any_of(
          after_.begin() + begin, after_.end(),
          [&](std::uint32_t q) { return IsPair(points_mm[q], points_mm[e], cone); });
      if (follows) continue;
      after_.push_back(e);
      ++before_begin_[e + 1];
    }
    after_begin_[p + 1] = static_cast<std::uint32_t>(after_.size());
  }
  std::partial_sum(before_begin_.begin(), before_begin_.end(), before_begin_.begin());
  before_.resize(after_.size());
  std::vector<std::uint32_t> next(before_begin_.begin(), before_begin_.end() - 1);
  for (std::uint32_t p = 0; p < points_mm.size(); ++p) {
    for (const std::uint32_t e : After(p)) before_[next[e]++] = p;
  }
}

}  // namespace intaglio::sort
