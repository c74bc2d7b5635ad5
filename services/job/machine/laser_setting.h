#pragma once

// Pulse energy and the laser's setting, by LaserHead.energy_calibration: linear between
// the measured points.

#include <optional>

#include "proto/machine.pb.h"

namespace intaglio {

struct EnergyRange {
  double min_mj = 0, max_mj = 0;
};

/// nullopt: not calibrated.
std::optional<EnergyRange> EnergiesOf(const LaserHead& head);

/// The setting, 0..1 of the largest, for a pulse of `energy_mj`; energies beyond those
/// measured get the setting of the nearest. nullopt: not calibrated.
std::optional<double> LaserSettingFor(const LaserHead& head, double energy_mj);

}  // namespace intaglio
