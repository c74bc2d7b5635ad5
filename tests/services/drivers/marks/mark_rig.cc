#include "tests/services/drivers/marks/mark_rig.h"

#include "tests/services/drivers/rig_row.h"

namespace intaglio::drivers {

void MarkRig::Step() {
  constexpr int kPermitSteps = 20;
  AdvanceController();
  if (permits && ++steps_ % kPermitSteps == 0) (void)driver->Permit(true);
  driver->Poll();
  for (const MarkEvent& event : driver->TakeEvents()) events.push_back(event);
}

std::vector<std::string> MarkRigsOf(std::string_view protocol) {
  return RigRow<MarkRig>::NamesOf(protocol);
}

std::unique_ptr<MarkRig> MakeMarkRig(const std::string& name,
                                     const std::string& serial_number) {
  return RigRow<MarkRig>::Make(name, serial_number);
}

}  // namespace intaglio::drivers
