#pragma once

// What a device of LightBurn says about a machine, in the machine's profile.

#include <string>
#include <vector>

#include "proto/machine.pb.h"
#include "services/job/files/lightburn_device.h"

namespace intaglio {

/// Sets of a profile with a BJJCZ board:
///   scan_head.field_mm       the workspace over its scale, the mean of both axes
///   x, y travel              over a block: the workspace, as far as the field has it
///   scan_head.jump_mm_s, head_over_block.jump_and_dwell.jump_mm_s
///   bjjcz_board.point_frequency_hz   moved into the laser's range
/// A board has 65536 units for field_mm. A sentence for each, "field = value: of what".
/// The profile is not checked. kInvalidValue: the profile has no BJJCZ board, which is
/// not changed then; kUnsupported: the fields of both axes differ by more than 2 %, which
/// one field_mm cannot hold.
Result<std::vector<std::string>> ApplyDevice(const LightBurnDevice& device,
                                             MachineSpec& machine);

}  // namespace intaglio
