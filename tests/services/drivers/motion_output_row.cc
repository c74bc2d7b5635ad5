#include "services/drivers/interface/laser_controller.h"
#include "tests/services/cell/one_controller_rig.h"
#include "tests/services/drivers/motion_output_rig.h"
#include "tests/services/drivers/rig_row.h"

namespace intaglio::drivers {
namespace {

const RigRow<LaserRig> kMotionOutputRow{
    std::string(kMotionOutput), std::string(kMotionOutput),
    [](const std::string& /*name*/,
       const std::string& serial_number) -> std::unique_ptr<LaserRig> {
      return std::make_unique<MotionOutputRig>(cell::MakeOneControllerLaserRig(),
                                               CutLineOf::kSynchronizer, serial_number);
    }};

}  // namespace
}  // namespace intaglio::drivers
