#pragma once

#include "engrave/core/result.h"
#include "engrave/drawing/flatten.h"
#include "engrave/mesh/placement.h"

namespace intaglio::discretize {

struct PlacedDrawing {
  drawing::FlatDrawing flat;    ///< glass frame, mm
  Vec3 normal = Vec3::UnitZ();  ///< of the drawing's plane, for CurveOptions
};

/// The drawing in the block. `placement` is that of models (placement.h); curves are
/// transformed exactly and flattened in the glass frame. Then open curves are joined when
/// `join_mm` is positive, and of duplicate contours one is kept (flatten.h). Errors:
/// those of GlassFromModelOf and Flatten, and kMissing for a drawing without curves.
Result<PlacedDrawing> PlaceDrawing(const drawing::Drawing& drawing,
                                   const mesh::Placement& placement,
                                   const Vec3& block_size_mm,
                                   const drawing::FlattenOptions& flatten = {},
                                   double join_mm = 0.001);

}  // namespace intaglio::discretize
