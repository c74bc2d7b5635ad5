#pragma once

// What a measurement of a machine found, as lines for people.

#include <string>
#include <vector>

#include "proto/machine_report.pb.h"

namespace intaglio::cli {

/// The figures, each with its uncertainty.
std::vector<std::string> FigureLinesOf(const MachineMeasurement& report);
/// What the corrected profile has, what it cannot correct, and the files.
std::vector<std::string> OutcomeLinesOf(const MachineMeasurement& report);

}  // namespace intaglio::cli
