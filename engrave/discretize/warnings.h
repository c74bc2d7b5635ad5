#pragma once

// Turns the counts of the methods into warnings for the user.

#include "engrave/core/warning.h"
#include "engrave/discretize/spacing/statistics.h"

namespace intaglio::discretize {

/// Warnings about one model's points before they are engraved.
Warnings WarningsOf(const MethodStatistics& statistics, double min_spacing_mm);

}  // namespace intaglio::discretize
