#pragma once

// A virtual BJJCZ board at the driver of its family, behind a line that a test cuts.

#include <memory>
#include <string>

#include "proto/machine.pb.h"
#include "services/drivers/interface/mark_driver.h"
#include "tests/services/drivers/bjjcz/bjjcz_machine.h"
#include "tests/services/drivers/marks/mark_rig.h"

namespace intaglio::drivers {

/// A field of 100 mm, jumps of 5 m/s.
MachineSpec BjjczProfile(BjjczLaser laser);

std::unique_ptr<MarkDriver> MakeBjjczDriverAt(BjjczMachine& machine,
                                              const MachineSpec& profile);

std::unique_ptr<MarkRig> MakeBjjczMarkRigOf(const MachineSpec& profile);
std::unique_ptr<MarkRig> MakeBjjczMarkRig(const std::string& name,
                                          const std::string& serial_number);

}  // namespace intaglio::drivers
