#include "services/drivers/mark_driver.h"

#include "engrave/core/try.h"
#include "services/drivers/grbl/grbl_course_driver.h"
#include "services/platform/link/driver_table.h"

namespace intaglio::drivers {

std::span<const MarkDriverKind> MarkDriverKinds() {
  static constexpr MarkDriverKind kKinds[] = {
      {"grbl-course", true, MakeGrblCourseDriver, CheckGrblCourseProfile},
  };
  return kKinds;
}

Result<std::unique_ptr<MarkDriver>> MakeMarkDriver(const MachineSpec& machine) {
  const SerialLine& line = machine.mark_line();
  const auto kind = INTAGLIO_TRY(
      link::FindDriver(MarkDriverKinds(), {"mark_line", line.protocol(), line.device()}));
  return kind->make(machine, link::EndpointOpener(line.device(), line.baud()),
                    link::MonotonicClock());
}

}  // namespace intaglio::drivers
