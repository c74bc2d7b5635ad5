#pragma once

// The checks of M14 to M16: motion by hand. A driver that cannot move its controller by
// hand passes them by saying so.

#include "tests/services/drivers/motion_bench.h"
#include "tests/services/drivers/motion_conformance.h"

namespace intaglio::drivers {

inline constexpr double kJogMm = 20;

/// Whether this family can be moved by hand; the bench is connected and at rest.
bool CanJog(MotionBench& bench);
/// A jog, kJogMm away along x, and a quarter of its way.
void JogAQuarter(MotionBench& bench, const Vec3& target);

void AJogGoesToItsPlaceAndRests(const MotionRigMaker& make);
void HoldEndsAJog(const MotionRigMaker& make);
void AJogIsRefusedDuringARunAndAfterAFault(const MotionRigMaker& make);
void ACutLineEndsAJog(const MotionRigMaker& make);

}  // namespace intaglio::drivers
