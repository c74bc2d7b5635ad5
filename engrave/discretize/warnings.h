#pragma once

// What the counts of the methods mean for the person who engraves.

#include <string>
#include <vector>

#include "engrave/discretize/spacing/statistics.h"

namespace intaglio::discretize {

/// What a person should know of one model's points before they are engraved, a sentence
/// each with the remedy.
std::vector<std::string> WarningsOf(const MethodStatistics& statistics,
                                    double min_spacing_mm);

}  // namespace intaglio::discretize
