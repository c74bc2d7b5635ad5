#include "services/drivers/mark_drivers.h"

#include <utility>

#include "engrave/core/try.h"
#include "services/drivers/bjjcz/bjjcz_driver.h"
#include "services/drivers/bjjcz/board_profile.h"
#include "services/drivers/galvo/galvo_driver.h"
#include "services/drivers/galvo/head_profile.h"
#include "services/drivers/grbl/marks/grbl_course_driver.h"
#include "services/drivers/linuxcnc/hal_limits.h"
#include "services/drivers/linuxcnc/marks/course_profile.h"
#include "services/drivers/linuxcnc/marks/linuxcnc_course_driver.h"
#include "services/platform/link/driver_table.h"

namespace intaglio::drivers {

namespace {

constexpr MarkDriverKind kMarkKinds[] = {
    {"bjjcz", true, MakeBjjczDriver, CheckBjjczProfile},
    {"grbl-course", true, MakeGrblCourseDriver, CheckGrblCourseProfile},
    {"linuxcnc-course", false, MakeLinuxcncCourseDriver, CheckLinuxcncCourseProfile,
     CompareLinuxcncCourse},
    {"scan-head", true, MakeGalvoDriver, CheckScanHead},
};

}  // namespace

std::span<const MarkDriverKind> MarkDriverKinds() { return kMarkKinds; }

Result<std::unique_ptr<MarkDriver>> MakeMarkDriver(const MachineSpec& machine) {
  const SerialLine& line = machine.mark_line();
  const auto kind = INTAGLIO_TRY(
      link::FindDriver(MarkDriverKinds(), {"mark_line", line.protocol(), line.device()}));
  if (kind->check != nullptr) {
    for (Error& error : kind->check(machine)) return tl::unexpected(std::move(error));
  }
  return kind->make(machine, link::EndpointOpener(line.device(), line.baud()),
                    link::MonotonicClock());
}

}  // namespace intaglio::drivers
