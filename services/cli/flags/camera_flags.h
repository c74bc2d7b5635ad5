#pragma once

// From where a picture shows a block, and what is drawn beside the points.

#include <optional>

#include "engrave/render/views.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

struct CameraFlags {
  std::optional<double> azimuth_deg, elevation_deg, zoom;
  double grid_step_mm = 0;
  bool isometric = false;
  bool object_frame = false;

  render::ViewsOptions Views() const;
};

/// --azimuth, --elevation, --zoom, --isometric, --grid-step and --object-frame.
void AddCameraFlags(command_line::Command command, CameraFlags& flags);

}  // namespace intaglio::cli
