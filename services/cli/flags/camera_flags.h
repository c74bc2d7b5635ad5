#pragma once

// From where a picture shows a block, and what is drawn beside the points.

#include <optional>
#include <vector>

#include "engrave/render/views.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

struct CameraFlags {
  std::optional<double> azimuth_deg, elevation_deg, roll_deg, zoom;
  std::vector<double> middle_mm;  // none or three
  double grid_step_mm = 0;
  bool isometric = false;
  bool object_frame = false;

  render::ViewsOptions Views() const;
};

/// --azimuth, --elevation, --roll, --zoom, --middle, --isometric, --grid-step and
/// --object-frame.
void AddCameraFlags(command_line::Command command, CameraFlags& flags);

}  // namespace intaglio::cli
