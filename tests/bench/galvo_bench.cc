// What a tick of a scan head costs: one look-up of the correction, both axes, by the kind
// of interpolation, at places along a path that crosses the whole field.

#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "engrave/galvo/correction_table.h"

namespace intaglio::galvo {
namespace {

std::vector<Vec2> PathOverField() {
  std::vector<Vec2> path;
  for (int i = 0; i < 100'000; ++i)
    path.emplace_back(49 * std::sin(0.0137 * i), 49 * std::sin(0.0091 * i + 1));
  return path;
}

void Correct(benchmark::State& state, Interpolation interpolation) {
  FieldGrid grid = CentredGrid(100, 65);
  for (int j = 0; j < grid.nodes; ++j) {
    for (int i = 0; i < grid.nodes; ++i) {
      const Vec2 at_mm = grid.PlaceOf(i, j);
      grid.values_mm[grid.IndexOf(i, j)] = 2e-5 * at_mm.squaredNorm() * at_mm;
    }
  }
  const auto table = CorrectionTable::Make(std::move(grid), interpolation).value();
  const std::vector<Vec2> path_mm = PathOverField();
  for (auto run : state) {
    Vec2 sum = Vec2::Zero();
    for (const Vec2& place_mm : path_mm) sum += table.At(place_mm);
    benchmark::DoNotOptimize(sum);
  }
  state.counters["ns_a_place"] =
      benchmark::Counter(1e-9 * static_cast<double>(path_mm.size()) *
                             static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

BENCHMARK_CAPTURE(Correct, four_triangles, Interpolation::kFourTriangles);
BENCHMARK_CAPTURE(Correct, bilinear, Interpolation::kBilinear);
BENCHMARK_CAPTURE(Correct, spline, Interpolation::kSpline);

}  // namespace
}  // namespace intaglio::galvo
