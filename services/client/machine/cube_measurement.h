#pragma once

// What is wrong with a scan head over a block, from the folder of a job that made its
// test cube and from the filled table of the cube.

#include <filesystem>
#include <vector>

#include "engrave/calibrate/cube_fit.h"
#include "engrave/core/result.h"
#include "proto/machine_report.pb.h"
#include "services/client/machine/corrected_profile.h"
#include "services/client/machine/measured_cube.h"
#include "services/client/proof/evidence/proof_evidence.h"

namespace intaglio::client {

struct CubeMeasurement {
  MachineMeasurement report;
  CorrectedProfile corrected;
  std::vector<MeasuredCubeMark> marks;
};

/// `evidence`: of a job of a machine with head_over_block. Errors: those of
/// ReadMeasuredCube and FitCube; kInvalidValue for a mark that is none of the job's.
Result<CubeMeasurement> MeasureCube(const Evidence& evidence,
                                    const std::filesystem::path& table,
                                    calibrate::KnownOfHead known);

}  // namespace intaglio::client
