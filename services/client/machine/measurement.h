#pragma once

// What is wrong with a machine, from the folder of a job that made its test pattern and
// from where the marks lie.

#include "engrave/calibrate/machine_fit.h"
#include "engrave/core/result.h"
#include "proto/machine_report.pb.h"
#include "services/client/machine/corrected_profile.h"
#include "services/client/machine/measured_marks.h"
#include "services/client/proof/evidence/proof_evidence.h"

namespace intaglio::client {

struct Measurement {
  MachineMeasurement report;
  CorrectedProfile corrected;
  std::vector<calibrate::PassedMark> marks;  ///< those that were matched
  calibrate::MachineFit fit;                 ///< of these
};

/// `evidence`: of a job; how the marks were passed follows from its plan. Errors: those
/// of ReadMarks; kUnsupported for a machine that has not three linear axes; those of
/// MatchMarks and FitMachine.
Result<Measurement> MeasureMachine(const Evidence& evidence, const MarksFile& marks);

}  // namespace intaglio::client
