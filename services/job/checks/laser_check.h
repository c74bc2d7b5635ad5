#pragma once

// Whether the laser of a machine makes the pulses that a job asks for.

#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/fields/findings.h"

namespace intaglio {

/// Rate, wavelength, pulse energy, pump power and channels. Both with their defaults.
void CheckLaserOn(const LaserOptions& laser, const MachineSpec& machine,
                  Findings& findings);

/// The pulse energies of models that name one.
void CheckEnergiesOn(const JobSpec& job, const MachineSpec& machine, Findings& findings);

}  // namespace intaglio
