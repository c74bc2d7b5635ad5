#include "tests/services/drivers/motion_rig.h"

#include "tests/services/drivers/rig_row.h"

namespace intaglio::drivers {

std::unique_ptr<MotionRig> MakeMotionRig(std::string_view protocol,
                                         const std::string& serial_number) {
  return RigRow<MotionRig>::Make(protocol, serial_number);
}

}  // namespace intaglio::drivers
