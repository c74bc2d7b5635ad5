#include "engrave/discretize/mesh/sections.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/discretize/mesh/contour_tracer.h"
#include "engrave/discretize/mesh/flat_faces.h"
#include "engrave/discretize/spacing/candidate_limit.h"
#include "engrave/discretize/spacing/contour_points.h"
#include "engrave/discretize/spacing/fixed_points.h"
#include "engrave/mesh/edge_neighbours.h"
#include "engrave/mesh/height_order.h"

namespace intaglio::discretize {
namespace {

Result<PlaneStack> StackOver(double low_mm, double high_mm,
                             const SectionOptions& options) {
  PlaneStack planes;
  planes.pitch_mm = options.layer_distance_mm * kRoundingAllowance;
  const double inset_mm = options.first_last_distance_ratio * options.layer_distance_mm;
  const double first_mm = low_mm + inset_mm, last_mm = high_mm - inset_mm;
  double count = 0;
  if (options.reference == SectionReference::kWorld) {
    planes.first_step = std::ceil(first_mm / planes.pitch_mm);
    count = std::floor(last_mm / planes.pitch_mm) - planes.first_step + 1;
  } else if (last_mm < first_mm) {
    planes.origin_mm = 0.5 * (low_mm + high_mm);
    count = 1;
  } else {
    planes.origin_mm = first_mm;
    // Rounding of the division must not lose the last plane that fits.
    count = std::floor((last_mm - first_mm) / options.layer_distance_mm + 1e-9) + 1;
    // What is left over is shared by all layers, so that the last plane is as far from
    // its end as the first one from its own.
    if (count > 1) {
      planes.pitch_mm = std::max(planes.pitch_mm, (last_mm - first_mm) / (count - 1));
    }
  }
  INTAGLIO_TRY(CheckCandidateCount(count));
  planes.count = static_cast<std::uint32_t>(std::max(count, 0.0));
  return planes;
}

/// A stretch of a contour and the heights that it reaches.
struct Stretch {
  std::size_t contour = 0;
  std::size_t begin = 0, end = 0;  // segments
  double low_mm = 0, high_mm = 0;
};
constexpr std::size_t kStretchSegments = 32;

class Sections final : public PointSource {
 public:
  Sections(const mesh::TriangleMesh& mesh, const SectionOptions& options,
           const PlaneStack& planes, std::vector<std::uint32_t> rank, const Mat3& frame,
           const std::vector<std::uint32_t>& neighbours, const FlatFaces& flat)
      : options_(options),
        planes_(planes),
        level_(frame.col(2) == Vec3::UnitZ()),
        bounds_(mesh.Bounds()),
        wall_area_mm2_(flat.wall_area_mm2),
        tracer_(mesh, std::move(rank), neighbours, frame, planes) {
    statistics_.plane_count = planes.count;
    if (options.parallel_faces != ParallelFaces::kIgnore) {
      statistics_.parallel_area_mm2 = flat.area_mm2;
      statistics_.parallel_face_count = flat.face_count;
    }
  }

  /// To be called first, both.
  Status TraceAslant();
  Status Cover(const FlatFaces& flat, const PointList& vertices, const Mat3& frame);

  Box3 Bounds() const override { return bounds_; }
  Result<MethodStatistics> AddPoints(const HeightRange& range, std::uint32_t source,
                                     const ProgressSink& progress,
                                     SpacedCloud& cloud) const override;

 private:
  Status AddLevel(const HeightRange& range, const ProgressSink& progress,
                  MethodStatistics& statistics, PointList& points) const;
  Status AddAslant(const HeightRange& range, const ProgressSink& progress,
                   MethodStatistics& statistics, PointList& points) const;
  Interval PlanesIn(const HeightRange& range) const;
  ContourSteps StepsOf(const Contours& contours, const Contour& contour) const;

  SectionOptions options_;
  PlaneStack planes_;
  bool level_;
  Box3 bounds_;
  double wall_area_mm2_;
  MethodStatistics statistics_;  // what no single contour has
  ContourTracer tracer_;
  std::unique_ptr<PointSource> cover_;  // of parallel faces; none without any
  // For planes that are not level:
  Contours contours_;
  std::vector<Stretch> stretches_;
};

MeasuredContour PartOf(const Contours& contours, const Contour& contour) {
  const std::size_t count = contour.end - contour.begin;
  return {std::span(contours.points_mm).subspan(contour.begin, count),
          std::span(contours.arc_mm).subspan(contour.begin, count)};
}

void CountContour(const Contour& contour, MethodStatistics& statistics) {
  ++(contour.closed ? statistics.closed_contour_count : statistics.open_contour_count);
}

Status CuttingCancelled() {
  return Fail(ErrorCode::kCancelled, "cutting sections was cancelled");
}

ContourSteps Sections::StepsOf(const Contours& contours, const Contour& contour) const {
  ContourSpacing spacing;
  spacing.distance_mm = options_.vertex_distance_mm;
  spacing.insert_end_points = options_.insert_end_points;
  const double twist = options_.twist_phase_ratio * static_cast<double>(contour.plane);
  spacing.phase_ratio = twist - std::floor(twist);
  return StepsAlong(contours.arc_mm[contour.end - 1], contour.closed, spacing);
}

Status Sections::TraceAslant() {
  if (level_) return {};
  const auto crossings = static_cast<double>(tracer_.crossing_count());
  INTAGLIO_TRY(CheckCandidateCount(crossings));
  tracer_.Trace({0, planes_.count}, contours_, [](std::uint32_t) { return true; });
  for (std::size_t c = 0; c < contours_.list.size(); ++c) {
    const Contour& contour = contours_.list[c];
    const std::size_t segments = contour.end - contour.begin - 1;
    for (std::size_t begin = 0; begin < segments || begin == 0;) {
      const std::size_t end = std::min(segments, begin + kStretchSegments);
      Box3 box;
      for (std::size_t i = begin; i <= end; ++i) {
        box.Extend(contours_.points_mm[contour.begin + i]);
      }
      stretches_.push_back({c, begin, end, box.min_mm.z(), box.max_mm.z()});
      begin = std::max<std::size_t>(end, 1);
    }
  }
  return {};
}

Status Sections::Cover(const FlatFaces& flat, const PointList& vertices,
                       const Mat3& frame) {
  if (options_.parallel_faces != ParallelFaces::kCover || flat.face_count == 0) return {};
  const PointList points =
      INTAGLIO_TRY(CoverFlatFaces(flat, vertices, frame, options_.vertex_distance_mm));
  SpacedCloud cloud;
  for (const Vec3& p : points) cloud.Add(p, 0);
  cover_ = MakeFixedPoints(std::move(cloud));
  return {};
}

Interval Sections::PlanesIn(const HeightRange& range) const {
  // Points of a level plane have its height, exactly.
  const auto first_from = [&](double z_mm) {
    std::uint32_t plane = planes_.RankOf(z_mm);
    return plane > 0 && planes_.HeightOf(plane - 1) == z_mm ? plane - 1 : plane;
  };
  return {first_from(range.low_mm), first_from(range.high_mm)};
}

Status Sections::AddLevel(const HeightRange& range, const ProgressSink& progress,
                          MethodStatistics& statistics, PointList& points) const {
  const Interval planes = PlanesIn(range);
  if (planes.first >= planes.end) return {};
  const double share =
      static_cast<double>(planes.end - planes.first) / static_cast<double>(planes_.count);
  const double expected =
      share * wall_area_mm2_ / (options_.layer_distance_mm * options_.vertex_distance_mm);
  if (expected < static_cast<double>(kMaxCandidates)) {
    const std::size_t needed = points.size() + static_cast<std::size_t>(expected);
    if (needed > points.capacity()) {
      points.reserve(std::max(needed, points.capacity() + points.capacity() / 2));
    }
  }
  Status status;
  Contours contours;
  tracer_.Trace(planes, contours, [&](std::uint32_t plane) {
    if (progress && !progress(plane - planes.first, planes.end - planes.first)) {
      status = CuttingCancelled();
    }
    for (const Contour& contour : contours.list) {
      const ContourSteps steps = StepsOf(contours, contour);
      if (status) {
        status = CheckCandidateCount(static_cast<double>(points.size()) +
                                     static_cast<double>(steps.point_count()));
      }
      if (!status) return false;
      const MeasuredContour part = PartOf(contours, contour);
      AddSteps(part, steps, 0, part.segment_count(), points);
      CountContour(contour, statistics);
    }
    contours.Clear();
    return status.has_value();
  });
  return status;
}

Status Sections::AddAslant(const HeightRange& range, const ProgressSink& progress,
                           MethodStatistics& statistics, PointList& points) const {
  for (std::size_t i = 0; i < stretches_.size(); ++i) {
    const Stretch& stretch = stretches_[i];
    // Except for rounding, no point of a segment is above or below both of its ends.
    constexpr double kHeightRoundingMm = 1e-9;
    if (stretch.high_mm + kHeightRoundingMm < range.low_mm ||
        stretch.low_mm - kHeightRoundingMm >= range.high_mm) {
      continue;
    }
    if (progress && i % 256 == 0 && !progress(i, stretches_.size()))
      return CuttingCancelled();
    const Contour& contour = contours_.list[stretch.contour];
    const MeasuredContour part = PartOf(contours_, contour);
    if (stretch.begin == 0 && range.Contains(part.points_mm.front().z())) {
      CountContour(contour, statistics);
    }
    const ContourSteps steps = StepsOf(contours_, contour);
    const double count =
        (part.arc_mm[stretch.end] - part.arc_mm[stretch.begin]) / steps.step_mm;
    Status few = CheckCandidateCount(static_cast<double>(points.size()) + count);
    if (!few) return few;
    const std::size_t before = points.size();
    AddSteps(part, steps, stretch.begin, stretch.end, points);
    const auto outside =
        std::remove_if(points.begin() + static_cast<std::ptrdiff_t>(before), points.end(),
                       [&](const Vec3& p) { return !range.Contains(p.z()); });
    points.erase(outside, points.end());
  }
  return {};
}

Result<MethodStatistics> Sections::AddPoints(const HeightRange& range,
                                             std::uint32_t source,
                                             const ProgressSink& progress,
                                             SpacedCloud& cloud) const {
  const std::size_t before = cloud.size();
  MethodStatistics statistics;
  if (!bounds_.empty() && range.Contains(bounds_.min_mm.z())) statistics = statistics_;
  const Status made = level_ ? AddLevel(range, progress, statistics, cloud.points_mm)
                             : AddAslant(range, progress, statistics, cloud.points_mm);
  if (!made) {
    cloud.Resize(before);
    return tl::unexpected(made.error());
  }
  cloud.source.resize(cloud.points_mm.size(), source);
  cloud.spacing_mm.resize(cloud.points_mm.size(), 0);
  if (cover_) {
    const auto covered = cover_->AddPoints(range, source, progress, cloud);
    if (!covered) return tl::unexpected(covered.error());
  }
  statistics.point_count = cloud.size() - before;
  return statistics;
}

}  // namespace

Result<std::unique_ptr<PointSource>> MakeSections(mesh::TriangleMesh mesh,
                                                  const SectionOptions& options) {
  Require(options.layer_distance_mm > 0 && options.vertex_distance_mm > 0,
          "layer and vertex distance must be positive, are {} and {}",
          options.layer_distance_mm, options.vertex_distance_mm);
  Mat3 frame = FrameOf(options.normal);
  if (options.reference == SectionReference::kObject) frame = options.object_axes * frame;
  const Vec3 normal = frame.col(2);
  double low_mm = 0, high_mm = 0;
  std::vector<double> heights_mm;
  heights_mm.reserve(mesh.vertices.size());
  for (const Vec3& v : mesh.vertices) heights_mm.push_back(v.dot(normal));
  if (!heights_mm.empty()) {
    const auto [low, high] = std::minmax_element(heights_mm.begin(), heights_mm.end());
    low_mm = *low;
    high_mm = *high;
  }
  const PlaneStack planes = INTAGLIO_TRY(StackOver(low_mm, high_mm, options));
  std::vector<std::uint32_t> rank;
  rank.reserve(heights_mm.size());
  for (const double height_mm : heights_mm) rank.push_back(planes.RankOf(height_mm));
  mesh::OrderByRank(mesh, rank, planes.count + 1);
  const std::vector<std::uint32_t> neighbours = mesh::EdgeNeighbours(mesh);
  const FlatFaces flat = FindFlatFaces(mesh, neighbours, normal);
  auto sections = std::make_unique<Sections>(mesh, options, planes, std::move(rank),
                                             frame, neighbours, flat);
  INTAGLIO_TRY(sections->TraceAslant());
  INTAGLIO_TRY(sections->Cover(flat, mesh.vertices, frame));
  return sections;
}

}  // namespace intaglio::discretize
