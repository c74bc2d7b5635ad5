#include "engrave/discretize/methods.h"

#include <fmt/format.h>

#include <utility>

namespace intaglio::discretize {
namespace {

using Made = Result<std::unique_ptr<PointSource>>;

Made Make(mesh::TriangleMesh mesh, const SectionOptions& options) {
  return MakeSections(std::move(mesh), options);
}

Made Make(mesh::TriangleMesh mesh, const FillOptions& options) {
  return MakeFill(std::move(mesh), options);
}

Made Make(mesh::TriangleMesh mesh, const RayOptions& options) {
  return MakeRays(std::move(mesh), options);
}

Made Make(mesh::TriangleMesh mesh, const EvenOptions& options) {
  return MakeEven(std::move(mesh), options);
}

Made Make(const mesh::TriangleMesh& mesh, const SolidOptions& options) {
  return MakeSolid(mesh, options);
}

}  // namespace

Made MakeSource(mesh::TriangleMesh mesh, const MeshMethod& method) {
  return std::visit([&](const auto& options) { return Make(std::move(mesh), options); },
                    method);
}

std::vector<std::string> WarningsOf(const MethodStatistics& statistics,
                                    double min_spacing_mm) {
  std::vector<std::string> warnings;
  // A square of ten spacings is seen with the naked eye when it is missing.
  const double seen_mm2 = 100 * min_spacing_mm * min_spacing_mm;
  if (statistics.parallel_area_mm2 > seen_mm2) {
    warnings.push_back(
        fmt::format("{:.2f} mm^2 of faces lie parallel to the sections and get no "
                    "points: turn the planes (rotate_deg), or use fill",
                    statistics.parallel_area_mm2));
  }
  if (statistics.odd_ray_count > 0) {
    warnings.push_back(fmt::format(
        "{} of {} rays cross the surface an odd number of times: the model is not closed",
        statistics.odd_ray_count, statistics.ray_count));
  }
  if (statistics.shallow_count > 0) {
    warnings.push_back(fmt::format(
        "{:.0f} % of the places for points lie where the model is too thin for its "
        "shells, "
        "and were left out: take smaller depths (shell_depths_mm)",
        100 * static_cast<double>(statistics.shallow_count) /
            static_cast<double>(statistics.shallow_count + statistics.point_count)));
  }
  if (statistics.rejected_triangle_count > 0) {
    warnings.push_back(fmt::format("{} triangles have no area and were left out",
                                   statistics.rejected_triangle_count));
  }
  return warnings;
}

}  // namespace intaglio::discretize
