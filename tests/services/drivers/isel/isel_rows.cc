#include "tests/services/drivers/isel/isel_rig.h"
#include "tests/services/drivers/rig_row.h"

namespace intaglio::drivers {
namespace {

const RigRow<MotionRig> kIselMotion{"isel", "isel", &MakeIselMotionRig};
const RigRow<LaserRig> kIselLaser{"isel", "isel", &MakeIselLaserRig};

}  // namespace
}  // namespace intaglio::drivers
