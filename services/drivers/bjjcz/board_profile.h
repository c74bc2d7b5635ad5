#pragma once

// What the driver of BJJCZ boards needs of a machine profile, and what a board is set up
// with by it.

#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"
#include "services/drivers/bjjcz/lmc_protocol.h"

namespace intaglio::drivers {

/// bjjcz_board with its laser and door_input; scan_head with field_mm and jump_mm_s, and
/// nothing of a head that is driven tick by tick; its correction_file, a .cor file of the
/// same field. Each error begins with the field.
std::vector<Error> CheckBjjczProfile(const MachineSpec& machine);

/// The same of a machine that makes points in glass, whose motion_line it is:
/// head_over_block with jump_and_dwell, the width of the field, the steps of z, and how
/// many points a list may have.
std::vector<Error> CheckBjjczPointProfile(const MachineSpec& machine);

/// From any state of the board: dark, its list empty, its outputs off, then correction,
/// laser and delays as EzCad 2 sets them. Errors: those of the correction file.
Result<std::vector<LmcCommand>> BoardSetUp(const MachineSpec& machine);

}  // namespace intaglio::drivers
