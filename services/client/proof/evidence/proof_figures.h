#pragma once

// The figures of a report, from the content of a job's folder.

#include <string>

#include "engrave/core/geometry.h"
#include "proto/report.pb.h"
#include "services/client/proof/evidence/proof_evidence.h"

namespace intaglio::client {

/// On what a report rests, as JobReport.evidence has it.
inline constexpr const char* kGlassEvidence = "glass";
inline constexpr const char* kControllerEvidence = "controller";

/// The report without outcomes, warnings and verdict. With the glass, every crack is
/// measured; without it, points count as the journal has them, which the laser
/// controller's counters settle, and nothing is known of positions and strays.
/// With the glass it releases each part of the evidence when that is measured, because
/// all of them together with what the measurements need are several times the cloud. What
/// is left then is what the pictures need: job, cracks.positions_mm, cracks.channels.
JobReport FiguresOf(Evidence& evidence);

/// CRC-32 of the coordinates in their order, hexadecimal: equal for equal points in the
/// same order, bit for bit. The report's checksums "path" and "glass".
std::string PointChecksum(const PointList& points_mm);

}  // namespace intaglio::client
