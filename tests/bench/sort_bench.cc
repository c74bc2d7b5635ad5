// How long ordering and the shadow check take. Clouds: random points of a dented sphere's
// surface in random order, which is the worst for the caches; and the measured scatter
// cloud where it is at hand.

#include <benchmark/benchmark.h>

#include <fstream>
#include <sstream>
#include <string>

#include "engrave/sort/order.h"
#include "engrave/sort/shadow.h"
#include "engrave/sort/travel.h"
#include "tests/engrave/sort/clouds.h"

namespace intaglio::sort {
namespace {

constexpr double kConeTangent = 0.2;

const PointList& Sphere(std::size_t count) {
  static PointList points_mm;
  if (points_mm.size() != count) points_mm = DentedSphere(count, 1);
  return points_mm;
}

PointList Scatter() {
  std::ifstream file(INTAGLIO_SOURCE_DIR "/../shared/data/jobs/scatter.xyz");
  PointList points_mm;
  for (std::string line; std::getline(file, line);) {
    std::istringstream numbers(line);
    Vec3 p;
    if (numbers >> p.x() >> p.y() >> p.z()) points_mm.push_back(p);
  }
  return points_mm;
}

void Measure(benchmark::State& state, const PointList& points_mm,
             const OrderOptions& options) {
  Order order;
  for (auto _ : state) {
    order = MakeOrder(points_mm, options).value();
    benchmark::DoNotOptimize(order.data());
  }
  const auto count = static_cast<double>(points_mm.size());
  state.counters["points"] = count;
  state.counters["mm_per_point"] =
      MeasureTravel(points_mm, order).largest_axis_mm / count;
  state.counters["violations"] =
      static_cast<double>(CheckShadow(points_mm, order, kConeTangent).violations);
}

void KdzSphere(benchmark::State& state) {
  OrderOptions options;
  options.kdz.up_ratio = static_cast<double>(state.range(1)) / 100;
  Measure(state, Sphere(static_cast<std::size_t>(state.range(0))), options);
}
BENCHMARK(KdzSphere)
    ->ArgNames({"points", "K_percent"})
    ->Args({175000, 20})
    ->Args({175000, 60})
    ->Args({175000, 100})
    ->Args({2000000, 60})
    ->Unit(benchmark::kMillisecond);

void LayersSphere(benchmark::State& state) {
  OrderOptions options;
  options.method = Method::kLayers;
  Measure(state, Sphere(static_cast<std::size_t>(state.range(0))), options);
}
BENCHMARK(LayersSphere)
    ->ArgName("points")
    ->Arg(175000)
    ->Arg(2000000)
    ->Unit(benchmark::kMillisecond);

void KdzScatter(benchmark::State& state) {
  const PointList points_mm = Scatter();
  if (points_mm.empty()) return state.SkipWithError("no data");
  Measure(state, points_mm, {});
}
BENCHMARK(KdzScatter)->Unit(benchmark::kMillisecond);

void LayersScatter(benchmark::State& state) {
  const PointList points_mm = Scatter();
  if (points_mm.empty()) return state.SkipWithError("no data");
  OrderOptions options;
  options.method = Method::kLayers;
  options.layers.layer_thickness_mm = 0.5;
  Measure(state, points_mm, options);
}
BENCHMARK(LayersScatter)->Unit(benchmark::kMillisecond);

void ShadowSphere(benchmark::State& state) {
  const PointList& points_mm = Sphere(static_cast<std::size_t>(state.range(0)));
  PointList made_mm;
  const Order order = MakeOrder(points_mm, {}).value();
  for (const std::uint32_t i : order) made_mm.push_back(points_mm[i]);
  for (auto _ : state) {
    benchmark::DoNotOptimize(CountShadowViolations(made_mm, kConeTangent));
  }
}
BENCHMARK(ShadowSphere)
    ->ArgName("points")
    ->Arg(175000)
    ->Arg(400000)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace intaglio::sort
