#pragma once

// Commands that lead the servo of a mirror, so that the beam is where it is to be. A
// servo of two equal poles follows c with y, c = y + tau y' + tau^2 / 4 y''; a command
// that is held for a period T acts T / 2 later, which is led too. Derivatives are central
// differences of the sequence.

#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::galvo {

/// Replaces places by the commands that make them. `lag_s` > 0, `period_s` > 0; the
/// sequence rests before its first and behind its last place.
void LeadServo(double lag_s, double period_s, std::vector<Vec2>& places_mm);

}  // namespace intaglio::galvo
