#pragma once

// The parameters of a drive from a record of its command and its position: those whose
// answer to the command is nearest to the record, in the sum of squares.

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/drive/drive.h"

namespace intaglio::drive {

/// One sample of an axis; the command goes straight from sample to sample.
struct DriveSample {
  double time_s = 0;  ///< growing
  double command_u = 0, position_u = 0;
};

/// A piece of a command, and where the axis was at its end if that was measured.
struct DriveStep {
  Cubic command;
  double duration_s = 0;  ///< > 0
  std::optional<double> position_u;
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

/// The pieces of a record. kInvalidValue: times that do not grow, values that are no
/// numbers.
Result<std::vector<DriveStep>> StepsOf(std::span<const DriveSample> record);

/// `kind`: a name of DriveKinds (drive_kinds.h). The axis is at rest on its command at
/// the first sample. kNotFound: no such kind. kInvalidValue: fewer than ten samples,
/// times that do not grow, values that are no numbers, a command that does not move, or a
/// record that does not determine the parameters.
Result<Identification> Identify(std::string_view kind,
                                std::span<const DriveSample> record);
/// The same of a command in pieces, one behind the other: ten measured positions or more.
Result<Identification> Identify(std::string_view kind, std::span<const DriveStep> steps);

}  // namespace intaglio::drive
