// The rows of the methods that make points of meshes.

#include <fmt/format.h>

#include "services/job/methods/method_table.h"

namespace intaglio {
namespace {

// ---- sections ------------------------------------------------------------------------

Method Sections() {
  return {
      .number = Model::kSections,
      .kinds = {ModelKind::kMesh},
      .meaning = "points on the contours in which parallel planes cut the surface",
      .layer_field = "layer_distance_mm",
  };
}

// ---- fill ----------------------------------------------------------------------------

Method Fill() {
  return {
      .number = Model::kFill,
      .kinds = {ModelKind::kMesh},
      .meaning = "every triangle is filled",
  };
}

// ---- rays ----------------------------------------------------------------------------

Method Rays() {
  return {
      .number = Model::kRays,
      .kinds = {ModelKind::kMesh},
      .meaning = "parallel rays, a point at every intersection",
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
      .faults = EvenFaults,
  };
}

// ---- solid ---------------------------------------------------------------------------

Method Solid() {
  return {
      .number = Model::kSolid,
      .kinds = {ModelKind::kMesh},
      .meaning = "the volume of closed meshes",
      .lattice_mm = [](const Model& model) { return model.solid().distance_mm(); },
  };
}

}  // namespace

std::vector<Method> MeshMethods() {
  return {Sections(), Fill(), Rays(), Even(), Solid()};
}

}  // namespace intaglio
