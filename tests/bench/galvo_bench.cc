// What a tick of a scan head costs: one look-up of the correction, both axes, by the kind
// of interpolation, at places along a path that crosses the whole field; and how many
// times faster than real time strokes become outputs, with everything.

#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "engrave/galvo/correction_table.h"
#include "engrave/galvo/head_output.h"
#include "engrave/galvo/web_follower.h"

namespace intaglio::galvo {
namespace {

std::vector<Vec2> PathOverField() {
  std::vector<Vec2> path;
  for (int i = 0; i < 100'000; ++i)
    path.emplace_back(49 * std::sin(0.0137 * i), 49 * std::sin(0.0091 * i + 1));
  return path;
}

CorrectionTable CubicTable(Interpolation interpolation) {
  FieldGrid grid = CentredGrid(100, 65);
  for (int j = 0; j < grid.nodes; ++j) {
    for (int i = 0; i < grid.nodes; ++i) {
      const Vec2 at_mm = grid.PlaceOf(i, j);
      grid.values_mm[grid.IndexOf(i, j)] = 2e-5 * at_mm.squaredNorm() * at_mm;
    }
  }
  return CorrectionTable::Make(std::move(grid), interpolation).value();
}

void Correct(benchmark::State& state, Interpolation interpolation) {
  const CorrectionTable table = CubicTable(interpolation);
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

/// Circles of 1 mm at 1.5 m/s on a web of 0.2 m/s: ticks that lead the servo, encoder and
/// edge followed, corrected by a spline, rounded.
void MakeOutputs(benchmark::State& state) {
  const CorrectionTable table = CubicTable(Interpolation::kSpline);
  std::vector<MarkStroke> strokes;
  for (int n = 0; n < 200; ++n) {
    MarkStroke circle{{}, true};
    for (int k = 0; k < 120; ++k) {
      const double a = 0.052359877559829886 * k;
      circle.points_mm.emplace_back(20 * std::sin(1.7 * n) + 0.5 * std::cos(a),
                                    20 * std::cos(2.3 * n) + 0.5 * std::sin(a));
    }
    strokes.push_back(circle);
  }
  MarkTickOptions options;
  options.mark_mm_s = 1500, options.jump_mm_s = 5000, options.run_in_s = 6e-4;
  options.lag_s = 2e-4, options.lead_servo = true;
  WebFollowerOptions web;
  web.preview_s = options.lag_s, web.edge_sensor_upstream_mm = 50;
  double seconds = 0;
  for (auto run : state) {
    const auto ticks = MakeMarkTicks(strokes, {0, 0}, options).value();
    WebFollower follower(web, 0, 200);
    OutputMaker outputs(100, &table);
    std::uint32_t sum = 0;
    for (std::size_t k = 0; k < ticks.size(); ++k) {
      const auto count =
          static_cast<std::int64_t>(static_cast<double>(k) * 0.002 / 0.023);
      const HeadOutput out = outputs.Make(ticks[k], follower.Update(count, 0.1));
      sum += out.x + out.y + out.laser;
    }
    benchmark::DoNotOptimize(sum);
    seconds += static_cast<double>(ticks.size()) / options.rate_hz;
  }
  state.counters["times_real_time"] =
      benchmark::Counter(seconds, benchmark::Counter::kIsRate);
}

BENCHMARK(MakeOutputs);
BENCHMARK_CAPTURE(Correct, four_triangles, Interpolation::kFourTriangles);
BENCHMARK_CAPTURE(Correct, bilinear, Interpolation::kBilinear);
BENCHMARK_CAPTURE(Correct, spline, Interpolation::kSpline);

}  // namespace
}  // namespace intaglio::galvo
