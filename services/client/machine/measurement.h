#pragma once

// What is wrong with a machine, from the folder of a job that made its test pattern and
// from where the marks lie.

#include <filesystem>

#include "engrave/calibrate/machine_fit.h"
#include "engrave/core/result.h"
#include "proto/machine_report.pb.h"
#include "services/client/machine/corrected_profile.h"
#include "services/client/machine/measured_marks.h"

namespace intaglio::client {

struct Measurement {
  MachineMeasurement report;
  CorrectedProfile corrected;
  std::vector<calibrate::PassedMark> marks;  ///< those that were matched
  calibrate::MachineFit fit;                 ///< of these
};

/// `folder`: of a job, with its frozen job and its path; how the marks were passed
/// follows from its plan. Errors: those of reading; kUnsupported for a machine whose axes
/// turn; those of MatchMarks and FitMachine.
Result<Measurement> MeasureMachine(const std::filesystem::path& folder,
                                   const MarksFile& marks);

}  // namespace intaglio::client
