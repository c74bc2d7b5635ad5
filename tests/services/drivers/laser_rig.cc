#include "tests/services/drivers/laser_rig.h"

#include "tests/services/drivers/rig_row.h"

namespace intaglio::drivers {

std::unique_ptr<LaserController> LaserOf(std::unique_ptr<MotionDriver> both) {
  return std::unique_ptr<LaserController>(both.release()->laser());
}

std::unique_ptr<LaserRig> MakeLaserRig(std::string_view protocol,
                                       const std::string& serial_number) {
  return RigRow<LaserRig>::Make(protocol, serial_number);
}

}  // namespace intaglio::drivers
