#include "engrave/discretize/warnings.h"

#include <fmt/format.h>

#include "engrave/core/counted.h"

namespace intaglio::discretize {

Warnings WarningsOf(const MethodStatistics& statistics, double min_spacing_mm) {
  Warnings warnings;
  const auto warn = [&warnings](WarningCode code, std::string text) {
    warnings.push_back(MakeWarning(code, std::move(text)));
  };
  // A missing square of ten spacings is visible to the naked eye.
  const double seen_mm2 = 100 * min_spacing_mm * min_spacing_mm;
  if (statistics.parallel_area_mm2 > seen_mm2) {
    warn(WarningCode::kParallelFaces,
         fmt::format("{:.2f} mm^2 of faces lie parallel to the sections and get no "
                     "points: turn the planes (rotate_deg), or use fill",
                     statistics.parallel_area_mm2));
  }
  if (statistics.odd_ray_count > 0) {
    warn(WarningCode::kOddRays,
         fmt::format("{} of {} {} the surface an odd number of times: the model "
                     "is not closed; "
                     "close its holes in a mesh editor, or use the method even",
                     statistics.odd_ray_count, Counted(statistics.ray_count, "ray"),
                     VerbFor(statistics.odd_ray_count, "crosses", "cross")));
  }
  if (statistics.shallow_count > 0) {
    warn(
        WarningCode::kThinForShells,
        fmt::format(
            "{:.0f} % of the points were left out, because the model is too thin for its "
            "shells there: use smaller depths (shell_depths_mm)",
            100 * static_cast<double>(statistics.shallow_count) /
                static_cast<double>(statistics.shallow_count + statistics.point_count)));
  }
  if (statistics.rejected_triangle_count > 0) {
    warn(WarningCode::kEmptyTriangles,
         fmt::format("{} without an area {} left out",
                     Counted(statistics.rejected_triangle_count, "triangle"),
                     WasOrWere(statistics.rejected_triangle_count)));
  }
  return warnings;
}

}  // namespace intaglio::discretize
