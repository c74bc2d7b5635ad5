#include "services/job/machine/job_ticks_bound.h"

#include <algorithm>
#include <utility>

#include "engrave/sort/ticks_bound.h"
#include "services/job/machine/machine_axes.h"

namespace intaglio {

std::optional<std::uint64_t> JobTicksBound(const MachineSpec& machine, PointList axes,
                                           const motion::PlanOptions& plan,
                                           const Executor& executor) {
  const auto kinds = KinematicsOf(machine)->axes();
  const bool turns = std::any_of(kinds.begin(), kinds.end(), [](const auto& axis) {
    return axis.unit == machine::AxisUnit::kRad;
  });
  if (axes.empty() || turns) return std::nullopt;
  return 1 +
         sort::TicksBound(std::move(axes), {plan.limits, plan.rate_hz,
                                            plan.tolerance_mm + plan.sweep_mm, executor});
}

}  // namespace intaglio
