#pragma once

// The figures of a report of a job of marks, from the content of its folder.

#include <vector>

#include "proto/report.pb.h"
#include "services/client/proof/marks/mark_evidence.h"

namespace intaglio::client {

/// As JobReport.evidence has it: what was burnt was compared with the plan.
inline constexpr const char* kMaterialEvidence = "material";

/// In the report.
inline constexpr std::size_t kMaxFindings = 20;

/// The report without outcomes, warnings and verdict. With the material every burnt tick
/// is measured; without it marks count as the journal has them, which the memory of the
/// controller settles, and nothing is known of places.
JobReport FiguresOf(const MarkEvidence& evidence);

/// Places of marks, the gravest first: those that are not as planned, then those that
/// were made with errors beyond the tolerance, then by their largest error; at most
/// `count`.
std::vector<std::size_t> GravestMarks(const MarkEvidence& evidence, std::size_t count);

/// The largest of place, shape, gap and diameter, um.
double LargestErrorUm(const proof::BurntMark& mark);

/// made, skipped, missed, incomplete, doubled, uncertain.
const char* OutcomeName(proof::MarkOutcome outcome);

}  // namespace intaglio::client
