// The measured tables of the published machine beside ours, as markdown:
// - 53 machining times of one order (tests/data/published/els03_timings.csv): the model
//   of the machine, which stops at each point, and the motion that does not;
// - the sweep of the sort's angle (els03_sort_angle.csv) with the sort as published.
//
// The sweep's own cloud is not known; ours is that of the timings, taken apart and sorted
// anew. Nor is it printed how the angle makes K. The cost's level set about a point is a
// double cone of half angle atan K, so K = tan(angle) takes the angle from the axis, and
// K = tan(angle / 2) takes it as the whole opening; both are shown.

#include "tests/engrave/motion/published_tables.h"

#include <fmt/format.h>

#include <cmath>
#include <iostream>
#include <numbers>

#include "engrave/motion/planner.h"
#include "engrave/sort/order.h"
#include "tests/engrave/motion/paths.h"

namespace intaglio::motion {
namespace {

double PassingSeconds(const PointList& path_mm, const Limits& limits, double rate_hz) {
  const PlanOptions options{.limits = limits, .rate_hz = rate_hz, .continuous = true};
  const auto planner = MakePlanner(options, path_mm.front());
  std::vector<Segment> segments;
  for (const Vec3& p : path_mm) {
    planner->Append(p, -1, false, segments);
    segments.clear();
  }
  planner->Finish(segments);
  return static_cast<double>(planner->ticks()) / rate_hz;
}

void PrintTimes(const PointList& path_mm) {
  std::cout << "| Hz | mm/s | m/s^2 | measured, s | model, s | difference, s | without a "
               "stop, s |\n|---|---|---|---|---|---|---|\n";
  double square = 0, largest = 0;
  const auto times = MeasuredTimes();
  for (const MeasuredTime& row : times) {
    const Limits limits = LimitsOf(row);
    const double model_s = ModelSeconds(path_mm, limits, row.rate_hz);
    const double off_s = model_s - row.time_s;
    square += off_s * off_s;
    largest = std::max(largest, std::abs(off_s));
    std::cout << fmt::format(
        "| {:g} | {:g} | {:g} | {:g} | {:.2f} | {:+.2f} | {:.2f} |\n", row.rate_hz,
        row.speed_mm_s, row.acceleration_mm_s2 / 1000, row.time_s, model_s, off_s,
        PassingSeconds(path_mm, limits, row.rate_hz));
  }
  std::cout << fmt::format(
      "\n{} rows, difference {:.2f} s rms, {:.2f} s at most\n", times.size(),
      std::sqrt(square / static_cast<double>(times.size())), largest);
}

PointList SortedAsPublished(const PointList& cloud_mm, double k) {
  sort::OrderOptions options;
  options.method = sort::Method::kPublishedKdz;
  options.published_kdz = {k, k};
  const sort::Order order = sort::MakeOrder(cloud_mm, options).value();
  PointList path_mm;
  for (const std::uint32_t i : order) path_mm.push_back(cloud_mm[i]);
  return path_mm;
}

void PrintAngles(const PointList& cloud_mm) {
  std::cout << "\n| angle | measured, s | K = tan(angle), s | difference, s | "
               "K = tan(angle / 2), s | difference, s |\n|---|---|---|---|---|---|\n";
  for (const MeasuredAngle& row : MeasuredAngles()) {
    const double angle_rad = row.angle_deg * std::numbers::pi / 180;
    std::cout << fmt::format("| {:g} | {:g} |", row.angle_deg, row.time_s);
    for (const double k : {std::tan(angle_rad), std::tan(angle_rad / 2)}) {
      const double ours_s = ModelSeconds(SortedAsPublished(cloud_mm, k), Limits(), 100);
      std::cout << fmt::format(" {:.1f} | {:+.1f} |", ours_s, ours_s - row.time_s);
    }
    std::cout << std::endl;
  }
}

}  // namespace
}  // namespace intaglio::motion

int main() {
  const intaglio::PointList path_mm = intaglio::FittedPoints("calibrated_ordered");
  if (path_mm.empty() || intaglio::motion::MeasuredTimes().empty()) {
    std::cerr << "tests/data/published or tests/data/clouds has no tables or points\n";
    return 1;
  }
  intaglio::motion::PrintTimes(path_mm);
  intaglio::motion::PrintAngles(path_mm);
  return 0;
}
