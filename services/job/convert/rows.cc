#include "services/job/convert/rows.h"

#include <numbers>
#include <span>
#include <tuple>

#include "engrave/discretize/mesh/solid_lattice.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/methods/method_table.h"

namespace intaglio {
namespace {

constexpr double kRowRadPerDeg = std::numbers::pi / 180;
constexpr double kAlongXAndYDeg[] = {0, 90};

std::span<const double> RowTurnsDeg(const JobSpec& job) {
  if (FindLatticeDistance(job)) return discretize::kSolidRowTurnsDeg;
  return kAlongXAndYDeg;
}

}  // namespace

std::optional<double> FindLatticeDistance(const JobSpec& job) {
  std::optional<double> found_mm;
  for (const Model& model : job.models()) {
    const Method* method = MethodOf(model);
    if (method == nullptr || method->lattice_mm == nullptr) return std::nullopt;
    const double lattice_mm = method->lattice_mm(model);
    if (lattice_mm < job.discretization().min_spacing_mm()) return std::nullopt;
    if (lattice_mm != found_mm.value_or(lattice_mm)) return std::nullopt;
    found_mm = lattice_mm;
  }
  return found_mm;
}

double DefaultRowTurnDeg(const FrozenJob& job) {
  if (!job.machine().has_polar()) return 0;
  double chosen_deg = 0;
  FocusLimits best;
  for (const double turn_deg : RowTurnsDeg(job.job())) {
    const FocusLimits limits = GlassLimitsAlong(job, turn_deg * kRowRadPerDeg);
    if (std::tie(limits.speed_mm_s, limits.acceleration_mm_s2) <=
        std::tie(best.speed_mm_s, best.acceleration_mm_s2)) {
      continue;
    }
    best = limits;
    chosen_deg = turn_deg;
  }
  return chosen_deg;
}

}  // namespace intaglio
