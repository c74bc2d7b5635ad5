#pragma once

// The position tolerance is known in two places: the machine profile has it for the plan
// and the report, the stage controller decides by its own whether a pulse may be fired.
// They have to be the same.

#include <string>

namespace intaglio {

/// What differs and what to do, in one sentence; empty: they agree within 1 %, or one of
/// them is not known (0). Both um.
std::string ToleranceMismatch(double controller_um, double profile_um);

}  // namespace intaglio
