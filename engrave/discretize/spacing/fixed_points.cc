#include "engrave/discretize/spacing/fixed_points.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "engrave/core/check.h"

namespace intaglio::discretize {
namespace {

class FixedPoints final : public PointSource {
 public:
  FixedPoints(SpacedCloud points, const MethodStatistics& statistics, const Vec3& rise)
      : rise_(rise), statistics_(statistics) {
    std::vector<std::uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return rise_.dot(points.points_mm[a]) < rise_.dot(points.points_mm[b]);
    });
    points_mm_.reserve(order.size());
    spacing_mm_.reserve(order.size());
    for (const std::uint32_t i : order) {
      const Vec3& p = points.points_mm[i];
      Require(p.allFinite(), "a point is not finite: {} {} {}", p.x(), p.y(), p.z());
      points_mm_.push_back(p);
      spacing_mm_.push_back(points.spacing_mm[i]);
      bounds_.Extend(p);
      max_spacing_mm_ =
          std::max(max_spacing_mm_, static_cast<double>(points.spacing_mm[i]));
    }
  }

  Box3 Bounds() const override { return bounds_; }
  Vec3 Rise() const override { return rise_; }
  double MaxSpacing() const override { return max_spacing_mm_; }

  Result<MethodStatistics> AddPoints(const HeightRange& range, std::uint32_t source,
                                     const ProgressSink&,
                                     SpacedCloud& cloud) const override {
    const std::size_t begin = FirstFrom(range.low_mm), end = FirstFrom(range.high_mm);
    for (std::size_t i = begin; i < end; ++i) {
      cloud.Add(points_mm_[i], source, spacing_mm_[i]);
    }
    MethodStatistics statistics;
    if (!points_mm_.empty() && range.Contains(rise_.dot(points_mm_.front()))) {
      statistics = statistics_;
    }
    statistics.point_count = begin < end ? end - begin : 0;
    return statistics;
  }

 private:
  std::size_t FirstFrom(double height_mm) const {
    const auto at =
        std::partition_point(points_mm_.begin(), points_mm_.end(),
                             [&](const Vec3& p) { return rise_.dot(p) < height_mm; });
    return static_cast<std::size_t>(at - points_mm_.begin());
  }

  Vec3 rise_;
  PointList points_mm_;  // from the lowest up
  std::vector<float> spacing_mm_;
  Box3 bounds_;
  double max_spacing_mm_ = 0;
  MethodStatistics statistics_;
};

}  // namespace

std::unique_ptr<PointSource> MakeFixedPoints(SpacedCloud points,
                                             const MethodStatistics& statistics,
                                             const Vec3& rise) {
  return std::make_unique<FixedPoints>(std::move(points), statistics, rise);
}

}  // namespace intaglio::discretize
