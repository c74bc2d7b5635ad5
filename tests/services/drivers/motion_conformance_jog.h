#pragma once

// The checks of M14 to M16: motion by hand. A driver that cannot move its controller by
// hand passes them by saying so.

#include "tests/services/drivers/motion_conformance.h"

namespace intaglio::drivers {

void AJogGoesToItsPlaceAndRests(const MotionRigMaker& make);
void HoldEndsAJog(const MotionRigMaker& make);
void AJogIsRefusedDuringARunAndAfterAFault(const MotionRigMaker& make);
void ACutLineEndsAJog(const MotionRigMaker& make);

}  // namespace intaglio::drivers
