#pragma once

// Fills in what a machine profile left open, as documented in proto/machine.proto. Values
// that are given stay as they are, right or wrong.

#include "proto/machine.pb.h"

namespace intaglio {

MachineSpec WithMachineDefaults(MachineSpec machine);

/// The rate of a job that names none; 0: the laser has no rates.
double DefaultRateHz(const LaserHead& head);

}  // namespace intaglio
