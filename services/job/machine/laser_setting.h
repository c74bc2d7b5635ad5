#pragma once

// Pulse energy and the laser's setting, by LaserHead.energy_calibration: linear between
// the measured points.

#include <optional>

#include "proto/machine.pb.h"

namespace intaglio {

struct EnergyRange {
  double min_mj = 0, max_mj = 0;
};

/// The calibrated energies. nullopt: not calibrated.
std::optional<EnergyRange> EnergiesOf(const LaserHead& head);

/// What jobs may ask for. The frames of the laser line carry the energy, up to
/// pulse_energy_mj; a laser at an output of the motion controller has that energy alone,
/// unless its power is calibrated.
EnergyRange SettableEnergies(const MachineSpec& machine);

/// The setting, 0..1 of the largest, for a pulse of `energy_mj`; energies beyond those
/// measured get the setting of the nearest. nullopt: not calibrated.
std::optional<double> LaserSettingFor(const LaserHead& head, double energy_mj);

/// Of the profile, or the published ones.
double MaxPumpEnergy_j(const LaserPump& pump);
double MaxPumpPower_w(const LaserPump& pump);

}  // namespace intaglio
