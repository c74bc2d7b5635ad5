#include "engrave/machine/beam_strength.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"

// A pulse of the energy E cracks the glass where E times the peak ratio is at least the
// energy that an upright beam needs. The smaller of both pupil distances gives the
// steeper beam, and so the radius that holds in every direction.

namespace intaglio::machine {

BeamStrength::BeamStrength(const BeamStrengthOptions& options) : options_(options) {
  Require(options.field_mm > 0 && options.crack_energy_mj > 0 && options.max_depth_mm > 0,
          "field_mm {}, crack_energy_mj {}, max_depth_mm {}", options.field_mm,
          options.crack_energy_mj, options.max_depth_mm);
  max_tangent_ = std::min(1.0, options.field_mm / options.lens.pupil_mm.minCoeff());
  if (!options.lens.is_telecentric())
    loss_.emplace(options.beam, options.max_depth_mm, max_tangent_);
}

// x = u + h t q / 2, with n h c q = the distance of the foci.
double BeamStrength::RadiusMm(double depth_mm, double tangent) const {
  const double index = options_.beam.refractive_index;
  const optics::LineFoci foci = optics::FociAtDepth(depth_mm, tangent, index);
  const double q = tangent * tangent * (1 - 1 / (index * index));
  const double below_mm = foci.sagittal_mm / (index * std::sqrt(1 + q));
  return options_.lens.pupil_mm.minCoeff() * tangent + 0.5 * below_mm * tangent * q;
}

double BeamStrength::UsableRadiusMm(double depth_mm, double energy_mj) const {
  if (energy_mj < options_.crack_energy_mj) return 0;
  if (!loss_) return options_.field_mm;
  return RadiusMm(depth_mm,
                  loss_->MaxTangent(depth_mm, options_.crack_energy_mj / energy_mj));
}

double BeamStrength::DoubleRadiusMm(double depth_mm) const {
  if (!loss_) return options_.field_mm;
  double low = 0, high = max_tangent_;
  if (!IsDouble(high, depth_mm)) return RadiusMm(depth_mm, high);
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (IsDouble(middle, depth_mm) ? high : low) = middle;
  }
  return RadiusMm(depth_mm, low);
}

double BeamStrength::TangentTo(const Vec2& from_axis_mm, double depth_mm) const {
  if (!loss_) return 0;
  constexpr double kToleranceMm = 1e-6;
  const auto solved =
      optics::PositionFor({from_axis_mm.x(), from_axis_mm.y(), depth_mm}, options_.lens,
                          options_.beam.refractive_index, kToleranceMm);
  return solved ? options_.lens.TangentAt(solved->head.field_mm) : 1;
}

double BeamStrength::RatioAt(double tangent, double depth_mm) const {
  return loss_ ? loss_->RatioAt(tangent, depth_mm) : 1;
}

double BeamStrength::EnergyTimes(double tangent, double depth_mm) const {
  const double excess = 1 / RatioAt(tangent, depth_mm) - 1;
  return 1 + excess * (1 + optics::ObliqueLoss::kMaxExcessError);
}

double BeamStrength::ApartMm(double tangent, double depth_mm) const {
  return optics::FociAtDepth(depth_mm, tangent, options_.beam.refractive_index)
      .apart_mm();
}

bool BeamStrength::IsDouble(double tangent, double depth_mm) const {
  return optics::HasTwoStrongFoci(options_.beam, ApartMm(tangent, depth_mm));
}

}  // namespace intaglio::machine
