#include "engrave/discretize/several.h"

#include <algorithm>
#include <utility>

namespace intaglio::discretize {
namespace {

class Shifted final : public PointSource {
 public:
  Shifted(std::shared_ptr<const PointSource> source, const Vec3& offset_mm)
      : source_(std::move(source)), offset_mm_(offset_mm) {}

  Box3 Bounds() const override {
    Box3 bounds = source_->Bounds();
    bounds.min_mm += offset_mm_;
    bounds.max_mm += offset_mm_;
    return bounds;
  }
  double MaxSpacing() const override { return source_->MaxSpacing(); }

  Result<MethodStatistics> AddPoints(const HeightRange& range, std::uint32_t source,
                                     const ProgressSink& progress,
                                     SpacedCloud& cloud) const override {
    const std::size_t first = cloud.size();
    auto statistics = source_->AddPoints(
        {range.low_mm - offset_mm_.z(), range.high_mm - offset_mm_.z()}, source, progress,
        cloud);
    for (std::size_t i = first; i < cloud.size(); ++i) cloud.points_mm[i] += offset_mm_;
    return statistics;
  }

 private:
  std::shared_ptr<const PointSource> source_;
  Vec3 offset_mm_;
};

class Several final : public PointSource {
 public:
  explicit Several(std::vector<std::unique_ptr<PointSource>> sources)
      : sources_(std::move(sources)) {
    for (const auto& source : sources_) {
      max_spacing_mm_ = std::max(max_spacing_mm_, source->MaxSpacing());
      bounds_.Extend(source->Bounds());
    }
  }

  Box3 Bounds() const override { return bounds_; }
  double MaxSpacing() const override { return max_spacing_mm_; }

  Result<MethodStatistics> AddPoints(const HeightRange& range, std::uint32_t source,
                                     const ProgressSink& progress,
                                     SpacedCloud& cloud) const override {
    MethodStatistics all;
    for (const auto& one : sources_) {
      const auto statistics = one->AddPoints(range, source, progress, cloud);
      if (!statistics) return statistics;
      all.Add(*statistics);
    }
    return all;
  }

 private:
  std::vector<std::unique_ptr<PointSource>> sources_;
  Box3 bounds_;
  double max_spacing_mm_ = 0;
};

}  // namespace

std::unique_ptr<PointSource> MakeShifted(std::shared_ptr<const PointSource> source,
                                         const Vec3& offset_mm) {
  return std::make_unique<Shifted>(std::move(source), offset_mm);
}

std::unique_ptr<PointSource> MakeSeveral(
    std::vector<std::unique_ptr<PointSource>> sources) {
  return std::make_unique<Several>(std::move(sources));
}

PointList GridOffsets(const Eigen::Vector3i& count, const Vec3& step_mm, bool centred) {
  const Vec3 middle =
      centred ? Vec3(0.5 * (count.cast<double>() - Vec3::Ones())) : Vec3(Vec3::Zero());
  PointList offsets_mm;
  for (int z = 0; z < count.z(); ++z) {
    for (int y = 0; y < count.y(); ++y) {
      for (int x = 0; x < count.x(); ++x) {
        offsets_mm.push_back((Vec3(x, y, z) - middle).cwiseProduct(step_mm));
      }
    }
  }
  return offsets_mm;
}

}  // namespace intaglio::discretize
