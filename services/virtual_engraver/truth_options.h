#pragma once

// From a truth file to the machine's options.

#include "proto/truth.pb.h"
#include "services/virtual_engraver/machine.h"

namespace intaglio::virtual_engraver {

/// `truth` is checked (truth/truth_check.h). What it leaves out has the default of
/// MachineOptions. Speed, lockstep and numbers of this power-up are not of the truth.
MachineOptions OptionsOf(const MachineTruth& truth);

}  // namespace intaglio::virtual_engraver
