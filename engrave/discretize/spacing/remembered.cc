#include "engrave/discretize/spacing/remembered.h"

#include <mutex>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/discretize/spacing/fixed_points.h"

namespace intaglio::discretize {
namespace {

class Remembered final : public PointSource {
 public:
  Remembered(const PointSource& source, const Vec3& rise)
      : source_(source), rise_(rise) {}

  Box3 Bounds() const override { return source_.Bounds(); }
  Vec3 Rise() const override { return rise_; }
  double MaxSpacing() const override { return source_.MaxSpacing(); }

  Result<MethodStatistics> AddPoints(const HeightRange& range, std::uint32_t source,
                                     const ProgressSink& progress,
                                     SpacedCloud& cloud) const override {
    std::call_once(once_, [&] { points_ = All(progress); });
    if (!points_) return tl::unexpected(points_.error());
    return (*points_)->AddPoints(range, source, progress, cloud);
  }

 private:
  Result<std::unique_ptr<PointSource>> All(const ProgressSink& progress) const {
    SpacedCloud points;
    const auto statistics = INTAGLIO_TRY(source_.AddPoints({}, 0, progress, points));
    return MakeFixedPoints(std::move(points), statistics, rise_);
  }

  const PointSource& source_;
  Vec3 rise_;
  mutable std::once_flag once_;
  mutable Result<std::unique_ptr<PointSource>> points_;
};

}  // namespace

std::unique_ptr<PointSource> MakeRemembered(const PointSource& source, const Vec3& rise) {
  return std::make_unique<Remembered>(source, rise);
}

}  // namespace intaglio::discretize
