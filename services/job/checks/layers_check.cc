#include "services/job/checks/layers_check.h"

#include <google/protobuf/descriptor.h>

#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "services/job/convert/model_kind.h"
#include "services/job/fields/shapes.h"
#include "services/job/methods/method_table.h"

namespace intaglio {
namespace {

/// 0: its points are in one layer.
double LayerDistanceOf(const Method& method, const Model& model) {
  const auto& message = MessageOf(method, model);
  const auto field_of = [&](std::string_view name) {
    return method.message().FindFieldByName(std::string(name));
  };
  const auto& reflection = *message.GetReflection();
  if (!method.layer_count_field.empty() &&
      reflection.GetUInt32(message, field_of(method.layer_count_field)) < 2) {
    return 0;
  }
  return reflection.GetDouble(message, field_of(method.layer_field));
}

/// How much higher the next layer is, by the distance of the layers. Layers of a sheet
/// that stands upright are behind one another: 0.
double RiseOf(const JobSpec& job, const Model& model, const Method& method) {
  const auto kind = KindOf(model);
  if (!kind || *kind == ModelKind::kMesh) return 1;
  const mesh::Placement placement = PlacementOf(model.placement(), job.block());
  const Mat3 rotation = mesh::ObjectAxesOf(placement);
  std::optional<Vec3> axis;
  if (method.layer_axis != nullptr) axis = method.layer_axis(model, rotation);
  const Vec3 normal = rotation * (mesh::UprightFrom(placement.up) * Vec3::UnitZ());
  const double rise = std::abs(axis.value_or(normal).z());
  return rise < 1e-9 ? 0 : rise;
}

}  // namespace

void CheckLayers(const JobSpec& job, Findings& findings) {
  if (!job.ordering().has_layers()) return;
  const double thickness_mm = job.ordering().layers().layer_thickness_mm();
  for (const Model& model : job.models()) {
    const Method* method = MethodOf(model);
    if (method == nullptr || method->layer_field.empty()) continue;
    const double distance_mm =
        LayerDistanceOf(*method, model) * RiseOf(job, model, *method);
    if (thickness_mm >= distance_mm) continue;
    return findings.Wrong("ordering.layers.layer_thickness_mm", thickness_mm,
                          "is less than the layer distance of the {}, {}", method->name(),
                          distance_mm);
  }
}

}  // namespace intaglio
