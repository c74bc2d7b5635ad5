#include "services/cli/flags/camera_flags.h"

#include <cmath>
#include <numbers>

namespace intaglio::cli {

render::ViewsOptions CameraFlags::Views() const {
  constexpr double kRadPerDeg = std::numbers::pi / 180;
  render::ViewsOptions views;
  views.grid_step_mm = grid_step_mm;
  views.object_frame = object_frame;
  if (!azimuth_deg && !elevation_deg && !roll_deg && !zoom && !isometric) return views;
  render::Camera camera;
  if (isometric) {
    camera = {.azimuth_rad = std::numbers::pi / 4,
              .elevation_rad = std::asin(1 / std::sqrt(3.0)),
              .parallel = true};
  }
  if (azimuth_deg) camera.azimuth_rad = *azimuth_deg * kRadPerDeg;
  if (elevation_deg) camera.elevation_rad = *elevation_deg * kRadPerDeg;
  if (roll_deg) camera.roll_rad = *roll_deg * kRadPerDeg;
  if (zoom) camera.zoom = *zoom;
  if (!middle_mm.empty()) camera.middle_mm = Vec3(middle_mm.data());
  views.camera = camera;
  return views;
}

void AddCameraFlags(command_line::Command command, CameraFlags& flags) {
  command
      .AddOption("--azimuth", flags.azimuth_deg,
                 "one large view from this angle to the right of the front, degrees")
      .Within(-180.0, 180.0);
  command
      .AddOption("--elevation", flags.elevation_deg,
                 "one large view from this angle above the middle, degrees")
      .Within(-90.0, 90.0);
  command
      .AddOption("--roll", flags.roll_deg,
                 "one large view that is turned about the line of sight, "
                 "counterclockwise, degrees")
      .Within(-180.0, 180.0);
  const auto zoom =
      command
          .AddOption("--zoom", flags.zoom,
                     "one large view of the part about the work, so many times larger")
          .Within(1.0, 1000.0);
  command
      .AddOption("--middle", flags.middle_mm,
                 "shifts the enlarged view: the place x y z of the block in its middle, "
                 "mm; default the middle of the work")
      .TakeValues(3)
      .Need(zoom);
  command.AddFlag(
      "--isometric", flags.isometric,
      "one large view in which parallel lines stay parallel, from azimuth 45, "
      "elevation 35.26 where they are not given");
  command.AddOption("--grid-step", flags.grid_step_mm, "step of the grid, mm").Positive();
  command.AddFlag("--object-frame", flags.object_frame,
                  "a frame around the work, with its sizes");
}

}  // namespace intaglio::cli
