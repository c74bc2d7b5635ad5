#pragma once

// What the driver of a scan head needs of a machine profile (MachineSpec.scan_head).

#include <optional>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/galvo/correction_table.h"
#include "proto/machine.pb.h"

namespace intaglio::drivers {

inline constexpr double kDefaultAheadMs = 40;

/// Each error begins with the field.
std::vector<Error> CheckScanHead(const MachineSpec& machine);

/// The table of scan_head.correction_file; nothing when there is none. Errors begin with
/// "scan_head.correction_file".
Result<std::optional<galvo::CorrectionTable>> LoadCorrection(const ScanHead& head);

}  // namespace intaglio::drivers
