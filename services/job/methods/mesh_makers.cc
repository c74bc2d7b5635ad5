// How the methods of meshes make points: the way from their messages to the options of
// engrave/discretize/mesh.

#include <algorithm>
#include <numbers>
#include <utility>

#include "engrave/discretize/mesh/even.h"
#include "engrave/discretize/mesh/fill.h"
#include "engrave/discretize/mesh/rays.h"
#include "engrave/discretize/mesh/sections.h"
#include "engrave/discretize/mesh/solid.h"
#include "engrave/image/resample.h"
#include "services/job/methods/point_maker.h"

namespace intaglio {
namespace {

// Images of a density are reduced to this: finer than any spacing.
constexpr int kMaxDensityPixels = 2048;

Vec3 VectorOf(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

discretize::Direction DirectionOf(Axis axis, const Vector3& rotate_deg) {
  const discretize::Axis base = axis == AXIS_X   ? discretize::Axis::kX
                                : axis == AXIS_Y ? discretize::Axis::kY
                                                 : discretize::Axis::kZ;
  return {base, VectorOf(rotate_deg) * (std::numbers::pi / 180)};
}

// ---- sections ------------------------------------------------------------------------

MadePoints MakeFromSections(const MethodInput& input, mesh::TriangleMesh&& placed) {
  const SectionsMethod& asked = input.model.sections();
  discretize::SectionOptions options;
  options.layer_distance_mm = asked.layer_distance_mm();
  options.vertex_distance_mm = asked.vertex_distance_mm();
  options.first_last_distance_ratio = asked.first_last_distance_ratio();
  options.twist_phase_ratio = asked.twist_phase_ratio();
  options.insert_end_points = asked.insert_end_points();
  options.normal = DirectionOf(asked.axis(), asked.rotate_deg());
  options.reference = asked.system() == COORDINATE_SYSTEM_WORLD
                          ? discretize::SectionReference::kWorld
                          : discretize::SectionReference::kObject;
  if (asked.system() == COORDINATE_SYSTEM_OBJECT) {
    options.object_axes = mesh::ObjectAxesOf(input.placement);
  }
  options.parallel_faces = asked.parallel_faces() == PARALLEL_FACES_COVER
                               ? discretize::ParallelFaces::kCover
                           : asked.parallel_faces() == PARALLEL_FACES_REPORT
                               ? discretize::ParallelFaces::kReport
                               : discretize::ParallelFaces::kIgnore;
  return discretize::MakeSections(std::move(placed), options);
}

discretize::MethodStatistics SectionsToWarnOf(const Model& model,
                                              discretize::MethodStatistics counts) {
  if (model.sections().parallel_faces() != PARALLEL_FACES_REPORT) {
    counts.parallel_area_mm2 = 0;
  }
  return counts;
}

// ---- fill, rays ----------------------------------------------------------------------

MadePoints MakeFromFill(const MethodInput& input, mesh::TriangleMesh&& placed) {
  const FillMethod& asked = input.model.fill();
  return discretize::MakeFill(std::move(placed),
                              {asked.vertex_distance_mm(), asked.full_fill()});
}

MadePoints MakeFromRays(const MethodInput& input, mesh::TriangleMesh&& placed) {
  const RaysMethod& asked = input.model.rays();
  discretize::RayOptions options;
  options.distance_mm = asked.distance_mm();
  options.direction = DirectionOf(asked.axis(), asked.rotate_deg());
  options.grid_through_origin = asked.system() == COORDINATE_SYSTEM_WORLD;
  if (asked.system() == COORDINATE_SYSTEM_OBJECT)
    options.axes = mesh::ObjectAxesOf(input.placement);
  options.interior_only = asked.interior_only();
  return discretize::MakeRays(std::move(placed), options);
}

// ---- even ----------------------------------------------------------------------------

/// A picture laid over x and z of a box, seen from -y: bright is dense.
discretize::Density DensityOf(const image::GreyImage& picture, const Box3& box_mm) {
  const double shrink = std::min(1.0, static_cast<double>(kMaxDensityPixels) /
                                          std::max(picture.width, picture.height));
  auto values = std::make_shared<const image::FloatImage>(
      image::Resample(picture, std::max(1, static_cast<int>(picture.width * shrink)),
                      std::max(1, static_cast<int>(picture.height * shrink))));
  const Vec3 size_mm = box_mm.size_mm().cwiseMax(1e-9);
  return discretize::DensityByPlace([=](const Vec3& p) {
    const Vec3 share = (p - box_mm.min_mm).cwiseQuotient(size_mm);
    return static_cast<double>(image::Interpolate(*values, share.x(), 1 - share.z()));
  });
}

discretize::Density DensityOf(const MethodInput& input,
                              const mesh::TriangleMesh& placed) {
  const EvenMethod& asked = input.model.even();
  if (asked.has_image()) return DensityOf(input.images.at("image"), placed.Bounds());
  if (asked.has_curvature_radius_mm()) {
    return discretize::DensityByCurvature(placed, 1 / asked.curvature_radius_mm());
  }
  if (asked.has_light())
    return discretize::DensityByLight(placed, VectorOf(asked.light()));
  return {};
}

MadePoints MakeFromEven(const MethodInput& input, mesh::TriangleMesh&& placed) {
  const EvenMethod& asked = input.model.even();
  discretize::EvenOptions options;
  options.distance_mm = asked.distance_mm();
  options.sparse_distance_mm = asked.sparse_distance_mm();
  options.surface = false;
  for (const double depth_mm : asked.shell_depths_mm()) {
    if (depth_mm == 0) {
      options.surface = true;
    } else {
      options.depths_mm.push_back(depth_mm);
    }
  }
  options.density = DensityOf(input, placed);
  return discretize::MakeEven(std::move(placed), options);
}

// ---- solid ---------------------------------------------------------------------------

MadePoints MakeFromSolid(const MethodInput& input, mesh::TriangleMesh&& placed) {
  return discretize::MakeSolid(placed, {input.model.solid().distance_mm(),
                                        input.job.discretization().height_ratio()});
}

}  // namespace

std::vector<PointMaker> MeshMakers() {
  return {{Model::kSections, MakeFromSections, SectionsToWarnOf},
          {Model::kFill, MakeFromFill},
          {Model::kRays, MakeFromRays},
          {Model::kEven, MakeFromEven},
          {Model::kSolid, MakeFromSolid}};
}

}  // namespace intaglio
