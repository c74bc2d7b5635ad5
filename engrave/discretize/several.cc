#include "engrave/discretize/several.h"

#include <algorithm>
#include <utility>

#include "engrave/core/check.h"

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
  Vec3 Rise() const override { return source_->Rise(); }
  HeightRange Heights() const override {
    const HeightRange heights = source_->Heights();
    return {heights.low_mm + Offset(), heights.high_mm + Offset()};
  }

  Result<MethodStatistics> AddPoints(const HeightRange& range, std::uint32_t source,
                                     const ProgressSink& progress,
                                     SpacedCloud& cloud) const override {
    const std::size_t first = cloud.size();
    auto statistics = source_->AddPoints(
        {range.low_mm - Offset(), range.high_mm - Offset()}, source, progress, cloud);
    for (std::size_t i = first; i < cloud.size(); ++i) cloud.points_mm[i] += offset_mm_;
    return statistics;
  }

 private:
  double Offset() const { return Rise().dot(offset_mm_); }

  std::shared_ptr<const PointSource> source_;
  Vec3 offset_mm_;
};

class Several final : public PointSource {
 public:
  explicit Several(std::vector<std::unique_ptr<PointSource>> sources)
      : sources_(std::move(sources)) {
    for (const auto& source : sources_) {
      Require(source->Rise() == Rise(), "models that count as one rise differently");
      max_spacing_mm_ = std::max(max_spacing_mm_, source->MaxSpacing());
      bounds_.Extend(source->Bounds());
    }
  }

  Box3 Bounds() const override { return bounds_; }
  double MaxSpacing() const override { return max_spacing_mm_; }
  Vec3 Rise() const override {
    return sources_.empty() ? kUpward : sources_.front()->Rise();
  }
  HeightRange Heights() const override {
    HeightRange all = HeightsOf({}, Rise());
    for (const auto& source : sources_) {
      const HeightRange heights = source->Heights();
      all = {std::min(all.low_mm, heights.low_mm),
             std::max(all.high_mm, heights.high_mm)};
    }
    return all;
  }

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
