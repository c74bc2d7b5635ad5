// The methods that make points of drawings and texts: as mesh_methods.cc.

#include <fmt/format.h>

#include <numbers>

#include "engrave/mesh/placement.h"
#include "services/job/methods/method_table.h"

namespace intaglio {
namespace {

std::optional<Vec3> LayerAxisOf(const Model& model, const Mat3& rotation) {
  const CurvesMethod& curves = model.curves();
  if (!curves.has_layer_axis()) return std::nullopt;
  const Vec3 base = curves.layer_axis() == AXIS_X   ? Vec3::UnitX()
                    : curves.layer_axis() == AXIS_Y ? Vec3::UnitY()
                                                    : Vec3::UnitZ();
  const Vector3& turn_deg = curves.layer_rotate_deg();
  const Vec3 turned = mesh::RotationOf(Vec3(turn_deg.x(), turn_deg.y(), turn_deg.z()) *
                                       (std::numbers::pi / 180)) *
                      base;
  return curves.layer_system() == COORDINATE_SYSTEM_OBJECT ? Vec3(rotation * turned)
                                                           : turned;
}

std::vector<MethodFault> LayerFaults(const JobSpec&, const Model& model) {
  const CurvesMethod& curves = model.curves();
  if (curves.layer_count() <= 1 || curves.layer_distance_mm() > 0) return {};
  return {{"layer_distance_mm", fmt::format("{}", curves.layer_distance_mm()),
           fmt::format("must be positive for {} layers", curves.layer_count())}};
}

Method Curves() {
  return {
      .number = Model::kCurves,
      .kinds = {ModelKind::kDrawing, ModelKind::kText, ModelKind::kCode},
      .default_of = {ModelKind::kDrawing, ModelKind::kText, ModelKind::kCode},
      .meaning = "along lines, arcs and splines, and inside closed ones",
      .layer_field = "layer_distance_mm",
      .layer_count_field = "layer_count",
      .layer_axis = LayerAxisOf,
      .fills = [](const Model& model) { return model.curves().fill(); },
      .faults = LayerFaults,
  };
}

}  // namespace

std::vector<Method> DrawingMethods() { return {Curves()}; }

}  // namespace intaglio
