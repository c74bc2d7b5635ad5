#include "services/virtual_engraver/axes/virtual_axes.h"

#include <algorithm>
#include <cmath>

namespace intaglio::virtual_engraver {
namespace {

// At 10 m/s^2 an axis that turns within it goes back by 0.05 um before the end.
constexpr double kTurnS = 1e-4;

}  // namespace

VirtualAxes::VirtualAxes(const VirtualAxesOptions& options, const Vec3& at_mm)
    : mechanics_(options.mechanics, at_mm),
      backlash_(options.backlash_mm, at_mm),
      repeatability_(options.repeatability_mm, options.repeatability_seed) {
  if (const auto undisturbed = Undisturbed(options.mechanics))
    expected_.emplace(*undisturbed, at_mm);
  if (options.vibration) vibration_.emplace(*options.vibration, at_mm);
}

void VirtualAxes::Follow(const CubicCommand& command, double from_s, double to_s) {
  if (expected_) expected_->Follow(command, from_s, to_s);
  if (backlash_.none() && !vibration_) return mechanics_.Follow(command, from_s, to_s);
  // In steps so short that an axis turns at most at their ends.
  const int steps = std::max(1, static_cast<int>(std::ceil((to_s - from_s) / kTurnS)));
  const double step_s = (to_s - from_s) / steps;
  for (int i = 0; i < steps; ++i) {
    mechanics_.Follow(command, from_s + i * step_s, from_s + (i + 1) * step_s);
    backlash_.Follow(mechanics_.actual_mm());
    if (vibration_ && step_s > 0) vibration_->Follow(mechanics_.actual_mm(), step_s);
  }
}

std::optional<Vec3> VirtualAxes::expected_mm() const {
  return expected_ ? std::optional(expected_->actual_mm()) : std::nullopt;
}

Vec3 VirtualAxes::BesideMm(double done_ratio) const {
  Vec3 beside_mm = repeatability_.DeviationMm(done_ratio);
  if (!backlash_.none()) beside_mm += backlash_.carried_mm() - actual_mm();
  if (vibration_) beside_mm += vibration_->beside_mm();
  return beside_mm;
}

}  // namespace intaglio::virtual_engraver
