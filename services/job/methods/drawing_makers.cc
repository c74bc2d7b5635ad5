// How the methods of drawings and texts make points: as mesh_makers.cc.

#include "services/job/methods/method_table.h"
#include "services/job/methods/point_maker.h"

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
  options.layer_direction =
      MethodOf(input.model)
          ->layer_axis(input.model, mesh::ObjectAxesOf(input.placement))
          .value_or(placed.normal);
  options.twist_phase_ratio = asked.twist_phase_ratio();
  options.insert_end_points = asked.insert_end_points();
  if (asked.fill() || input.model.has_code()) options.fill = inside;
  return discretize::MakeCurvePoints(placed.flat, options);
}

}  // namespace

std::vector<PointMaker> DrawingMakers() {
  return {{.method_number = Model::kCurves, .make = MakeFromCurves}};
}

}  // namespace intaglio
