#pragma once

// Turns the counts of the methods into warnings for the user.

#include <string>
#include <vector>

#include "engrave/discretize/spacing/statistics.h"

namespace intaglio::discretize {

/// Warnings about one model's points before they are engraved, one sentence each with the
/// remedy.
std::vector<std::string> WarningsOf(const MethodStatistics& statistics,
                                    double min_spacing_mm);

}  // namespace intaglio::discretize
