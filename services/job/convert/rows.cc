#include "services/job/convert/rows.h"

#include <algorithm>
#include <numbers>
#include <span>
#include <tuple>

#include "engrave/discretize/mesh/solid_lattice.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/methods/method_table.h"
#include "services/platform/fields/field_rules.h"

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

void FillRows(BoustrophedonOrder& rows, const JobSpec& job) {
  double layer_mm = job.discretization().min_spacing_mm(), row_mm = layer_mm;
  if (const auto lattice_mm = FindLatticeDistance(job)) {
    const double thickest_mm =
        RangeOf<BoustrophedonOrder>(BoustrophedonOrder::kLayerThicknessMmFieldNumber).max;
    layer_mm = std::min(thickest_mm, discretize::SolidLayerRatio() * *lattice_mm *
                                         job.discretization().height_ratio());
    row_mm = discretize::SolidRowRatio() * *lattice_mm;
  }
  if (!rows.has_layer_thickness_mm()) rows.set_layer_thickness_mm(layer_mm);
  if (!rows.has_row_width_mm()) rows.set_row_width_mm(row_mm);
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

sort::BoustrophedonOptions RowOptionsOf(const FrozenJob& job,
                                        const BoustrophedonOrder& rows) {
  const double turn_deg =
      rows.has_row_turn_deg() ? rows.row_turn_deg() : DefaultRowTurnDeg(job);
  return {rows.layer_thickness_mm(), rows.row_width_mm(), turn_deg * kRowRadPerDeg};
}

}  // namespace intaglio
