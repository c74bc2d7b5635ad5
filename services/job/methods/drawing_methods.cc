// The methods that make points of drawings and texts: as mesh_methods.cc.

#include "services/job/methods/method_table.h"

namespace intaglio {
namespace {

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
  };
}

}  // namespace

std::vector<Method> DrawingMethods() { return {Curves()}; }

}  // namespace intaglio
