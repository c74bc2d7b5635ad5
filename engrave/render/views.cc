#include "engrave/render/views.h"

#include "engrave/core/check.h"
#include "engrave/render/view_parts.h"

namespace intaglio::render {

Canvas RenderViews(const PointList& cracks_mm, const Vec3& block_size_mm,
                   const ViewsCaption& caption) {
  Require((block_size_mm.array() > 0.0).all() && block_size_mm.allFinite(),
          "a block of {} x {} x {} mm", block_size_mm.x(), block_size_mm.y(),
          block_size_mm.z());
  const ViewsLayout layout = LayOutViews(cracks_mm, block_size_mm, caption);
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
