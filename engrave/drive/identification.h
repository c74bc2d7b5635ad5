#pragma once

// The parameters of a drive from a record of its command and its position: those whose
// answer to the command is nearest to the record, in the sum of squares.

#include <span>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::drive {

/// One sample of an axis; the command goes straight from sample to sample.
struct DriveSample {
  double time_s = 0;  ///< growing
  double command_u = 0, position_u = 0;
};

/// The value is within value +- interval95 with 95 % probability, if the noise of the
/// record is white.
struct IdentifiedParameter {
  std::string_view name;  ///< of the kind's parameter
  double value = 0, interval95 = 0;
};

struct Identification {
  std::vector<IdentifiedParameter> parameters;  ///< in the order of the kind's
  double rms_residual_u = 0;
  int iterations = 0;
};

/// `kind`: a name of DriveKinds (drive_kinds.h). The axis is at rest on its command at
/// the first sample. kNotFound: no such kind. kInvalidValue: fewer than ten samples,
/// times that do not grow, values that are no numbers, a command that does not move, or a
/// record that does not determine the parameters.
Result<Identification> Identify(std::string_view kind,
                                std::span<const DriveSample> record);

}  // namespace intaglio::drive
