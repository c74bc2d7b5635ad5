#include "engrave/drive/sizing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/core/check.h"
#include "engrave/core/geometry.h"

namespace intaglio::drive {
namespace {

constexpr double kGravityMS2 = 9.81;  // as in the source

void Check(const ScrewAxis& axis, const Motor& motor) {
  Require(axis.mass_kg >= 0 && axis.lead_m > 0 && axis.friction_ratio >= 0 &&
              axis.efficiency_ratio > 0 && axis.efficiency_ratio <= 1,
          "an axis of {} kg with a lead of {} m, friction {} and efficiency {}",
          axis.mass_kg, axis.lead_m, axis.friction_ratio, axis.efficiency_ratio);
  Require(motor.inertia_kg_m2 > 0 && motor.torque_constant_nm_a > 0 &&
              motor.rated_torque_nm > 0,
          "a motor of {} kg m^2, {} Nm/A and {} Nm", motor.inertia_kg_m2,
          motor.torque_constant_nm_a, motor.rated_torque_nm);
}

}  // namespace

AxisInertia InertiaOf(const ScrewAxis& axis, const Motor& motor, CylinderRule rule) {
  Check(axis, motor);
  const double metres = axis.lead_m / kTwoPi;
  AxisInertia inertia;
  inertia.screw_kg_m2 = axis.screw_density_kg_m3 * axis.screw_length_m *
                        std::numbers::pi * std::pow(axis.screw_diameter_m, 4) /
                        (rule == CylinderRule::kSolid ? 32 : 16);
  inertia.load_kg_m2 = axis.mass_kg * metres * metres;
  inertia.total_kg_m2 = motor.inertia_kg_m2 + axis.coupling_inertia_kg_m2 +
                        inertia.screw_kg_m2 + inertia.load_kg_m2;
  return inertia;
}

TorqueAcceleration AccelerationBy(double torque_nm, double inertia_kg_m2, double lead_m) {
  const double rad_s2 = torque_nm / inertia_kg_m2;
  return {rad_s2, rad_s2 * lead_m / kTwoPi};
}

TorqueDemand DemandOf(const ScrewAxis& axis, const Motor& motor, CylinderRule rule,
                      const DemandPhase& phase) {
  const AxisInertia inertia = InertiaOf(axis, motor, rule);
  const double metres = axis.lead_m / kTwoPi;
  const double rub_n = axis.mass_kg * axis.friction_ratio * kGravityMS2 + phase.force_n;
  const double a = phase.acceleration_m_s2;
  TorqueDemand demand;
  demand.angular_acceleration_rad_s2 = a / metres;
  demand.friction_torque_nm =
      rub_n * metres / axis.efficiency_ratio + axis.preload_torque_nm;
  // A mass that is braked gives its share back through the screw.
  const double of_load_kg_m2 = a < 0 ? inertia.load_kg_m2 * axis.efficiency_ratio
                                     : inertia.load_kg_m2 / axis.efficiency_ratio;
  demand.inertia_torque_nm = demand.angular_acceleration_rad_s2 *
                             (of_load_kg_m2 + inertia.total_kg_m2 - inertia.load_kg_m2);
  demand.torque_nm = demand.friction_torque_nm + demand.inertia_torque_nm;
  demand.current_a = demand.torque_nm / motor.torque_constant_nm_a;
  demand.static_torque_2016_nm =
      (rub_n + axis.mass_kg * a) * metres / axis.efficiency_ratio +
      axis.preload_torque_nm;
  demand.dynamic_torque_2016_nm =
      inertia.total_kg_m2 * demand.angular_acceleration_rad_s2;
  demand.torque_2016_nm = demand.static_torque_2016_nm + demand.dynamic_torque_2016_nm;
  return demand;
}

MotorSize SizeMotor(const ScrewAxis& axis, const Motor& motor, CylinderRule rule,
                    std::span<const DemandPhase> phases) {
  Require(!phases.empty(), "a motor without a demand");
  MotorSize size;
  size.inertia = InertiaOf(axis, motor, rule);
  size.unloaded = AccelerationBy(motor.rated_torque_nm, motor.inertia_kg_m2, axis.lead_m);
  size.loaded =
      AccelerationBy(motor.rated_torque_nm, size.inertia.total_kg_m2, axis.lead_m);
  double duration_s = 0, heat = 0;
  for (const DemandPhase& phase : phases) {
    Require(phase.duration_s >= 0, "a phase of {} s", phase.duration_s);
    const double torque_nm = std::abs(DemandOf(axis, motor, rule, phase).torque_nm);
    size.peak_torque_nm = std::max(size.peak_torque_nm, torque_nm);
    heat += phase.duration_s * torque_nm * torque_nm;
    duration_s += phase.duration_s;
  }
  size.rms_torque_nm = duration_s > 0 ? std::sqrt(heat / duration_s) : 0;
  size.peak_current_a = size.peak_torque_nm / motor.torque_constant_nm_a;
  size.rms_current_a = size.rms_torque_nm / motor.torque_constant_nm_a;
  if (size.rms_torque_nm > 0)
    size.rated_margin_ratio = motor.rated_torque_nm / size.rms_torque_nm;
  if (size.peak_current_a > 0)
    size.peak_margin_ratio = motor.peak_current_a / size.peak_current_a;
  return size;
}

}  // namespace intaglio::drive
