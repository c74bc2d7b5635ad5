#include "engrave/discretize/methods.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engrave/discretize/bounds.h"
#include "engrave/discretize/weld.h"

namespace intaglio::discretize {
namespace {

struct Entry {
  const char* name;
  Method method;
  /// The weld leaves no points nearer than this, should it be above the minimum spacing.
  double (*weld_distance_mm)(const DiscretizeOptions&);
  Result<MethodStatistics> (*run)(const mesh::TriangleMesh&, const DiscretizeOptions&,
                                  std::uint32_t, const ProgressSink&, PointCloud&);
};

constexpr std::array kMethods = {
    Entry{"sections", Method::kSections, [](const DiscretizeOptions&) { return 0.0; },
          [](const mesh::TriangleMesh& m, const DiscretizeOptions& o,
             std::uint32_t source, const ProgressSink& p,
             PointCloud& c) { return CutSections(m, o.sections, source, p, c); }},
    Entry{"fill", Method::kFill,
          [](const DiscretizeOptions& o) { return o.fill.vertex_distance_mm; },
          [](const mesh::TriangleMesh& m, const DiscretizeOptions& o,
             std::uint32_t source, const ProgressSink& p,
             PointCloud& c) { return FillTriangles(m, o.fill, source, p, c); }},
    Entry{"rays", Method::kRays, [](const DiscretizeOptions&) { return 0.0; },
          [](const mesh::TriangleMesh& m, const DiscretizeOptions& o,
             std::uint32_t source, const ProgressSink& p,
             PointCloud& c) { return CrossRays(m, o.rays, source, p, c); }},
};

const Entry& EntryOf(Method method) {
  for (const Entry& entry : kMethods) {
    if (entry.method == method) return entry;
  }
  return kMethods.front();
}

class Checker {
 public:
  void Within(const char* name, double value, double low, double high) {
    if (value >= low && value <= high) return;
    errors_.push_back({ErrorCode::kInvalidValue,
                       fmt::format("{}: {} is outside {}..{}", name, value, low, high),
                       fmt::format("{}", value)});
  }
  void Angles(const char* name, const Direction& direction) {
    for (int axis = 0; axis < 3; ++axis) {
      Within(name, direction.rotation_rad[axis], -std::numbers::pi, std::numbers::pi);
    }
  }
  std::vector<Error> Take() { return std::move(errors_); }

 private:
  std::vector<Error> errors_;
};

void Warn(const DiscretizeOptions& options, Discretized& result) {
  MethodStatistics all;
  for (const MethodStatistics& model : result.models) all.Add(model);
  // A square of ten spacings is seen with the naked eye when it is missing.
  const double seen_mm2 = 100 * options.min_spacing_mm * options.min_spacing_mm;
  if (options.method == Method::kSections && all.parallel_area_mm2 > seen_mm2) {
    result.warnings.push_back(
        fmt::format("{:.2f} mm^2 of faces lie parallel to the sections and get no "
                    "points: turn the planes "
                    "(rotate_deg), or use fill",
                    all.parallel_area_mm2));
  }
  if (all.odd_ray_count > 0) {
    result.warnings.push_back(fmt::format(
        "{} of {} rays cross the surface an odd number of times: the model is not closed",
        all.odd_ray_count, all.ray_count));
  }
  if (all.rejected_triangle_count > 0) {
    result.warnings.push_back(fmt::format("{} triangles have no area and were left out",
                                          all.rejected_triangle_count));
  }
}

}  // namespace

Result<Method> MethodFromName(std::string_view name) {
  std::string known;
  for (const Entry& entry : kMethods) {
    if (name == entry.name) return entry.method;
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  return Fail(ErrorCode::kUnsupported,
              fmt::format("there is no method '{}'; there are: {}", name, known),
              std::string(name));
}

const char* NameOf(Method method) { return EntryOf(method).name; }

std::vector<Error> CheckOptions(const DiscretizeOptions& options) {
  Checker check;
  check.Within("min_spacing_mm", options.min_spacing_mm, 0.02, 10);
  if (options.method == Method::kSections) {
    const SectionOptions& s = options.sections;
    check.Within("sections.layer_distance_mm", s.layer_distance_mm, 0.01, 100);
    check.Within("sections.vertex_distance_mm", s.vertex_distance_mm, 0.01, 100);
    check.Within("sections.first_last_distance_ratio", s.first_last_distance_ratio, 0, 1);
    check.Within("sections.twist_phase_ratio", s.twist_phase_ratio, 0, 1);
    check.Angles("sections.rotate", s.normal);
  } else if (options.method == Method::kFill) {
    check.Within("fill.vertex_distance_mm", options.fill.vertex_distance_mm, 0.01, 100);
  } else {
    check.Within("rays.distance_mm", options.rays.distance_mm, 0.01, 100);
    check.Angles("rays.rotate", options.rays.direction);
  }
  return check.Take();
}

Result<Discretized> Discretize(const std::vector<mesh::TriangleMesh>& models,
                               const DiscretizeOptions& options,
                               const ProgressSink& progress) {
  if (const auto errors = CheckOptions(options); !errors.empty()) {
    Error all = errors.front();
    for (std::size_t i = 1; i < errors.size(); ++i)
      all.message += "\n" + errors[i].message;
    return tl::unexpected(all);
  }
  Discretized result;
  PointCloud candidates;
  for (std::uint32_t m = 0; m < models.size(); ++m) {
    // Planes and triangles differ in number from model to model: each counts as one
    // whole.
    const auto part = [&](std::uint64_t done, std::uint64_t total) {
      constexpr std::uint64_t kParts = 1000;
      const std::uint64_t within = total == 0 ? 0 : kParts * done / total;
      return !progress || progress(m * kParts + within, models.size() * kParts);
    };
    const auto statistics =
        EntryOf(options.method).run(models[m], options, m, part, candidates);
    if (!statistics) return tl::unexpected(statistics.error());
    result.models.push_back(*statistics);
  }
  result.candidate_count = candidates.size();
  auto inside = KeepInside(std::move(candidates), options.permitted_mm, options.clip);
  if (!inside) return tl::unexpected(inside.error());
  result.clipped_count = result.candidate_count - inside->size();
  const Entry& entry = EntryOf(options.method);
  result.cloud = WeldToSpacing(
      *inside, std::max(options.min_spacing_mm, entry.weld_distance_mm(options)));
  result.welded_count = inside->size() - result.cloud.size();
  if (result.cloud.size() == 0) {
    return Fail(
        ErrorCode::kMissing,
        "no points came out: the model is empty, lies outside the block, or is smaller "
        "than the distances asked for");
  }
  Warn(options, result);
  return result;
}

}  // namespace intaglio::discretize
