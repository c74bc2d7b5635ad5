// How fast the motion without a stop is planned and how many of the lamp's ticks it uses,
// beside the motion that stops at each point (profile mix), on one path, in one run. By
// path, limits and rate of the lamp. A plan that breaks a limit is an error.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <array>
#include <memory>

#include "engrave/motion/planner.h"
#include "engrave/motion/point_plan.h"
#include "engrave/sort/order.h"
#include "tests/engrave/motion/paths.h"
#include "tests/engrave/motion/verified_motion.h"
#include "tests/engrave/sort/clouds.h"

namespace intaglio::motion {
namespace {

struct NamedPath {
  std::string name;
  PointList points_mm;
};

struct NamedLimits {
  double speed_mm_s, acceleration_mm_s2;
};

constexpr std::array kRatesHz = {50, 100, 200, 500, 1000, 4000};
// The published machine over its range, and a fast one.
constexpr std::array kLimits = {NamedLimits{80, 2000}, NamedLimits{80, 5000},
                                NamedLimits{80, 7000}, NamedLimits{80, 10000},
                                NamedLimits{1000, 20000}};

std::vector<NamedPath> Paths() {
  std::vector<NamedPath> paths;
  if (PointList published = FittedPoints("calibrated_ordered"); !published.empty()) {
    paths.push_back({"published order", std::move(published)});
  }
  const PointList cloud = sort::RandomBox(20000, {20, 20, 20}, 1);
  const sort::Order order = sort::MakeOrder(cloud, {}).value();
  PointList scatter;
  for (const std::uint32_t i : order) scatter.push_back(cloud[i]);
  paths.push_back({"random scatter", std::move(scatter)});
  paths.push_back({"sphere contours", SphereContours(10, 0.2, 0.2)});
  return paths;
}

void Measure(benchmark::State& state, const PointList& path_mm, PlanOptions options) {
  options.continuous = false;
  const auto report_of = [&](const std::vector<Segment>& segments) {
    return VerifyMotion({path_mm.front(), Vec3::Zero()}, segments, path_mm,
                        options.limits, options.rate_hz);
  };
  const MotionReport stopping = report_of(PlanPoints(options, path_mm));
  options.continuous = true;
  std::vector<Segment> segments;
  for (auto _ : state) {
    segments = PlanPoints(options, path_mm);
    benchmark::DoNotOptimize(segments.data());
  }
  const MotionReport passing = report_of(segments);
  if (!passing.ok()) return state.SkipWithError(passing.violations.front().c_str());
  if (!stopping.ok()) return state.SkipWithError(stopping.violations.front().c_str());
  const auto count = static_cast<double>(path_mm.size());
  state.counters["points"] = count;
  state.counters["points/s"] =
      benchmark::Counter(count, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["utilisation"] = UtilisationRatio(passing);
  state.counters["with a stop"] = UtilisationRatio(stopping);
  state.counters["times faster"] =
      static_cast<double>(stopping.ticks) / static_cast<double>(passing.ticks);
}

const int kRegistered = [] {
  static const std::vector<NamedPath> paths = Paths();
  for (const NamedPath& path : paths) {
    for (const NamedLimits& limits : kLimits) {
      for (const int rate_hz : kRatesHz) {
        PlanOptions options;
        options.limits.max_speed_mm_s.setConstant(limits.speed_mm_s);
        options.limits.max_acceleration_mm_s2.setConstant(limits.acceleration_mm_s2);
        options.rate_hz = rate_hz;
        const std::string name =
            fmt::format("motion/{}, {:g} mm/s, {:g} m/s^2, {} Hz", path.name,
                        limits.speed_mm_s, limits.acceleration_mm_s2 / 1000, rate_hz);
        benchmark::RegisterBenchmark(name.c_str(), [&path,
                                                    options](benchmark::State& state) {
          Measure(state, path.points_mm, options);
        })->Unit(benchmark::kMillisecond);
      }
    }
  }
  return 0;
}();

}  // namespace
}  // namespace intaglio::motion
