// The methods that make points of meshes: their rows of the table, and the way from
// their messages to the options of engrave/discretize/mesh.

#include <algorithm>
#include <numbers>
#include <utility>

#include "engrave/discretize/mesh/even.h"
#include "engrave/discretize/mesh/fill.h"
#include "engrave/discretize/mesh/rays.h"
#include "engrave/discretize/mesh/sections.h"
#include "engrave/discretize/mesh/solid.h"
#include "engrave/image/resample.h"
#include "services/job/methods/method_table.h"

namespace intaglio {
namespace {

constexpr NumberRange kRatio{0, 1};
constexpr NumberRange kTurnDeg{-180, 180};
// Images of a density are reduced to this: finer than any spacing.
constexpr int kMaxDensityPixels = 2048;

Vec3 VectorOf(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

discretize::Direction DirectionOf(Axis axis, const Vector3& rotate_deg) {
  const discretize::Axis base = axis == AXIS_X   ? discretize::Axis::kX
                                : axis == AXIS_Y ? discretize::Axis::kY
                                                 : discretize::Axis::kZ;
  return {base, VectorOf(rotate_deg) * (std::numbers::pi / 180)};
}

MethodField Distance(std::string_view name, std::string_view meaning) {
  return {name, kPointDistanceMm, MinSpacing(), "--vertex", meaning};
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
    // Its columns are the turned axes x, y, z.
    options.object_axes = mesh::RotationOf(input.placement.rotation_rad);
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

Method Sections() {
  return {
      .number = Model::kSections,
      .kinds = {ModelKind::kMesh},
      .default_of = {ModelKind::kMesh},
      .meaning = "points on the contours in which parallel planes cut the surface",
      .fields = {{"layer_distance_mm", kPointDistanceMm, MinSpacing(), "--layer",
                  "distance of the layers"},
                 Distance("vertex_distance_mm", "distance of the points along a contour"),
                 {"first_last_distance_ratio", kRatio, Number(0.1), "--first-last",
                  "distance of the first and last plane from the ends of the object, as "
                  "a ratio of the layer distance"},
                 {"twist_phase_ratio", kRatio, Number(0), "--twist",
                  "shift from layer to layer, as a ratio of the distance of the points"},
                 {"insert_end_points",
                  {},
                  Number(true),
                  "--end-points",
                  "points at the ends of open curves"},
                 {"axis", {}, {}, "--axis", "normal of the planes"},
                 {"rotate_deg", kTurnDeg, Number(0), "--axis-rotate",
                  "turns the axis about x, y, z"},
                 {"system",
                  {},
                  {},
                  "--axis-system",
                  "whose axes; _WORLD: planes are counted from the block's origin, the "
                  "same for all models"},
                 {"parallel_faces",
                  {},
                  {},
                  "--parallel-faces",
                  "faces that no plane cuts get points (_COVER) or a warning (_REPORT)"}},
      .make = MakeFromSections,
      .layer_field = "layer_distance_mm",
      .counts_to_warn_of = SectionsToWarnOf,
  };
}

// ---- fill ----------------------------------------------------------------------------

MadePoints MakeFromFill(const MethodInput& input, mesh::TriangleMesh&& placed) {
  const FillMethod& asked = input.model.fill();
  return discretize::MakeFill(std::move(placed),
                              {asked.vertex_distance_mm(), asked.full_fill()});
}

Method Fill() {
  return {
      .number = Model::kFill,
      .kinds = {ModelKind::kMesh},
      .meaning = "every triangle is filled",
      .fields = {Distance("vertex_distance_mm", "distance of nearest points"),
                 {"full_fill", {}, Number(true), "--full-fill", "edges included"}},
      .make = MakeFromFill,
  };
}

// ---- rays ----------------------------------------------------------------------------

MadePoints MakeFromRays(const MethodInput& input, mesh::TriangleMesh&& placed) {
  const RaysMethod& asked = input.model.rays();
  return discretize::MakeRays(
      std::move(placed),
      {asked.distance_mm(), DirectionOf(asked.axis(), asked.rotate_deg()),
       asked.interior_only()});
}

Method Rays() {
  return {
      .number = Model::kRays,
      .kinds = {ModelKind::kMesh},
      .meaning = "parallel rays, a point at every intersection",
      .fields = {Distance("distance_mm", "side of the square grid of rays"),
                 {"axis", {}, {}, "--axis", "direction of the rays"},
                 {"rotate_deg", kTurnDeg, Number(0), "--axis-rotate",
                  "turns the axis about x, y, z"},
                 {"interior_only",
                  {},
                  {},
                  "--interior-only",
                  "points inside the solid, none on its surface"}},
      .make = MakeFromRays,
  };
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

Method Even() {
  return {
      .number = Model::kEven,
      .kinds = {ModelKind::kMesh},
      .meaning =
          "blue noise: no place of the surface is much farther than the distance from a "
          "point",
      .fields =
          {Distance("distance_mm", "distance of nearest points"),
           {"shell_depths_mm", NumberRange{0, 500}, Number(0), "--shells",
            "depths below the surface that get points; 0 is the surface itself"},
           {"image",
            {},
            {},
            "--density-image",
            "sparse at dark pixels of an image over x and z",
            true},
           {"curvature_radius_mm",
            NumberRange{0.01, 1000},
            {},
            "--density-curvature",
            "sparse at flat places; dense where the radius of curvature is below this"},
           {"light",
            NumberRange{-1000, 1000},
            {},
            "--density-light",
            "sparse at places turned away from a light that comes from this direction"},
           {"sparse_distance_mm", kPointDistanceMm, Times(3, "distance_mm"), "--sparse",
            "distance where the density is lowest; density is one of image, curvature "
            "and light"}},
      .make = MakeFromEven,
  };
}

// ---- solid ---------------------------------------------------------------------------

MadePoints MakeFromSolid(const MethodInput& input, mesh::TriangleMesh&& placed) {
  return discretize::MakeSolid(placed, {input.model.solid().distance_mm(),
                                        input.job.discretization().height_ratio()});
}

Method Solid() {
  return {
      .number = Model::kSolid,
      .kinds = {ModelKind::kMesh},
      .meaning = "the volume of closed meshes",
      .fields = {Distance("distance_mm", "distance of nearest points")},
      .make = MakeFromSolid,
  };
}

}  // namespace

std::vector<Method> MeshMethods() {
  return {Sections(), Fill(), Rays(), Even(), Solid()};
}

}  // namespace intaglio
