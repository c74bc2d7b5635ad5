#include "engrave/discretize/mesh/fill.h"

#include <utility>

#include "engrave/core/check.h"
#include "engrave/discretize/mesh/surface_grid.h"

// Steps of a quarter of the distance: see even.cc for the results of finer and coarser
// ones.

namespace intaglio::discretize {
namespace {

constexpr double kStepsPerDistance = 4;

class FillSource final : public PointSource {
 public:
  FillSource(mesh::TriangleMesh mesh, const FillOptions& options)
      : mesh_(std::move(mesh)),
        spacing_mm_(UpwardSingle(options.vertex_distance_mm)),
        grid_(mesh_, {spacing_mm_ / kStepsPerDistance * kRoundingAllowance,
                      options.full_fill, options.full_fill}) {}

  Box3 Bounds() const override { return grid_.bounds(); }
  double MaxSpacing() const override { return spacing_mm_; }

  Result<MethodStatistics> AddPoints(const HeightRange& range, std::uint32_t source,
                                     const ProgressSink& progress,
                                     SpacedCloud& cloud) const override {
    return grid_.ForEach(range, progress, [&](const SurfacePoint& point) {
      cloud.Add(point.p_mm, source, spacing_mm_);
    });
  }

 private:
  mesh::TriangleMesh mesh_;
  float spacing_mm_;
  SurfaceGrid grid_;
};

}  // namespace

Result<std::unique_ptr<PointSource>> MakeFill(mesh::TriangleMesh mesh,
                                              const FillOptions& options) {
  Require(options.vertex_distance_mm > 0, "vertex_distance_mm must be positive, is {}",
          options.vertex_distance_mm);
  return std::make_unique<FillSource>(std::move(mesh), options);
}

}  // namespace intaglio::discretize
