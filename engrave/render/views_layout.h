#pragma once

// What views.h shows where: which views the work needs, and how large they are.

#include <optional>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/render/canvas.h"
#include "engrave/render/page.h"
#include "engrave/render/views.h"

namespace intaglio::render {

enum class PanelKind { kPerspective, kFromFront, kFromRight, kFromAbove };

struct Panel {
  PanelKind kind = PanelKind::kPerspective;
  Rect cell;
  Box3 shown_mm;            ///< The block, or the part of it around the work.
  bool whole_block = true;  ///< Whether shown_mm is the block.
  bool is_flat = false;     ///< The work is in the plane of this view.
  double px_per_mm = 1.0;   ///< Of a parallel view.
  std::string name, description;
  std::optional<Camera> camera;  ///< of a perspective; absent: chosen to fill the cell
  double grid_step_mm = 0;       ///< 0: by the scale
  std::optional<Box3> work_mm;   ///< gets a frame
};

struct ViewsLayout {
  Page page;
  std::vector<Panel> panels;
};

/// The axis 0..2 across work that lies in a plane: its extent there is less than 3 % of
/// the largest one, and at most half of the middle one. Of two such axes the one along
/// which one looks from the front, then from above. Nullopt for all other clouds, and for
/// fewer than two points.
std::optional<int> FlatAxis(const PointList& cracks_mm);

ViewsLayout LayOutViews(const PointList& cracks_mm, const Vec3& block_size_mm,
                        const ViewsCaption& caption, const ViewsOptions& options = {});

/// The part of the block to be shown so that the work is large: the block, or, if the
/// work takes less than `min_ratio` of it along every axis (but `flat_axis`), the work
/// with a margin.
Box3 ShownPart(const PointList& cracks_mm, const Vec3& block_size_mm, double min_ratio,
               std::optional<int> flat_axis);

}  // namespace intaglio::render
