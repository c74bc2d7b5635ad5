// How long ordering and the shadow check take, and the quality of an order: the lamp's
// ticks that the motion without a stop uses on it, at the published machine's limits, and
// how far that is from a bound that no order is below (engrave/sort/ticks_bound.h).
// Clouds: random points of a dented sphere's surface in random order, which is the worst
// for the caches; sections of a vase; and the measured scatter cloud where it is at hand.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <atomic>
#include <thread>
#include <vector>

#include "engrave/motion/planner.h"
#include "engrave/sort/order.h"
#include "engrave/sort/shadow.h"
#include "engrave/sort/ticks_bound.h"
#include "engrave/sort/travel.h"
#include "tests/engrave/motion/paths.h"
#include "tests/engrave/sort/clouds.h"

namespace intaglio::sort {
namespace {

/// Lamps have this rate at most; for them the bound is derived.
constexpr double kMaxBoundHz = 4000;
/// The cone of a lens with numerical aperture 0.3 in N-BK7.
const BeamCone kCone(0.2);

PointList InOrder(const PointList& points_mm, const Order& order) {
  PointList made_mm;
  made_mm.reserve(order.size());
  for (const std::uint32_t i : order) made_mm.push_back(points_mm[i]);
  return made_mm;
}

/// At the limits of the order: as it begins, those of the published machine. z may pass
/// the points as far beside them as the order allows.
std::uint64_t TicksOf(const PointList& path_mm, const OrderOptions& order) {
  motion::PlanOptions options;
  options.limits = order.limits;
  options.rate_hz = order.rate_hz;
  options.continuous = true;
  if (order.method == Method::kSweep) options.sweep_mm = order.sweep.tolerance_mm;
  const auto planner = motion::MakePlanner(options, path_mm.front());
  std::vector<motion::Segment> segments;
  for (const Vec3& p : path_mm) {
    planner->Append(p, -1, false, segments);
    segments.clear();
  }
  planner->Finish(segments);
  return planner->ticks();
}

/// As the planner moves points by sweeping, they may lie elsewhere for the bound, too.
std::uint64_t BoundOf(const PointList& points_mm, const OrderOptions& order) {
  TicksBoundOptions options;
  options.limits = order.limits;
  options.rate_hz = order.rate_hz;
  if (order.method == Method::kSweep) options.tolerance_mm = order.sweep.tolerance_mm;
  return TicksBound(points_mm, options);
}

void Measure(benchmark::State& state, const PointList& points_mm,
             const OrderOptions& options) {
  Order order;
  for (auto _ : state) {
    order = MakeOrder(points_mm, options).value();
    benchmark::DoNotOptimize(order.data());
  }
  const auto count = static_cast<double>(points_mm.size());
  const PointList path_mm = InOrder(points_mm, order);
  state.counters["points"] = count;
  state.counters["points/s"] =
      benchmark::Counter(count, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["mm a point"] = MeasureTravel(points_mm, order).largest_axis_mm / count;
  state.counters["shadowed"] =
      static_cast<double>(CountShadowViolations(path_mm, options.cone));
  const auto ticks = static_cast<double>(TicksOf(path_mm, options));
  state.counters["utilisation"] = count / ticks;
  if (options.rate_hz <= kMaxBoundHz) {
    const auto bound = static_cast<double>(BoundOf(points_mm, options));
    state.counters["% above the bound"] = 100 * (ticks / bound - 1);
  }
}

struct NamedMethod {
  Method method;
  const char* name;
};

constexpr NamedMethod kMethods[] = {
    {Method::kKdz, "kdz"},
    {Method::kLayers, "layers"},
    {Method::kSmooth, "smooth"},
    {Method::kBoustrophedon, "boustrophedon"},
    {Method::kPublishedKdz, "published-kdz"},
    {Method::kAnneal, "anneal"},
};

void RegisterOrder(const std::string& name, const PointList& points_mm,
                   const OrderOptions& options) {
  benchmark::RegisterBenchmark(("order/" + name).c_str(),
                               [&points_mm, options](benchmark::State& state) {
                                 Measure(state, points_mm, options);
                               })
      ->Unit(benchmark::kMillisecond)
      ->MeasureProcessCPUTime()
      ->UseRealTime();
}

void RegisterShadow(const std::string& name, const PointList& points_mm) {
  benchmark::RegisterBenchmark(("shadow/" + name).c_str(), [&points_mm](
                                                               benchmark::State& state) {
    const PointList made_mm = InOrder(points_mm, MakeOrder(points_mm, {}).value());
    for (auto _ : state) {
      benchmark::DoNotOptimize(CountShadowViolations(made_mm, kCone));
    }
    const auto count = static_cast<double>(made_mm.size());
    state.counters["points"] = count;
    state.counters["points/s"] =
        benchmark::Counter(count, benchmark::Counter::kIsIterationInvariantRate);
  })->Unit(benchmark::kMillisecond);
}

/// On two threads.
void RunOnTwo(std::size_t count, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next = 0;
  const auto run = [&] {
    for (std::size_t i = next++; i < count; i = next++) work(i);
  };
  const std::jthread other(run);
  run();
}

/// Mirrors and the axis of the lens; two workers.
OrderOptions SweepOf(double rate_hz, double speed_mm_s) {
  OrderOptions options;
  options.method = Method::kSweep;
  options.sweep.tolerance_mm = options.sweep.slab_mm;
  options.cone = {0.02, 0.035, 0.15};
  options.rate_hz = rate_hz;
  options.limits.max_speed_mm_s = {speed_mm_s, speed_mm_s, 50};
  options.limits.max_acceleration_mm_s2 = {5e7, 5e7, 1000};
  options.executor = &RunOnTwo;
  return options;
}

const int kRegistered = [] {
  static const std::vector<NamedCloud> clouds = [] {
    std::vector<NamedCloud> made = {{"vase", SlicedVase(200, 0.1, 0.1)},
                                    {"sphere", DentedSphere(175000, 1)}};
    PointList scatter = FittedPoints("scatter");
    if (!scatter.empty()) made.push_back({"scatter", std::move(scatter)});
    return made;
  }();
  static const PointList large = DentedSphere(2000000, 1);
  // A scan head over a block: slabs of 50 um.
  static const PointList box = RandomBox(100000, {50, 50, 50}, 3);
  static const PointList full_box = RandomBox(1000000, {50, 50, 50}, 3);
  for (const double rate_hz : {2000.0, 4000.0, 10000.0}) {
    for (const double speed_mm_s : {8000.0, 30000.0}) {
      RegisterOrder(
          fmt::format("sweep, box, {:g} Hz, {:g} m/s", rate_hz, 1e-3 * speed_mm_s), box,
          SweepOf(rate_hz, speed_mm_s));
    }
  }
  RegisterOrder("sweep, full box, 4000 Hz, 8 m/s", full_box, SweepOf(4000, 8000));
  for (const NamedCloud& cloud : clouds) {
    for (const double rate_hz : {100, 200}) {
      for (const auto& [method, method_name] : kMethods) {
        OrderOptions options;
        options.method = method;
        options.cone = kCone;
        options.rate_hz = rate_hz;
        RegisterOrder(fmt::format("{}, {}, {:g} Hz", method_name, cloud.name, rate_hz),
                      cloud.points_mm, options);
      }
    }
  }
  for (const double up_ratio : {0.2, 1.0}) {
    OrderOptions options;
    options.cone = kCone;
    options.kdz.up_ratio = up_ratio;
    RegisterOrder(fmt::format("kdz K = {:g}, sphere, 100 Hz", up_ratio),
                  clouds[1].points_mm, options);
  }
  OrderOptions of_large;
  of_large.cone = kCone;
  RegisterOrder("kdz, large sphere, 100 Hz", large, of_large);
  for (const NamedCloud& cloud : clouds) RegisterShadow(cloud.name, cloud.points_mm);
  return 0;
}();

}  // namespace
}  // namespace intaglio::sort
