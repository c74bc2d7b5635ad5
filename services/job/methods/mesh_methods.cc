// The rows of the methods that make points of meshes.

#include <fmt/format.h>

#include "services/job/methods/method_table.h"

namespace intaglio {
namespace {

constexpr NumberRange kRatio{0, 1};
constexpr NumberRange kTurnDeg{-180, 180};

MethodField Distance(std::string_view name, std::string_view meaning) {
  return {name, kPointDistanceMm, MinSpacing(), "--vertex", meaning};
}

// ---- sections ------------------------------------------------------------------------

Method Sections() {
  return {
      .number = Model::kSections,
      .kinds = {ModelKind::kMesh},
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
      .layer_field = "layer_distance_mm",
  };
}

// ---- fill ----------------------------------------------------------------------------

Method Fill() {
  return {
      .number = Model::kFill,
      .kinds = {ModelKind::kMesh},
      .meaning = "every triangle is filled",
      .fields = {Distance("vertex_distance_mm", "distance of nearest points"),
                 {"full_fill", {}, Number(true), "--full-fill", "edges included"}},
  };
}

// ---- rays ----------------------------------------------------------------------------

Method Rays() {
  return {
      .number = Model::kRays,
      .kinds = {ModelKind::kMesh},
      .meaning = "parallel rays, a point at every intersection",
      .fields =
          {Distance("distance_mm", "side of the square grid of rays"),
           {"axis", {}, {}, "--axis", "direction of the rays"},
           {"rotate_deg", kTurnDeg, Number(0), "--axis-rotate",
            "turns the axis about x, y, z"},
           {"interior_only",
            {},
            {},
            "--interior-only",
            "points inside the solid, none on its surface"},
           {"system",
            {},
            {},
            "--axis-system",
            "whose axes; _WORLD: the grid goes through the block's origin, the same "
            "for all models"}},
  };
}

// ---- even ----------------------------------------------------------------------------

std::vector<MethodFault> EvenFaults(const JobSpec&, const Model& model) {
  const EvenMethod& even = model.even();
  std::vector<MethodFault> faults;
  const Vector3& light = even.light();
  if (even.has_light() && light.x() == 0 && light.y() == 0 && light.z() == 0) {
    faults.push_back(
        {"light", "0 0 0", "is no direction; give where the light comes from"});
  }
  const bool has_density =
      even.has_light() || even.has_image() || even.has_curvature_radius_mm();
  if (has_density && even.sparse_distance_mm() < even.distance_mm()) {
    faults.push_back({"sparse_distance_mm", fmt::format("{}", even.sparse_distance_mm()),
                      fmt::format("is below the distance of nearest points, {}; "
                                  "increase it",
                                  even.distance_mm())});
  }
  return faults;
}

Method Even() {
  return {
      .number = Model::kEven,
      .kinds = {ModelKind::kMesh},
      .default_of = {ModelKind::kMesh},
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
      .faults = EvenFaults,
  };
}

// ---- solid ---------------------------------------------------------------------------

Method Solid() {
  return {
      .number = Model::kSolid,
      .kinds = {ModelKind::kMesh},
      .meaning = "the volume of closed meshes",
      .fields = {Distance("distance_mm", "distance of nearest points")},
  };
}

}  // namespace

std::vector<Method> MeshMethods() {
  return {Sections(), Fill(), Rays(), Even(), Solid()};
}

}  // namespace intaglio
