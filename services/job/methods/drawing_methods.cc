// The methods that make points of drawings and texts: as mesh_methods.cc.

#include "services/job/methods/method_table.h"

namespace intaglio {
namespace {

MadePoints MakeFromCurves(const MethodInput& input,
                          const discretize::PlacedDrawing& placed,
                          discretize::CurveFill inside) {
  const CurvesMethod& asked = input.model.curves();
  discretize::CurveOptions options;
  options.distance_mm = asked.distance_mm();
  options.layer_count = static_cast<int>(asked.layer_count());
  options.layer_distance_mm = asked.layer_distance_mm();
  options.layer_direction = placed.normal;
  options.twist_phase_ratio = asked.twist_phase_ratio();
  options.insert_end_points = asked.insert_end_points();
  if (asked.fill()) options.fill = inside;
  return discretize::MakeCurvePoints(placed.flat, options);
}

Method Curves() {
  return {
      .number = Model::kCurves,
      .kinds = {ModelKind::kDrawing, ModelKind::kText},
      .default_of = {ModelKind::kDrawing, ModelKind::kText},
      .meaning = "along lines, arcs and splines, and inside closed ones",
      .fields =
          {{"distance_mm", kPointDistanceMm, MinSpacing(), "--vertex",
            "distance of nearest points"},
           {"layer_count", NumberRange{1, 10}, Number(1), "--layer-count",
            "number of layers above one another"},
           {"layer_distance_mm", NumberRange{0, 50}, MinSpacing(), "--layer",
            "distance of the layers"},
           {"twist_phase_ratio", NumberRange{0, 1}, Number(0), "--twist",
            "shift from layer to layer, as a ratio of the distance of the points"},
           {"insert_end_points",
            {},
            Number(true),
            "--end-points",
            "points at the ends of open curves"},
           {"fill", {}, {}, "--fill", "the area inside closed curves gets points, too"}},
      .make = MakeFromCurves,
  };
}

}  // namespace

std::vector<Method> DrawingMethods() { return {Curves()}; }

}  // namespace intaglio
