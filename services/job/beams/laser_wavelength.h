#pragma once

// The wavelength of a job on a laser that has several. Everything that depends on it
// (index of the glass, aperture of a focus, energies) reads LaserHead.wavelength_nm and
// what belongs to it in a machine that ForWavelengthOf has made; a FrozenJob holds such a
// machine.

#include <vector>

#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/machine/laser_setting.h"

namespace intaglio {

/// Whether two values, nm, name one laser line. They may differ by less than 0.5 nm: a
/// profile may give 532 for 532.1.
bool IsSameWavelength(double a_nm, double b_nm);

/// The wavelength of the head first, then the further ones, nm.
std::vector<double> WavelengthsOf(const LaserHead& head);

/// The machine with its laser at the wavelength of the job: that one, its pulse energy
/// and its pulse duration are the head's own, and what they replace is one of
/// further_wavelengths, which are in growing order. A job that names no wavelength, or
/// one that the laser does not have (CheckLaserOn refuses it), gets the head's own. The
/// same from each machine that it returns for a profile.
MachineSpec ForWavelengthOf(const LaserOptions& laser, MachineSpec machine);
/// At a wavelength of a value, nm.
MachineSpec ForWavelength(double wavelength_nm, MachineSpec machine);

/// The smallest and the largest of the pulse energies that the wavelengths have at full
/// power: those of a laser without a setting.
EnergyRange FullEnergiesOf(const LaserHead& head);

}  // namespace intaglio
