#include "tests/services/drivers/marks/mark_rig.h"

#include "tests/services/drivers/bjjcz/bjjcz_rig.h"
#include "tests/services/drivers/marks/course_mark_rig.h"
#include "tests/services/drivers/marks/head_rig.h"

namespace intaglio::drivers {

void MarkRig::Step() {
  constexpr int kPermitSteps = 20;
  AdvanceController();
  if (permits && ++steps_ % kPermitSteps == 0) (void)driver->Permit(true);
  driver->Poll();
  for (const MarkEvent& event : driver->TakeEvents()) events.push_back(event);
}

std::vector<std::string> MarkRigsOf(std::string_view protocol) {
  if (protocol == "grbl-course")
    return {"grbl_laser", "grbl_mill", "grbl_mill_that_homes"};
  if (protocol == "scan-head") return {"scan_head"};
  if (protocol == "bjjcz") return {"bjjcz_fibre", "bjjcz_uv"};
  return {};
}

std::unique_ptr<MarkRig> MakeMarkRig(const std::string& name,
                                     const std::string& serial_number) {
  if (name == "scan_head") return MakeHeadMarkRig(serial_number);
  if (name.starts_with("bjjcz")) return MakeBjjczMarkRig(name, serial_number);
  return MakeCourseMarkRig(name, serial_number);
}

}  // namespace intaglio::drivers
