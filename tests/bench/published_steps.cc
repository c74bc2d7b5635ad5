// The 53 measured times of the published machine against several models of a step, as
// markdown: for each the lengths of steps are fitted that explain the times best, with
// the published spacing of either lens as the shortest (tests/engrave/motion/
// published_steps.h). `published_steps --lengths` prints the lengths of the last model.

#include "tests/engrave/motion/published_steps.h"

#include <fmt/format.h>

#include <iostream>
#include <span>
#include <string_view>

namespace intaglio::motion {
namespace {

struct NamedModel {
  const char* name;
  StepModel model;
};

constexpr NamedModel kModels[] = {
    {"a stop at each point, whole ticks", {}},
    {"with 1 ms of settling", {.settling_s = 0.001}},
    {"with 3 ms of settling", {.settling_s = 0.003}},
    {"in cycles of 0.2 ms", {.cycle_s = 0.0002}},
    {"in cycles of 2 ms", {.cycle_s = 0.002}},
    {"the pulse when the stage arrives, not at a tick", {.whole_ticks = false}},
    {"the pulse within 10 um of the point", {.window_mm = 0.010}},
    {"within 15 um", {.window_mm = 0.015}},
    {"within 30 um", {.window_mm = 0.030}},
    {"within 40 um", {.window_mm = 0.040}},
    {"within 50 um", {.window_mm = 0.050}},
    {"within 50 um, with 0.5 ms of settling", {.window_mm = 0.050, .settling_s = 0.0005}},
};

int RowsBeyond(const StepFit& fit, double limit_s) {
  int count = 0;
  for (const double off_s : fit.difference_s) count += std::abs(off_s) > limit_s ? 1 : 0;
  return count;
}

void PrintModels() {
  const auto rows = MeasuredTimes();
  std::cout << "| shortest step, mm | a step | rms, s | largest, s | rows beyond 1 s |\n"
               "|---|---|---|---|---|\n";
  for (const double min_mm : {0.02, 0.09, 0.13}) {
    for (const NamedModel& named : kModels) {
      const StepFit fit = FitSteps(named.model, min_mm, rows);
      std::cout << fmt::format("| {:g} | {} | {:.2f} | {:.1f} | {} |\n", min_mm,
                               named.name, fit.rms_s, fit.largest_s, RowsBeyond(fit, 1));
    }
  }
}

void PrintLengths() {
  const StepFit fit = FitSteps({.window_mm = 0.030}, 0.09, MeasuredTimes());
  std::cout << "length_mm,share\n";
  for (const StepShare& step : fit.steps)
    std::cout << fmt::format("{:.4f},{:.5f}\n", step.distance_mm, step.share);
}

}  // namespace
}  // namespace intaglio::motion

int main(int argc, char** argv) {
  const auto arguments = std::span(argv, static_cast<std::size_t>(argc)).subspan(1);
  if (!arguments.empty() && std::string_view(arguments[0]) == "--lengths") {
    intaglio::motion::PrintLengths();
  } else {
    intaglio::motion::PrintModels();
  }
  return 0;
}
