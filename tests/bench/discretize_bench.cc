// Times of the discretization, of the stages one by one and of the whole, on the meshes
// of ../shared/data. Release build, one thread:
//   discretize_bench --benchmark_repetitions=5 --benchmark_report_aggregates_only
// The argument is the height of the model, mm; layers and spacing are 0.1 mm.

#include <benchmark/benchmark.h>

#include <optional>

#include "engrave/discretize/methods.h"
#include "engrave/discretize/weld.h"
#include "engrave/mesh/mesh_import.h"
#include "engrave/mesh/placement.h"

namespace {

using namespace intaglio;
using namespace intaglio::discretize;

constexpr double kSpacingMm = 0.1;
const Vec3 kBlockMm(200, 200, 200);

std::optional<mesh::TriangleMesh> Model(const char* file, double height_mm) {
  const auto imported =
      mesh::ImportMesh(std::string(INTAGLIO_SOURCE_DIR "/../shared/data/meshes/") + file);
  if (!imported) return std::nullopt;
  mesh::Placement placement;
  placement.fit = mesh::FitHeight{height_mm};
  auto placed = mesh::PlaceInBlock(*imported, placement, kBlockMm);
  if (!placed) return std::nullopt;
  return *std::move(placed);
}

DiscretizeOptions Options(Method method) {
  DiscretizeOptions options;
  options.method = method;
  options.min_spacing_mm = kSpacingMm;
  options.sections.layer_distance_mm = options.sections.vertex_distance_mm = kSpacingMm;
  options.fill.vertex_distance_mm = options.rays.distance_mm = kSpacingMm;
  options.permitted_mm = {Vec3(3, 3, 3), kBlockMm - Vec3(3, 3, 3)};
  return options;
}

/// Calls `run(mesh, cloud)` with an empty cloud; counts points.
template <typename Run>
void Measure(benchmark::State& state, const Run& run) {
  const auto model = Model("bunny.obj", static_cast<double>(state.range(0)));
  if (!model) return state.SkipWithError("no bunny.obj in ../shared/data/meshes");
  std::size_t points = 0;
  for (auto _ : state) {
    PointCloud cloud;
    run(*model, cloud);
    points = cloud.size();
  }
  state.counters["points"] = static_cast<double>(points);
  state.counters["points_per_s"] = benchmark::Counter(
      static_cast<double>(points), benchmark::Counter::kIsIterationInvariantRate);
}

void Sections(benchmark::State& state) {
  const auto options = Options(Method::kSections);
  Measure(state, [&](const mesh::TriangleMesh& mesh, PointCloud& cloud) {
    CutSections(mesh, options.sections, 0, {}, cloud).value();
  });
}

void Fill(benchmark::State& state) {
  const auto options = Options(Method::kFill);
  Measure(state, [&](const mesh::TriangleMesh& mesh, PointCloud& cloud) {
    FillTriangles(mesh, options.fill, 0, {}, cloud).value();
  });
}

void Rays(benchmark::State& state) {
  auto options = Options(Method::kRays);
  options.rays.direction = {Axis::kZ, Vec3(0.3, 0.2, 0)};
  Measure(state, [&](const mesh::TriangleMesh& mesh, PointCloud& cloud) {
    CrossRays(mesh, options.rays, 0, {}, cloud).value();
  });
}

void Weld(benchmark::State& state, Method method) {
  const auto model = Model("bunny.obj", static_cast<double>(state.range(0)));
  if (!model) return state.SkipWithError("no bunny.obj in ../shared/data/meshes");
  const auto options = Options(method);
  PointCloud cloud;
  if (method == Method::kSections) {
    CutSections(*model, options.sections, 0, {}, cloud).value();
  } else {
    FillTriangles(*model, options.fill, 0, {}, cloud).value();
  }
  std::size_t kept = 0;
  for (auto _ : state) kept = WeldToSpacing(cloud, kSpacingMm).size();
  state.counters["candidates"] = static_cast<double>(cloud.size());
  state.counters["kept"] = static_cast<double>(kept);
  state.counters["candidates_per_s"] = benchmark::Counter(
      static_cast<double>(cloud.size()), benchmark::Counter::kIsIterationInvariantRate);
}

void Whole(benchmark::State& state, Method method) {
  const auto options = Options(method);
  Measure(state, [&](const mesh::TriangleMesh& mesh, PointCloud& cloud) {
    cloud = Discretize({mesh}, options, {}).value().cloud;
  });
}

#define INTAGLIO_ON_THE_BUNNY Arg(40)->Arg(60)->Unit(benchmark::kMillisecond)
BENCHMARK(Sections)->INTAGLIO_ON_THE_BUNNY;
BENCHMARK(Fill)->INTAGLIO_ON_THE_BUNNY;
BENCHMARK(Rays)->INTAGLIO_ON_THE_BUNNY;
BENCHMARK_CAPTURE(Weld, sections, Method::kSections)->INTAGLIO_ON_THE_BUNNY;
BENCHMARK_CAPTURE(Weld, fill, Method::kFill)->INTAGLIO_ON_THE_BUNNY;
BENCHMARK_CAPTURE(Whole, sections, Method::kSections)->INTAGLIO_ON_THE_BUNNY;
BENCHMARK_CAPTURE(Whole, fill, Method::kFill)->INTAGLIO_ON_THE_BUNNY;
BENCHMARK_CAPTURE(Whole, rays, Method::kRays)->INTAGLIO_ON_THE_BUNNY;

}  // namespace
