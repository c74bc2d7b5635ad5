#pragma once

// Whether a task was made for this machine. The machine profile in a task comes from a
// file of the person who submitted the job; the synchronizer has a profile of its own and
// fires only what agrees with that.

#include <string>

#include "engrave/core/result.h"
#include "proto/task.pb.h"

namespace intaglio::synchronizer {

/// kRefused, with every difference by its field and both values, unless
/// - the machine frozen into the task is `own`, a field that it does not have being the
///   default: a job of an older version may not know of it. How lines are wired
///   (laser_line, motion_line) is not physics and not compared;
/// - the job's rate, lens, channels, wavelength, energy, limits and block are possible on
///   `own` (CheckJobOnMachine);
/// - the optical values are those of the job's wavelength, of its numerical aperture and
///   of their own refractive index, within 1e-9.
/// `own_file`: where `own` was read from, for the remedy.
Status CheckTask(const FrozenJob& task, const MachineSpec& own,
                 const std::string& own_file);

}  // namespace intaglio::synchronizer
