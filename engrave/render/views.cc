#include "engrave/render/views.h"

#include <cmath>
#include <numbers>

#include "engrave/core/check.h"
#include "engrave/render/view_parts.h"

namespace intaglio::render {

namespace {

void CheckViews(const ViewsOptions& options) {
  Require(options.grid_step_mm >= 0 && std::isfinite(options.grid_step_mm),
          "grid_step_mm must not be negative, is {}", options.grid_step_mm);
  if (!options.camera) return;
  const Camera& camera = *options.camera;
  Require(std::abs(camera.azimuth_rad) <= std::numbers::pi &&
              std::abs(camera.elevation_rad) <= std::numbers::pi / 2 &&
              std::abs(camera.roll_rad) <= std::numbers::pi,
          "azimuth {} and roll {} must be in -pi..pi, elevation {} in -pi/2..pi/2",
          camera.azimuth_rad, camera.roll_rad, camera.elevation_rad);
  Require(camera.zoom >= 1 && camera.zoom <= 1000, "zoom must be 1..1000, is {}",
          camera.zoom);
}

}  // namespace

Canvas RenderViews(const PointList& cracks_mm, const Vec3& block_size_mm,
                   const ViewsCaption& caption, const ViewsOptions& options) {
  Require((block_size_mm.array() > 0.0).all() && block_size_mm.allFinite(),
          "a block of {} x {} x {} mm", block_size_mm.x(), block_size_mm.y(),
          block_size_mm.z());
  CheckViews(options);
  const ViewsLayout layout = LayOutViews(cracks_mm, block_size_mm, caption, options);
  Canvas canvas(kViewsWidth, kViewsHeight);
  DrawPage(canvas, layout.page);
  for (const Panel& panel : layout.panels) {
    if (panel.kind == PanelKind::kPerspective) {
      DrawPerspectiveView(canvas, panel, cracks_mm);
    } else {
      DrawOrthographicView(canvas, panel, cracks_mm);
    }
  }
  return canvas;
}

}  // namespace intaglio::render
