#pragma once

// Whether a motor moves a screw axis: forces, inertias and torques of what is asked of it
// (Tirnovean 2016, ch. 4.1-4.3). SI units.

#include <span>

#include "engrave/drive/motor.h"

namespace intaglio::drive {

/// The inertia of the screw about its axis.
enum class CylinderRule {
  kSolid,          ///< rho L pi d^4 / 32, a solid cylinder
  kTirnovean2016,  ///< rho L pi d^4 / 16 as printed in (3.36): twice as much
};

struct ScrewAxis {
  double mass_kg = 0;                 ///< m, carried, >= 0
  double lead_m = 0;                  ///< p, > 0
  double friction_ratio = 0;          ///< mu of the guides, >= 0
  double efficiency_ratio = 1;        ///< eta of the screw, > 0..1
  double preload_torque_nm = 0;       ///< Mpr of bearings and nut, >= 0
  double screw_diameter_m = 0;        ///< d, >= 0
  double screw_length_m = 0;          ///< L, >= 0
  double screw_density_kg_m3 = 7800;  ///< steel
  double coupling_inertia_kg_m2 = 0;  ///< Jc, >= 0
};

struct AxisInertia {
  double screw_kg_m2 = 0;  ///< (3.36)
  double load_kg_m2 = 0;   ///< m (p / 2 pi)^2
  double total_kg_m2 = 0;  ///< with rotor and coupling, (4.15)
};
/// Throws PreconditionError when a value is outside the ranges above.
AxisInertia InertiaOf(const ScrewAxis& axis, const Motor& motor, CylinderRule rule);

/// What a motor's torque gives with nothing but an inertia to turn; (4.9), (4.10),
/// (4.16), (4.17).
struct TorqueAcceleration {
  double rad_s2 = 0, m_s2 = 0;
};
TorqueAcceleration AccelerationBy(double torque_nm, double inertia_kg_m2, double lead_m);

/// A part of what an axis has to do, again and again.
struct DemandPhase {
  double duration_s = 0;         ///< >= 0
  double acceleration_m_s2 = 0;  ///< of the axis
  double force_n = 0;            ///< of the process, against the motion
};

struct TorqueDemand {
  double angular_acceleration_rad_s2 = 0;  ///< (4.18), (4.19)
  double friction_torque_nm = 0;           ///< guides, force of the process and preload
  double inertia_torque_nm =
      0;  ///< the carried mass through eta, by which braking loses too; the rest directly
  double torque_nm = 0;  ///< both
  double current_a = 0;
  /// As in the source, (4.11), (4.20), (4.22), where the acceleration of the carried mass
  /// is in both parts.
  double static_torque_2016_nm = 0, dynamic_torque_2016_nm = 0, torque_2016_nm = 0;
};
TorqueDemand DemandOf(const ScrewAxis& axis, const Motor& motor, CylinderRule rule,
                      const DemandPhase& phase);

struct MotorSize {
  AxisInertia inertia;
  TorqueAcceleration unloaded;  ///< the rotor alone, by the rated torque
  TorqueAcceleration loaded;
  double peak_torque_nm = 0, rms_torque_nm = 0;
  double peak_current_a = 0, rms_current_a = 0;
  double rated_margin_ratio = 0;  ///< rated over rms torque: above 1 it does not overheat
  double peak_margin_ratio = 0;   ///< peak current of the motor over that of the demand
};
/// `phases` are repeated; those of no duration count for the peak alone. Not empty.
MotorSize SizeMotor(const ScrewAxis& axis, const Motor& motor, CylinderRule rule,
                    std::span<const DemandPhase> phases);

}  // namespace intaglio::drive
