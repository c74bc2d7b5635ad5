#include "services/job/machine/head_warnings.h"

#include <fmt/format.h>

#include "services/job/machine/head_ticks.h"

namespace intaglio {

std::vector<Error> HeadWarningsOf(const MachineSpec& machine) {
  const auto ticks = TickOptionsOf(machine.scan_head(), mark::Pen(), 1e5);
  const bool burns_jumps = ticks.lag_s > 0 && !ticks.lead_servo && ticks.run_in_s == 0 &&
                           ticks.jump_delay_s == 0;
  if (!burns_jumps) return {};
  return {{ErrorCode::kInvalidValue,
           fmt::format("scan_head.run_in_s: 0, with no scan_head.jump_delay_s and no "
                       "scan_head.lead_servo: the mirrors are {:g} s behind, so the end "
                       "of each jump is burnt; give a run-in or a jump delay of {:g} s "
                       "or more, or remove lead_servo: false",
                       ticks.lag_s, 3 * ticks.lag_s),
           "0"}};
}

}  // namespace intaglio
